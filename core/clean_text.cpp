#include "core/clean_text.hpp"

#include <cstdint>
#include <fmt/format.h>

namespace gantry {
namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  ///< 0: it is no UTF-8
};

/// The first character of a text that is not empty (Unicode 15, 3.9: shortest form, no surrogates, to 10FFFFh).
Character first_of(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  char32_t code = lead & (0xFFu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0u) != 0x80) return {};
    code = code << 6u | (next & 0x3Fu);
  }
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[bytes] || (code >= 0xD800 && code <= 0xDFFF) || code > 0x10FFFF) return {};
  return {code, bytes};
}

/// Unicode 15, 23.1 (control codes), and UAX #9, 2 (directional formatting), with line and paragraph separators.
bool steers(char32_t c) {
  return c < 0x20 || (c >= 0x7F && c <= 0x9F) || c == 0x061C || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

/// Each character, or byte that is none, as `write` adds it.
template <class Write>
std::string rewritten(std::string_view text, Write&& write) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_of(text);
    const std::size_t bytes = c.bytes == 0 ? 1 : c.bytes;
    write(out, c, text.substr(0, bytes));
    text.remove_prefix(bytes);
  }
  return out;
}

}  // namespace

std::string clean_text(std::string_view text) {
  return rewritten(text, [](std::string& out, const Character& c, std::string_view as_it_is) {
    if (c.code == '\n' || c.code == '\t' || c.code == '\r')
      out += ' ';
    else
      out += c.bytes == 0 || steers(c.code) ? "\xEF\xBF\xBD" : as_it_is;
  });
}

std::string escape_steering(std::string_view json) {
  return rewritten(json, [](std::string& out, const Character& c, std::string_view as_it_is) {
    if (c.code >= 0x20 && steers(c.code))
      out += fmt::format("\\u{:04x}", static_cast<std::uint32_t>(c.code));
    else
      out += as_it_is;
  });
}

std::string clean_lines(std::string_view text) {
  std::string out;
  for (auto end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    out += clean_text(text.substr(0, end)) + '\n';
    text.remove_prefix(end + 1);
  }
  return out + clean_text(text);
}

}  // namespace gantry
