#include "app/stations/measured.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "config/yaml.hpp"
#include "core/new_file.hpp"
#include "core/units.hpp"

namespace gantry::stations {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kFormat = 1;
constexpr double kApart_s = 0.5e-3;  // between stated and found, that is worth a word

}  // namespace

std::string measured_file(const std::string& state, const std::string& bus) {
  return fmt::format("{}/measured-{}.json", state, bus.substr(0, bus.find(':')));
}

Result<void> read_measured(const std::string& file, config::Machine& machine) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return {};
  const auto text = config::read_text_file(file);
  if (!text) return tl::unexpected(text.error());
  try {
    const Json all = Json::parse(*text);
    if (all.at("format").get<int>() != kFormat) throw std::runtime_error("another format");
    const Json& rows = all.at("axes");
    for (config::Axis& axis : machine.axes)
      if (const auto row = rows.find(axis.name); row != rows.end())
        axis.measured = config::MeasuredDelay{.delay_s = row->at("delay_s").get<double>(),
                                              .within_s = row->at("within_s").get<double>(),
                                              .speed = row->at("speed").get<double>(),
                                              .date = row->at("date").get<std::string>()};
  } catch (const std::exception& error) {
    return fail(Fault::BadValue,
                fmt::format("what was measured of the axes cannot be read ({}); remove the file and measure again with "
                            "`gantry commission AXIS`",
                            config::shortened(error.what(), 200)),
                file);
  }
  return {};
}

Result<void> write_measured(const std::string& file, const config::Machine& machine) {
  Json rows = Json::object();
  for (const config::Axis& axis : machine.axes)
    if (axis.measured)
      rows[axis.name] = {{"delay_s", axis.measured->delay_s},
                         {"within_s", axis.measured->within_s},
                         {"speed", axis.measured->speed},
                         {"date", axis.measured->date}};
  return write_new_file(file, Json{{"format", kFormat}, {"axes", rows}}.dump(2) + "\n");
}

std::string measured_in_words(const config::Axis& axis) {
  const config::MeasuredDelay& m = *axis.measured;
  const bool apart = std::abs(m.delay_s - axis.response_delay_s) > kApart_s + m.within_s;
  return fmt::format(
      "axis {}: a response_delay of {:.6g} ms is stated, {:.2f} ms were found (within {:.2f} ms, at {:.4g} "
      "{}, {}){}",
      axis.name, axis.response_delay_s * 1e3, m.delay_s * 1e3, m.within_s * 1e3,
      axis.rotary ? units::deg(m.speed) : m.speed, axis.rotary ? "deg/s" : "mm/s", m.date,
      apart
          ? fmt::format(": state `response_delay: {:.2f} ms`, or look for the filter that has changed", m.delay_s * 1e3)
          : "");
}

}  // namespace gantry::stations
