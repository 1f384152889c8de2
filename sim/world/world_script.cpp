// World: what scripts make happen.
#include <algorithm>

#include "sim/world/script_on_board.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim {

Result<void> World::add_script(std::vector<ScriptEntry> entries) {
  const std::scoped_lock lock(mutex_);
  if (board_)
    if (auto fits = script_fits(entries, board_->plan); !fits) return fits;
  for (ScriptEntry& e : entries) script_.push_back({std::move(e), std::nullopt});
  return {};
}

std::vector<std::string> World::script_left() {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> left;
  for (const Waiting& w : script_)
    if (w.due != kNever) left.push_back(w.entry.where + ": " + w.entry.text);
  return left;
}

Result<void> World::script_fits(std::span<const ScriptEntry> entries, const BoardPlan& plan) const {
  std::vector<std::string> standing;
  for (const config::Body& b : obstacles_) standing.push_back(b.name);
  return fits_board(entries, plan, std::move(standing));
}

void World::fire(Trigger::Kind kind, std::uint64_t count, std::string_view name, Time now) {
  for (Waiting& w : script_) {
    const Trigger& t = w.entry.trigger;
    if (!w.due && t.kind == kind && t.count == count && t.name == name) w.due = now + t.after;
  }
  // What happens at this very instant comes before what follows from it: a mark that is taken away at its exposure is
  // not seen. Bus actions wait for the end of the step.
  for (Waiting& w : script_)
    if (w.due && *w.due <= now && !of_the_bus(w.entry.action.kind)) {
      const Action action = w.entry.action;
      w.due = kNever;  // done; run_script clears it away
      do_action(action, now);
    }
}

void World::run_script(std::uint64_t cycle, Time now) {
  for (Waiting& w : script_) {
    const Trigger& t = w.entry.trigger;
    if (w.due) continue;
    if (t.kind == Trigger::Kind::Now || (t.kind == Trigger::Kind::Cycle && cycle >= t.count)) w.due = now + t.after;
  }
  for (Waiting& w : script_)
    if (w.due && *w.due <= now) {
      w.due = kNever;
      if (of_the_bus(w.entry.action.kind))
        bus_actions_.push_back(w.entry.action);
      else
        do_action(w.entry.action, now);
    }
  std::erase_if(script_, [](const Waiting& w) { return w.due == kNever; });
}

void World::do_action(const Action& a, Time now) {
  switch (a.kind) {
    case ActionKind::AddObstacle:
      obstacles_.push_back({a.name, {config::Shape::Kind::Box, a.size}, a.at, 0, false});
      place_solids();
      break;
    case ActionKind::RemoveObstacle:
      std::erase_if(obstacles_, [&](const config::Body& b) { return b.name == a.name; });
      place_solids();
      break;
    case ActionKind::Press: pressed_until_[static_cast<std::size_t>(a.input)] = now + a.hold; break;
    case ActionKind::SetInput:
      if (a.on)
        steady_inputs_ |= config::bit(a.input);
      else
        steady_inputs_ &= ~config::bit(a.input);
      break;
    case ActionKind::CameraDead:
    case ActionKind::CameraAlive: camera_.set_dead(a.kind == ActionKind::CameraDead); break;
    default: change_board(a);
  }
}

void World::change_board(const Action& a) {
  if (!board_) return;
  // Pictures that were exposed keep the board as it was.
  auto changed = std::make_shared<BoardTruth>(*board_);
  auto& marks = changed->plan.marks;
  const auto mark = std::find_if(marks.begin(), marks.end(), [&](const auto& m) { return m.name == a.name; });
  const Vec2 by{a.at.x, a.at.y};
  switch (a.kind) {
    case ActionKind::RemoveMark:
      if (mark != marks.end()) marks.erase(mark);
      break;
    case ActionKind::MoveMark:
      if (mark != marks.end()) mark->at = mark->at + by;
      break;
    case ActionKind::Stain:
      changed->stains.push_back({mark != marks.end() ? mark->at + by : by, a.diameter, a.grey});
      break;
    default: return;
  }
  board_ = std::move(changed);
  keep_board();
}

}  // namespace gantry::sim
