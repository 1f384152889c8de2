#include "core/units.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "core/trimmed.hpp"

namespace gantry::units {
namespace {

constexpr double kPi = std::numbers::pi;

struct Unit {
  Dimension dimension;
  std::string_view text;
  double factor;  // house units in one of it
};

// The first row of a dimension is the unit of the house; it is what messages show.
constexpr std::array kUnits{
    Unit{Dimension::Length, "mm", 1.0},
    Unit{Dimension::Length, "um", 1e-3},
    Unit{Dimension::Length, "µm", 1e-3},
    Unit{Dimension::Length, "m", 1e3},
    Unit{Dimension::Angle, "rad", 1.0},
    Unit{Dimension::Angle, "deg", kPi / 180},
    Unit{Dimension::Time, "s", 1.0},
    Unit{Dimension::Time, "ms", 1e-3},
    Unit{Dimension::Time, "us", 1e-6},
    Unit{Dimension::Time, "µs", 1e-6},
    Unit{Dimension::Speed, "mm/s", 1.0},
    Unit{Dimension::Speed, "m/s", 1e3},
    Unit{Dimension::Speed, "mm/min", 1.0 / 60},
    Unit{Dimension::Acceleration, "mm/s^2", 1.0},
    Unit{Dimension::Acceleration, "mm/s²", 1.0},
    Unit{Dimension::Acceleration, "m/s^2", 1e3},
    Unit{Dimension::Acceleration, "m/s²", 1e3},
    Unit{Dimension::Jerk, "mm/s^3", 1.0},
    Unit{Dimension::Jerk, "mm/s³", 1.0},
    Unit{Dimension::Jerk, "m/s^3", 1e3},
    Unit{Dimension::Jerk, "m/s³", 1e3},
    Unit{Dimension::AngularSpeed, "rad/s", 1.0},
    Unit{Dimension::AngularSpeed, "deg/s", kPi / 180},
    Unit{Dimension::AngularSpeed, "rpm", 2 * kPi / 60},
    Unit{Dimension::AngularAcceleration, "rad/s^2", 1.0},
    Unit{Dimension::AngularAcceleration, "deg/s^2", kPi / 180},
    Unit{Dimension::AngularAcceleration, "deg/s²", kPi / 180},
    Unit{Dimension::AngularJerk, "rad/s^3", 1.0},
    Unit{Dimension::AngularJerk, "deg/s^3", kPi / 180},
    Unit{Dimension::AngularJerk, "deg/s³", kPi / 180},
    Unit{Dimension::Ratio, "%", 0.01},
};

std::string accepted(Dimension dimension) {
  std::string list;
  for (const std::string_view unit : symbols(dimension)) list += (list.empty() ? "" : ", ") + std::string(unit);
  return list;
}

/// Octal-looking ("010"), hexadecimal, nan and inf are refused: YAML readers disagree about them.
bool plain_decimal(std::string_view number) {
  if (!number.empty() && (number.front() == '-' || number.front() == '+')) number.remove_prefix(1);
  if (number.empty() || number.find_first_not_of("0123456789.eE+-") != std::string_view::npos) return false;
  return !(number.size() > 1 && number[0] == '0' && number[1] >= '0' && number[1] <= '9');
}

/// Signs that look like a blank, a minus or nothing at all, as word processors and web pages write them.
struct LookAlike {
  std::string_view sign, name, remedy;
};
constexpr std::string_view kBlank = "write a plain blank", kMinus = "write '-'", kNothing = "take it away";
constexpr std::array kLookAlikes{
    LookAlike{"\u00A0", "a no-break space (U+00A0)", kBlank},
    LookAlike{"\u202F", "a narrow no-break space (U+202F)", kBlank},
    LookAlike{"\u2007", "a figure space (U+2007)", kBlank},
    LookAlike{"\u2009", "a thin space (U+2009)", kBlank},
    LookAlike{"\u200A", "a hair space (U+200A)", kBlank},
    LookAlike{"\u3000", "an ideographic space (U+3000)", kBlank},
    LookAlike{"\u200B", "a zero-width space (U+200B)", kNothing},
    LookAlike{"\u2060", "a word joiner (U+2060)", kNothing},
    LookAlike{"\uFEFF", "a byte-order mark (U+FEFF)", kNothing},
    LookAlike{"\u2212", "a minus sign (U+2212)", kMinus},
    LookAlike{"\u2010", "a hyphen (U+2010)", kMinus},
    LookAlike{"\u2011", "a no-break hyphen (U+2011)", kMinus},
    LookAlike{"\u2013", "an en dash (U+2013)", kMinus},
};

}  // namespace

std::string_view name(Dimension dimension) {
  for (const Unit& u : kUnits)
    if (u.dimension == dimension) return u.text;
  return "";
}

std::vector<std::string_view> symbols(Dimension dimension) {
  std::vector<std::string_view> list;
  for (const Unit& u : kUnits)
    if (u.dimension == dimension) list.push_back(u.text);
  return list;
}

std::string_view example(Dimension dimension) {
  switch (dimension) {
    case Dimension::None: return "3";
    case Dimension::Length: return "12.5 mm";
    case Dimension::Angle: return "90 deg";
    case Dimension::Time: return "15 ms";
    case Dimension::Speed: return "20 mm/s";
    case Dimension::Acceleration: return "3000 mm/s^2";
    case Dimension::Jerk: return "50000 mm/s^3";
    case Dimension::AngularSpeed: return "180 deg/s";
    case Dimension::AngularAcceleration: return "1000 deg/s^2";
    case Dimension::AngularJerk: return "20000 deg/s^3";
    case Dimension::Ratio: return "5 %";
  }
  return "";
}

Result<double> parse(std::string_view text, Dimension dimension) {
  const std::string_view all = trimmed(text);
  for (const LookAlike& like : kLookAlikes)
    if (all.find(like.sign) != std::string_view::npos)
      return fail(Fault::BadValue, fmt::format("'{}' has {} in it; {}, for example '{}'", all, like.name, like.remedy,
                                               example(dimension)));
  // The number ends where neither digit, sign, point nor exponent goes on; "1e3 mm" and "1e3mm" both read.
  std::size_t end = 0;
  while (end < all.size()) {
    const char c = all[end];
    const bool exponent = (c == 'e' || c == 'E') && end + 1 < all.size() &&
                          ((all[end + 1] >= '0' && all[end + 1] <= '9') || all[end + 1] == '-' || all[end + 1] == '+');
    const bool sign = (c == '-' || c == '+') && (end == 0 || all[end - 1] == 'e' || all[end - 1] == 'E');
    if (!((c >= '0' && c <= '9') || c == '.' || exponent || sign)) break;
    ++end;
  }
  std::string_view number = all.substr(0, end);
  const std::string_view unit = trimmed(all.substr(end));
  if (!plain_decimal(number))
    return fail(Fault::BadValue, fmt::format("'{}' is not a number; write for example '{}'", all, example(dimension)));
  if (number.front() == '+') number.remove_prefix(1);
  double value = 0;
  const auto [rest, ec] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (ec != std::errc{} || rest != number.data() + number.size() || !std::isfinite(value))
    return fail(Fault::BadValue, fmt::format("'{}' is not a number; write for example '{}'", all, example(dimension)));
  if (dimension == Dimension::None) {
    if (unit.empty()) return value;
    return fail(Fault::BadUnit, fmt::format("'{}' is a plain number here; leave out the unit '{}'", all, unit));
  }
  if (unit.starts_with(','))
    return fail(Fault::BadValue,
                fmt::format("'{}' has a decimal comma; write a point, for example '{}'", all, example(dimension)));
  if (unit.empty())
    return fail(Fault::BadUnit, fmt::format("'{}' lacks a unit; write for example '{}' (units: {})", all,
                                            example(dimension), accepted(dimension)));
  for (const Unit& u : kUnits)
    if (u.dimension == dimension && u.text == unit) return value * u.factor;
  return fail(Fault::BadUnit, fmt::format("'{}' is not a unit that fits here; write for example '{}' (units: {})", unit,
                                          example(dimension), accepted(dimension)));
}

}  // namespace gantry::units
