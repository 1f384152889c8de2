#include "recipes/reach.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <set>

#include "recipes/job.hpp"

namespace gantry::recipes {
namespace {

std::string and_more(std::size_t more) { return more == 0 ? "" : fmt::format(" (and {} more)", more); }

}  // namespace

bool Reach::look(Ask ask) {
  const config::Tool* tool = config::find_tool(machine_, ask.tool);
  if (tool == nullptr) return true;
  if (ask.on_board) ++looked_[ask.tool];
  const AxisVec q = tool_at(machine_, *tool, ask.tip, 0);
  for (const AxisId id : {machine_.x, machine_.y, machine_.z}) {
    const config::Axis& axis = machine_.axes[id.value];
    const double at = q[id.value];
    const bool up = id == machine_.z;
    const double beside = up ? ask.window : ask.around, lift = up ? ask.lift : 0;
    if (at - beside >= axis.p_min && at + lift + beside <= axis.p_max) continue;
    const bool point = at < axis.p_min || at > axis.p_max;
    const Cause cause = point                    ? Cause::Point
                        : !up                    ? Cause::Around
                        : at + lift > axis.p_max ? Cause::Lift
                                                 : Cause::Window;
    misses_.push_back({std::move(ask), cause, id, at - beside, at + lift + beside});
    return false;
  }
  return true;
}

std::string Reach::needs(const Miss& miss) const {
  const config::Axis& axis = machine_.axes[miss.axis.value];
  return fmt::format(
      "{} needs axis {} at {:.2f} .. {:.2f} mm (the {}, board off by up to {:.2f} mm); it travels {:.6g} "
      ".. {:.6g} mm",
      miss.ask.what, axis.name, miss.least, miss.most, miss.ask.tool, miss.ask.around, axis.p_min, axis.p_max);
}

void Reach::tell() {
  tell_points();
  tell_lifts();
  tell_rules(Cause::Window);
  tell_rules(Cause::Around);
}

/// Where most of what lies on the board is out of reach, the board is; where most of what a tool does, it is for that
/// tool. Else each thing is told where it stands.
void Reach::tell_points() {
  std::set<std::pair<int, int>> told;  // an array is one line of the recipe
  if (tell_of_most("")) return tell_each(told, [](const Miss& miss) { return !miss.ask.on_board; });
  std::set<std::string_view> told_tools;
  for (const auto& [tool, looked] : looked_)
    if (tell_of_most(tool)) told_tools.insert(tool);
  tell_each(told,
            [&](const Miss& miss) { return !miss.ask.on_board || told_tools.find(miss.ask.tool) == told_tools.end(); });
}

void Reach::tell_each(std::set<std::pair<int, int>>& told, const std::function<bool(const Miss&)>& which) {
  for (const Miss& miss : misses_)
    if (miss.cause == Cause::Point && which(miss) &&
        told.insert({miss.ask.location.line, miss.ask.location.column}).second)
      mistakes_.add(Fault::OutOfReach, needs(miss) + "; move it", miss.ask.location);
}

bool Reach::tell_of_most(std::string_view tool) {
  constexpr std::size_t kFew = 3;
  std::size_t looked = 0, missed = 0;
  for (const auto& [name, count] : looked_)
    if (tool.empty() || name == tool) looked += count;
  const Miss* first = nullptr;
  for (const Miss& miss : misses_) {
    if (miss.cause != Cause::Point || !miss.ask.on_board || !(tool.empty() || miss.ask.tool == tool)) continue;
    ++missed;
    if (first == nullptr) first = &miss;
  }
  if (missed < kFew || 2 * missed <= looked) return false;
  const bool high = first->axis == machine_.z;
  const Location written = high ? recipe_.board.locations.thickness : recipe_.board.locations.at;
  mistakes_.add(
      Fault::OutOfReach,
      fmt::format(
          "{} of the {} points{} are out of reach; {}; correct the board's {}, or the origin of frame '{}'{} in "
          "the machine file",
          missed, looked, tool.empty() ? " of the recipe" : fmt::format(" for the {}", tool), needs(*first),
          high ? "'thickness'" : "place 'at'", recipe_.board.frame,
          tool.empty() ? "" : fmt::format(" or the tip of tool '{}'", tool)),
      written.line > 0 ? written : recipe_.board.frame_location);
  return true;
}

void Reach::tell_lifts() {
  std::set<std::pair<const Material*, bool>> told;
  for (const Miss& miss : misses_) {
    if (miss.cause != Cause::Lift) continue;
    if (miss.ask.material != nullptr && !told.insert({miss.ask.material, miss.ask.by_tail}).second) continue;
    if (miss.ask.material == nullptr) {
      mistakes_.add(Fault::OutOfReach, needs(miss), miss.ask.location);
      continue;
    }
    const auto is_same = [&](const Miss& other) {
      return other.cause == Cause::Lift && other.ask.material == miss.ask.material &&
             other.ask.by_tail == miss.ask.by_tail;
    };
    const auto same = std::count_if(misses_.begin(), misses_.end(), is_same);
    double room = miss.ask.lift;
    for (const Miss& other : misses_)
      if (is_same(other)) room = std::min(room, other.ask.lift - (other.most - machine_.axes[other.axis.value].p_max));
    const MaterialLocations& keys = miss.ask.material->locations;
    const Location written = miss.ask.by_tail ? keys.tail_lift : keys.retract;
    mistakes_.add(Fault::OutOfReach,
                  fmt::format("with the '{}' of {:.6g} mm of material '{}' {}{}; write {}",
                              miss.ask.by_tail ? "tail_lift" : "retract", miss.ask.lift, miss.ask.material->name,
                              needs(miss), and_more(static_cast<std::size_t>(same) - 1),
                              room > 0 ? fmt::format("at most {:.6g} mm", room) : std::string("less")),
                  written.line > 0 ? written : miss.ask.location);
  }
}

Location Reach::rules_location(const Miss& miss) const {
  if (miss.cause == Cause::Window)
    return recipe_.touch_rules.window_location.line > 0 ? recipe_.touch_rules.window_location : miss.ask.location;
  const MarkRulesLocations& rules = recipe_.mark_rules.locations;
  const bool turn = miss.ask.by_turn > miss.ask.around / 2;
  const Location likely = turn ? rules.max_rotation : rules.max_shift,
                 other = turn ? rules.max_shift : rules.max_rotation;
  return likely.line > 0 ? likely : other.line > 0 ? other : miss.ask.location;
}

void Reach::tell_rules(Cause cause) {
  const auto of_cause = [cause](const Miss& miss) { return miss.cause == cause; };
  const auto first = std::find_if(misses_.begin(), misses_.end(), of_cause);
  if (first == misses_.end()) return;
  const auto count = static_cast<std::size_t>(std::count_if(misses_.begin(), misses_.end(), of_cause));
  mistakes_.add(Fault::OutOfReach,
                fmt::format("{}{}; {}", needs(*first), and_more(count - 1),
                            cause == Cause::Window
                                ? "write a smaller 'window' under `touch_rules`, or move it"
                                : "write a smaller 'max_shift' or 'max_rotation' under `mark_rules`, or move it"),
                rules_location(*first));
}

}  // namespace gantry::recipes
