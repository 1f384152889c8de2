// A jog: some axes go by some displacement, together on a straight line, and stop. Words as people type them become
// numbers, and those a block that is proved free; the owner plays it (Owner::jog).
//   auto jog = read_jog(machine, {.by = {{"X", "10 mm"}, {"Z", "-2 mm"}}, .speed = "20 mm/s"});
//   auto planned = plan_jog(machine, surroundings, at, *jog);
// What is proved is the whole straight line. A hold and an abort brake on it, so that wherever the jog ends, the head
// has been nowhere else.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "app/job/block_builder.hpp"
#include "app/job/surroundings.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace gantry::job {

/// No jog is asked to go slower.
inline constexpr double kSlowestJog_mm_s = 0.01, kSlowestJog_rad_s = units::rad(0.01);

/// What a jog is asked for.
struct JogWords {
  std::map<std::string, std::string> by{};  ///< axis: "10 mm", "-15 deg"
  std::string speed{};                      ///< "20 mm/s", or "20 deg/s" where only rotary axes move; "" takes these
};

/// Whether it goes on by itself, or only while its client speaks (app/job/hold_to_run.hpp), and no faster than that
/// allows.
enum class JogFor { Program, Client };

struct Jog {
  std::uint32_t axes = 0;  ///< bit n: AxisId n is named
  AxisVec displacement{};
  double v_cap = 0;      ///< along the path's s, as motion::line_move takes it
  std::string slowed{};  ///< why it goes slower than was asked for: "no faster than ..."; empty where it does not
};

/// Fault::UnknownReference with the nearest name.
Result<const config::Axis*> axis_named(const config::Machine& machine, const std::string& name);

/// Fault::Usage, PositionedAxisInMove; NoSolution when no jog of a client stands in time on this machine.
Result<Jog> read_jog(const config::Machine& machine, const JogWords& words, JogFor whom = JogFor::Program);

/// Fault::NotReferenced when it is not known where the head stands or one of `axes` does.
Result<void> know_position(const config::Machine& machine, std::uint32_t referenced, std::uint32_t axes);

/// One block, number 1. Fault::OutOfReach with the axis, its limit and how far it is to there; Fault::Collision with
/// both bodies and the point. An axis that stands outside of its limits (homing leaves it there) may come back.
Result<ProvenBlock> plan_jog(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                             const Jog& jog);

}  // namespace gantry::job
