# Writes a header with what a page holds, so that the program needs no file beside it:
#   cmake -DOUT=page_assets.hpp -DNAMESPACE=gantry::record -DTEXTS="kScript=scene.js|kCss=scene.css"
#         -DPACKED_NAME=kLibrary -DPACKED="a.js|b.js" -P embed.cmake
# A text becomes a string_view of its own. PACKED becomes one: all files one after the other, gzip, base64; and
# PACKED_NAME with Sha256 at its end what SHA-256 gives for them unpacked, in hex.
set(code "#pragma once\n#include <string_view>\n\nnamespace ${NAMESPACE} {\n\n")
string(REPLACE "|" ";" texts "${TEXTS}")
foreach(text IN LISTS texts)
  string(REGEX MATCH "^([^=]+)=(.*)$" _ "${text}")
  set(name "${CMAKE_MATCH_1}")
  set(file "${CMAKE_MATCH_2}")
  file(READ "${file}" content)
  # What would end the page's element, or begin a comment in it.
  string(REGEX MATCH "</|<!--|\\)asset\"" bad "${content}")
  if(bad)
    message(FATAL_ERROR "${file} holds '${bad}', which cannot stand inside a page")
  endif()
  string(APPEND code "inline constexpr std::string_view ${name} = R\"asset(${content})asset\";\n\n")
endforeach()

string(REPLACE "|" ";" packed "${PACKED}")
set(whole "${OUT}.unpacked")
execute_process(COMMAND cat ${packed} OUTPUT_FILE "${whole}" COMMAND_ERROR_IS_FATAL ANY)
file(SHA256 "${whole}" hash)
execute_process(COMMAND gzip -9n INPUT_FILE "${whole}" COMMAND base64 -w0 OUTPUT_VARIABLE base64 COMMAND_ERROR_IS_FATAL ANY)
string(APPEND code "inline constexpr std::string_view ${PACKED_NAME} = R\"asset(${base64})asset\";\n\n")
string(APPEND code "inline constexpr std::string_view ${PACKED_NAME}Sha256 = \"${hash}\";\n\n}  // namespace ${NAMESPACE}\n")
file(WRITE "${OUT}" "${code}")
