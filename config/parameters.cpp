// Parameters of a station: the rows of its profile, with what the machine file states instead, as the start-up rows of
// that station. Values are read here, in the unit of the profile's row.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "config/homing_rows.hpp"
#include "config/machine_file.hpp"
#include "core/near_word.hpp"

namespace gantry::config {
namespace {

using written::SettingRow;

struct Bounds {
  std::int64_t low, high;
};
Bounds bounds_of(const StationProfile& profile, const Parameter& p) {
  const int width = bits(p.type);
  const bool minus = is_signed(p.type);
  Bounds b{minus ? -(std::int64_t{1} << (width - 1)) : 0, (std::int64_t{1} << (minus ? width - 1 : width)) - 1};
  if (const ObjectRow* object = find_object(profile, p.address)) {
    b.low = std::max(b.low, object->min.value_or(b.low));
    b.high = std::min(b.high, object->max.value_or(b.high));
  }
  return b;
}

/// As one would write it: "2.1 A", "10000".
std::string as_setting(const Parameter& p, std::int64_t value) {
  const double v = static_cast<double>(value) / p.per_unit;
  return p.unit.empty() ? fmt::format("{:.9g}", v) : fmt::format("{:.9g} {}", v, p.unit);
}

/// "2.1 A" of a row in A, "0x17" or "23" of one without a unit.
std::optional<double> number_of(std::string_view text, std::string_view unit) {
  const auto blank = [](char c) { return c == ' '; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  if (!unit.empty()) {
    if (!text.ends_with(unit)) return std::nullopt;
    text.remove_suffix(unit.size());
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  }
  const char *from = text.data(), *to = from + text.size();
  if (text.starts_with("0x")) {
    std::uint32_t hex = 0;
    const auto [end, error] = std::from_chars(from + 2, to, hex, 16);
    if (error != std::errc{} || end != to) return std::nullopt;
    return hex;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(from, to, value);
  if (error != std::errc{} || end != to || !std::isfinite(value)) return std::nullopt;
  return value;
}

class Parameters {
 public:
  Parameters(StationProfile& profile, Mistakes& mistakes) : profile_(profile), mistakes_(mistakes) {}

  void resolve(const written::StationRow& row) {
    if (!known(row)) return;
    for (const auto& each : row.declared) profile_.declared.push_back(each.value);
    for (const Parameter& p : profile_.parameters) {
      const auto setting = std::ranges::find(row.parameters, p.name, &SettingRow::name);
      const bool stated = setting != row.parameters.end();
      const bool declared = std::ranges::count(profile_.declared, p.name) > 0;
      if (!stated && p.must_be_stated) profile_.not_stated.push_back(p.name);
      if (stated && (setting->unread || !fits_slots(*setting))) continue;
      for (int slot = 0; slot < std::max(profile_.slots, 1); ++slot) {
        const ObjectAddress address = in_slot(profile_, p.address, slot);
        if (slot > 0 && address == p.address) break;
        auto value = p.value;
        if (stated) value = read(p, *setting, slot);
        if (stated && !value && setting->values.size() == 1) break;  // it is told, and is the same for all
        if (value) profile_.startup.push_back({address, p.type, *value, p.why, p.name, p.rule, p.acts, declared});
      }
    }
    layout(row);
  }

 private:
  /// Several names that the profile has not are one mistake: most often it is the profile that is another one.
  bool known(const written::StationRow& row) {
    std::vector<std::string_view> names;
    for (const Parameter& p : profile_.parameters) names.push_back(p.name);
    std::vector<std::string> unknown;
    Location first;
    const auto look = [&](const std::string& name, Location location) {
      if (std::ranges::find(names, name) != names.end() || std::ranges::find(unknown, name) != unknown.end()) return;
      if (unknown.empty()) first = location;
      unknown.push_back(name);
    };
    for (const SettingRow& setting : row.parameters) look(setting.name, setting.location);
    if (profile_.drive && unknown.empty())  // what homing sets is the axis', and may be declared here, not stated
      for (const HomingRow& homing : kHomingRows) names.push_back(homing.name);
    for (const auto& name : row.declared) look(name.value, name.location);
    if (unknown.empty()) return true;
    if (unknown.size() == 1) {
      mistakes_.add(Fault::UnknownReference,
                    fmt::format("{} has no parameter '{}'; {}", profile_.title, unknown[0],
                                did_you_mean(unknown[0], {names.begin(), names.end()})),
                    first);
      return true;
    }
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("{} has no parameters '{}'; is another profile meant than '{}'? Of '{}': {}",
                              profile_.title, fmt::join(unknown, "', '"), row.profile.value, unknown[0],
                              did_you_mean(unknown[0], {names.begin(), names.end()})),
                  first);
    profile_ = {};  // what else does not go with it would be the same mistake
    return false;
  }

  bool fits_slots(const SettingRow& setting) {
    const auto axes = static_cast<std::size_t>(std::max(profile_.slots, 1));
    if (setting.values.size() == 1 || setting.values.size() == axes) return true;
    mistakes_.add(
        Fault::BadValue,
        fmt::format("{} values stand here; {} has {}: write one for all, or one for each axis", setting.values.size(),
                    profile_.title, axes == 1 ? "one axis" : fmt::format("{} axes", axes)),
        setting.location);
    return false;
  }

  std::optional<std::int64_t> read(const Parameter& p, const SettingRow& setting, int slot) {
    const auto& [text, location] =
        setting.values.size() == 1 ? setting.values[0] : setting.values[static_cast<std::size_t>(slot)];
    const Bounds b = bounds_of(profile_, p);
    const auto number = number_of(text, p.unit);
    if (!number) {
      mistakes_.add(p.unit.empty() ? Fault::BadValue : Fault::BadUnit,
                    fmt::format("'{}' is no value of {}; write for example '{}'", shortened(text, 40), p.name,
                                as_setting(p, p.value.value_or(b.high / 2))),
                    location);
      return std::nullopt;
    }
    const double raw = *number * p.per_unit;
    if (!(raw >= static_cast<double>(b.low) && raw <= static_cast<double>(b.high))) {
      mistakes_.add(
          Fault::OutOfRange,
          fmt::format("{} of {} is outside {} .. {}", p.name, text, as_setting(p, b.low), as_setting(p, b.high)),
          location);
      return std::nullopt;
    }
    const std::int64_t value = std::llround(raw);
    if (std::abs(raw - static_cast<double>(value)) > 1e-6 * std::max(1.0, std::abs(raw))) {
      mistakes_.add(
          Fault::BadValue,
          fmt::format("{} takes steps of {}; the nearest is {}", p.name, as_setting(p, 1), as_setting(p, value)),
          location);
      return std::nullopt;
    }
    return value;
  }

  /// Which bits of 60FDh are which switch: what the drive's input functions make of them.
  void layout(const written::StationRow& row) {
    if (!row.inputs) return;
    if (!profile_.drive) {
      mistakes_.add(Fault::Inconsistent, "only a drive has limit and home switches", row.inputs->location);
      return;
    }
    const auto take = [](std::int8_t& to, int bit) {
      if (bit >= 0) to = static_cast<std::int8_t>(bit);
    };
    DriveFacts& drive = *profile_.drive;
    take(drive.input_neg_limit, row.inputs->negative_limit);
    take(drive.input_pos_limit, row.inputs->positive_limit);
    take(drive.input_home, row.inputs->home);
    if (drive.input_neg_limit >= 0 && drive.input_neg_limit == drive.input_pos_limit)
      mistakes_.add(Fault::Inconsistent, "both limits are the same bit of 60FDh", row.inputs->location);
  }

  StationProfile& profile_;
  Mistakes& mistakes_;
};

}  // namespace

void resolve_parameters(const written::StationRow& row, Station& station, Mistakes& mistakes) {
  Parameters(station.profile, mistakes).resolve(row);
}

}  // namespace gantry::config
