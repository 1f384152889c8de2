#include "app/stations/measured.hpp"

#include <cmath>
#include <fmt/format.h>

#include "app/stations/kept_file.hpp"
#include "core/units.hpp"

namespace gantry::stations {
namespace {

using Json = KeptFile::Json;
constexpr KeptFile kFile{.stem = "measured",
                         .rows = "axes",
                         .unreadable = "what was measured of the axes",
                         .remedy = "remove the file and measure again with `gantry commission AXIS`"};
constexpr double kApart_s = 0.5e-3;  // between stated and found, that is worth a word

}  // namespace

std::string measured_file(const std::string& state, const std::string& bus) { return kFile.path(state, bus); }

Result<void> read_measured(const std::string& file, config::Machine& machine) {
  return kFile.read(file, [&](const Json& rows) {
    for (config::Axis& axis : machine.axes)
      if (const auto row = rows.find(axis.name); row != rows.end())
        axis.measured = config::MeasuredDelay{.delay_s = row->at("delay_s").get<double>(),
                                              .within_s = row->at("within_s").get<double>(),
                                              .speed = row->at("speed").get<double>(),
                                              .date = row->at("date").get<std::string>()};
  });
}

Result<void> write_measured(const std::string& file, const config::Machine& machine) {
  Json rows = Json::object();
  for (const config::Axis& axis : machine.axes)
    if (axis.measured)
      rows[axis.name] = {{"delay_s", axis.measured->delay_s},
                         {"within_s", axis.measured->within_s},
                         {"speed", axis.measured->speed},
                         {"date", axis.measured->date}};
  return kFile.write(file, rows);
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
