// The few things a page needs: escaped text, numbers that are never "nan", images inside the page.
//   out += "<td>" + html::text(mark.name) + "</td>";
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace gantry::record::html {

/// Text for element content and quoted attributes, clean as core/clean_text.hpp has it.
std::string text(std::string_view raw);
/// Fixed decimals; a dash for what is not finite. Never "-0.000".
std::string number(double value, int decimals);
/// "12.3 µm" from mm, "1.234 mm" from a millimetre on.
std::string micrometres(double mm);
/// "850 ns", "12.3 µs", "1.24 ms".
std::string duration(double ns);
std::string base64(std::span<const std::byte> bytes);

}  // namespace gantry::record::html
