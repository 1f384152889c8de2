// The reference machine and a recipe of dots on it.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "recipes/job.hpp"

namespace gantry::test {

inline config::Machine reference() {
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  if (machine) return *machine;
  ADD_FAILURE() << to_text(machine.error().front());
  return {};
}

/// The same where no axis answers later than another: what unlike delays ask of paths besides is nothing there, so that
/// the clearance alone decides what is refused.
inline config::Machine of_one_delay() {
  config::Machine machine = reference();
  for (config::Axis& axis : machine.axes) axis.response_delay_s = 0.004;
  return machine;
}

inline AxisVec parked(const config::Machine& machine) {
  AxisVec q{};
  for (const auto& [axis, position] : machine.park) q[axis.value] = position;
  return q;
}

/// An array of rows x columns dots on a board of 80 x 55 mm.
inline recipes::Recipe dots(std::size_t rows, std::size_t columns, const std::string& more = "") {
  const auto recipe = recipes::parse(
      fmt::format("version: 1\nrecipe: dots\nboard: {{size: [80 mm, 55 mm], thickness: 1.6 mm, frame: pallet}}\n{}"
                  "materials:\n  glue: {{speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
                  "dot_time: 30 ms, settle_time: 10 ms, retract: 3 mm}}\n"
                  "features:\n  - array: {{name: d, material: glue, at: [10 mm, 10 mm], rows: {}, columns: {}, "
                  "pitch: [{} mm, {} mm]}}\n",
                  more, rows, columns, 60.0 / static_cast<double>(columns), 35.0 / static_cast<double>(rows)),
      "dots.yaml");
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}

}  // namespace gantry::test
