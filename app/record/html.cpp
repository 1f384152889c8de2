#include "app/record/html.hpp"

#include <cmath>
#include <fmt/format.h>

#include "core/clean_text.hpp"

namespace gantry::record::html {

std::string text(std::string_view raw) {
  std::string out;
  out.reserve(raw.size() + 16);
  for (const char c : clean_text(raw)) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += c;
  }
  return out;
}

std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  auto s = fmt::format("{:.{}f}", value, decimals);
  if (s.starts_with('-') && s.find_first_not_of("-0.") == std::string::npos) s.erase(0, 1);
  return s;
}

std::string micrometres(double mm) {
  if (!std::isfinite(mm)) return number(mm, 0);
  return std::abs(mm) >= 1 ? number(mm, 3) + " mm" : number(mm * 1000, 1) + " µm";
}

std::string duration(double ns) {
  if (ns < 1e3) return number(ns, 0) + " ns";
  if (ns < 1e6) return number(ns / 1e3, 1) + " µs";
  return number(ns / 1e6, 2) + " ms";
}

std::string base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63u];
  }
  return out;
}

}  // namespace gantry::record::html
