// The direction walk of commissioning: one axis after the other goes a short distance and back, and a person says which
// axis moved and which way. Stations that look alike are told apart by that, and so are motors and polarities.
//   auto seen = walk(owner, machine, {.say = ..., .hear = ...});   if (seen) owner.keep_walk("2026-11-24");
// The first answer that is not what the machine file says ends it, with the remedy; nothing is kept then,
// and what earlier walks have said is void.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/run/owner.hpp"

namespace gantry::run {

/// What somebody has seen: an axis, and whether its coordinate rose first.
struct Seen {
  std::string axis;  ///< empty: nothing moved
  bool up = false;
};
/// "X+", "z -", "nothing". Fault::BadValue with how it is written.
Result<Seen> read_seen(const config::Machine& machine, const std::string& text);

/// Whether that is what `axis` had to do (job::walk_by()). Fault::AxisNotAsWired with the remedy.
Result<void> judge_seen(const config::Machine& machine, const config::Axis& axis, const Seen& seen);

/// The axes that walk, in this order: those that go up first, then the others as the file has them.
std::vector<const config::Axis*> walk_order(const config::Machine& machine);

struct WalkTalk {
  std::function<void(const std::string&)> say;
  /// A line that somebody has written; nothing when there is none yet. An error ends the walk.
  std::function<Result<std::optional<std::string>>()> hear;
  std::function<void()> poll{};    ///< in every step while an axis moves
  std::function<void()> forget{};  ///< what was written and not heard yet
};

/// Of a machine that is up, and in setup. The axes that have walked. Fault::AxisNotAsWired, and what a walk of one axis
/// may come to (Owner::walk).
Result<std::vector<const config::Axis*>> walk(Owner& owner, const config::Machine& machine, const WalkTalk& talk);

}  // namespace gantry::run
