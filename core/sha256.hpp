// SHA-256 of what a job was made from, so that a board can be traced to the very bytes (FIPS 180-4; OpenSSL's).
//   sha256_hex("abc")   ->   "ba7816bf 8f01cfea ..." without the blanks
#pragma once
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;  // OpenSSL's

namespace gantry {

std::string sha256_hex(std::string_view bytes);

/// Of bytes that come piece by piece.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// Of all that was added; asked once.
  [[nodiscard]] std::string hex();

 private:
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};
/// Of a file's bytes; "" when it cannot be read.
std::string sha256_of_file(const std::string& path);

}  // namespace gantry
