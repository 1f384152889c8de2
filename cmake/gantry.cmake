# How every library, program and test of the project is made: warnings, sanitizers, and the rules of the RT side.
find_package(Threads REQUIRED)
find_package(tl-expected REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(CLI11 REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(gantry_flags INTERFACE)
target_include_directories(gantry_flags INTERFACE ${CMAKE_SOURCE_DIR})
# -Wrestrict of g++ 12 warns of every "literal" + std::string that it inlines (GCC bug 105651).
target_compile_options(gantry_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wno-psabi -Wno-restrict>
  $<$<AND:$<BOOL:${GANTRY_WERROR}>,$<COMPILE_LANGUAGE:CXX>>:-Werror>)
if(GANTRY_SANITIZE)
  target_compile_options(gantry_flags INTERFACE -fsanitize=${GANTRY_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(gantry_flags INTERFACE -fsanitize=${GANTRY_SANITIZE})
  if(GANTRY_SANITIZE MATCHES thread)
    # TSan does not model fences and says so; what core/rt/latest.hpp orders by them is atomic itself, so no race is missed.
    target_compile_options(gantry_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-tsan>)
  endif()
endif()

# gantry_compile_alone(a.cpp ...): files of this folder whose unnamed namespaces hold names that a neighbour has, too.
# Where files are compiled together (below, and everywhere in the presets release and asan) these are not.
function(gantry_compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# Where nobody waits at run time: a third less of compile time.
function(gantry_optimise_little target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# Verbs and tests are built for the build to be quick: up to six files at once, so that the headers that they share
# (CLI11, json, GoogleTest) are read once.
function(gantry_build_quickly target)
  gantry_optimise_little(${target})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
endfunction()

# gold links a program in a third of the time; it comes with the linker that every g++ needs.
find_program(GOLD ld.gold)
if(GOLD)
  add_link_options(-fuse-ld=gold)
endif()

# gantry_library(NAME SOURCES a.cpp ... DEPS other ...): an ordinary room.
function(gantry_library name)
  cmake_parse_arguments(A "" "" "SOURCES;DEPS" ${ARGN})
  add_library(${name} STATIC ${A_SOURCES})
  target_link_libraries(${name} PUBLIC gantry_flags ${A_DEPS})
endfunction()

# gantry_rt_library(NAME SOURCES a.cpp ... DEPS rt libraries ...): a room of the 1 ms loop. Built without exceptions and
# RTTI, and its undefined symbols pass cmake/rt_gate.sh (tests/architecture runs it over all of them at once).
function(gantry_rt_library name)
  gantry_library(${name} ${ARGN})
  target_compile_options(${name} PRIVATE -fno-exceptions -fno-rtti)
  set_property(GLOBAL APPEND PROPERTY GANTRY_RT_LIBRARIES ${name})
endfunction()

# Where every target has the same flags as the one whose headers it reuses: those of the rig and of its tests.
function(gantry_rig_headers target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
  target_precompile_headers(${target} ${ARGN})
endfunction()

# Before the command of a test in real time.
set(GANTRY_ON_A_CALM_HOST python3 ${CMAKE_SOURCE_DIR}/tests/calm_host.py)

include(long_tests)

# gantry_test(NAME SOURCES a_test.cpp ... DEPS libs ... LABELS unit machine ... TIMEOUT s REAL_TIME): one GoogleTest
# program; REAL_TIME: alone, and again where the host stood still.
# Labels that scripts know: `sanitized` (scripts/test runs the test a second time under ASan and UBSan, so it is a quick
# one), `threads` (scripts/tsan runs it). The target tests.LABEL builds all tests of a label.
# A test of whole machines (DEPS gantry_test_rig) leaves the work to libraries: it is not optimised itself, and the rig's
# headers are read once for all of them. The other tests share GoogleTest's.
set(GANTRY_SANITIZED_DIR "" CACHE PATH "Build folder that holds the sanitized twins of tests labelled `sanitized`")
function(gantry_test name)
  cmake_parse_arguments(A "REAL_TIME" "TIMEOUT" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT A_LABELS)
    set(A_LABELS unit)
  endif()
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 600)  # only for what hangs: a machine may be busy
  endif()
  add_executable(${name} ${A_SOURCES})
  target_link_libraries(${name} PRIVATE gantry_flags ${A_DEPS} GTest::gtest GTest::gtest_main)
  gantry_build_quickly(${name})
  if("gantry_test_rig" IN_LIST A_DEPS)
    gantry_rig_headers(${name} REUSE_FROM gantry_test_rig)
  else()
    target_precompile_headers(${name} REUSE_FROM gantry_test_headers)
  endif()
  target_compile_definitions(${name} PRIVATE GANTRY_SOURCE_DIR="${CMAKE_SOURCE_DIR}" GANTRY_BINARY_DIR="${CMAKE_BINARY_DIR}")
  if(A_REAL_TIME)
    add_test(NAME ${name} COMMAND ${GANTRY_ON_A_CALM_HOST} $<TARGET_FILE:${name}> WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
    set_tests_properties(${name} PROPERTIES RUN_SERIAL ON)
  else()
    add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
    gantry_schedule(${name} COMPUTES)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${A_LABELS}" TIMEOUT ${A_TIMEOUT})
  foreach(label ${A_LABELS})
    if(NOT TARGET tests.${label})
      add_custom_target(tests.${label})
    endif()
    add_dependencies(tests.${label} ${name})
  endforeach()
  if(GANTRY_SANITIZED_DIR AND "sanitized" IN_LIST A_LABELS)
    add_test(NAME ${name}.sanitized COMMAND ${GANTRY_SANITIZED_DIR}/bin/${name} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
    set_tests_properties(${name}.sanitized PROPERTIES LABELS "${A_LABELS}" TIMEOUT ${A_TIMEOUT})
    gantry_schedule(${name}.sanitized COMPUTES)
  endif()
endfunction()
