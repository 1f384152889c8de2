// SHA-256 of what a job was made from, so that a board can be traced to the very bytes (FIPS 180-4; OpenSSL's).
//   sha256_hex("abc")   ->   "ba7816bf 8f01cfea ..." without the blanks
#pragma once
#include <string>
#include <string_view>

namespace gantry {

std::string sha256_hex(std::string_view bytes);
/// Of a file's bytes; "" when it cannot be read.
std::string sha256_of_file(const std::string& path);

}  // namespace gantry
