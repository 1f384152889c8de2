// World: what scripts make happen.
#include <algorithm>

#include "sim/script/script.hpp"
#include "sim/world/script_on_board.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim {

Result<void> World::add_script(std::vector<ScriptEntry> entries) {
  const std::scoped_lock lock(mutex_);
  if (board_)
    if (auto fits = script_fits(entries, board_->plan); !fits) return fits;
  for (ScriptEntry& e : entries) script_.push_back({std::move(e)});
  return {};
}

std::vector<std::string> World::script_left(WorldAccess::Machine machine) {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> left;
  for (Waiting& w : script_) {
    const auto kind = w.entry.trigger.kind;
    const bool of_a_job = kind != Trigger::Kind::Now && kind != Trigger::Kind::Cycle;
    const bool may_come = !of_a_job && machine == WorldAccess::Machine::GoesOn;
    if (w.due == kNever || w.told || may_come) continue;
    w.told = true;
    left.push_back(w.entry.where + ": " + w.entry.text);
  }
  return left;
}

std::optional<AxisVec> World::axes() {
  const std::scoped_lock lock(mutex_);
  if (!stepped_) return std::nullopt;
  return before_.axes;
}

ScriptedInput World::scripted_input(unsigned input) {
  const std::scoped_lock lock(mutex_);
  const bool more = std::any_of(script_.begin(), script_.end(), [](const Waiting& w) {
    const auto kind = w.entry.trigger.kind;
    return w.due ? *w.due != kNever : kind == Trigger::Kind::Now || kind == Trigger::Kind::Cycle;
  });
  return {changed_by_.at(input), more};
}

Result<void> World::script_fits(std::span<const ScriptEntry> entries, const BoardPlan& plan) const {
  std::vector<std::string> standing;
  for (const config::Body& b : obstacles_) standing.push_back(b.name);
  const std::vector<Error> misfits = misfits_of(entries, plan, std::move(standing));
  if (misfits.empty()) return {};
  return tl::unexpected(joined(misfits));
}

void World::fire(Trigger::Kind kind, std::uint64_t count, std::string_view name, Time now) {
  for (Waiting& w : script_) {
    const Trigger& t = w.entry.trigger;
    if (!w.due && t.kind == kind && t.count == count && t.name == name) w.due = now + t.after;
  }
  // What happens at this very instant comes before what follows from it: a mark that is taken away at its exposure is
  // not seen. Bus actions wait for the end of the step.
  for (Waiting& w : script_)
    if (w.due && *w.due <= now && std::holds_alternative<WorldAction>(w.entry.action)) {
      w.due = kNever;  // done; run_script clears it away
      do_action(w.entry, now);
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
      if (std::holds_alternative<WorldAction>(w.entry.action)) {
        do_action(w.entry, now);
      } else {
        bus_actions_.push_back(std::get<BusAction>(w.entry.action));
        if (const auto* stop = std::get_if<act::EmergencyStop>(&bus_actions_.back())) emergency_ = stop->pressed;
      }
    }
  std::erase_if(script_, [](const Waiting& w) { return w.due == kNever; });
}

void World::do_action(const ScriptEntry& entry, Time now) {
  std::visit(
      [&](const auto& a) {
        if constexpr (requires { a.input; }) changed_by_[a.input] = entry.where + ": " + entry.text;
        happen(a, now);
      },
      std::get<WorldAction>(entry.action));
}

void World::happen(const act::AddObstacle& a, Time) {
  obstacles_.push_back({a.name, {config::Shape::Kind::Box, a.size}, a.centre, 0, false});
  place_solids();
}
void World::happen(const act::RemoveObstacle& a, Time) {
  std::erase_if(obstacles_, [&](const config::Body& b) { return b.name == a.name; });
  place_solids();
}
void World::happen(const act::Press& a, Time now) { pressed_until_[a.input] = now + a.hold; }
void World::happen(const act::SetInput& a, Time) {
  const std::uint32_t bit = 1u << a.input;
  steady_inputs_ = a.on ? steady_inputs_ | bit : steady_inputs_ & ~bit;
}
void World::happen(const act::BreakWire& a, Time) { broken_wires_ |= 1u << a.input; }
void World::happen(const act::SetCamera& a, Time) { camera_.set_dead(!a.alive); }

void World::happen(const act::RemoveMark& a, Time) {
  change_board([&](BoardTruth& board) {
    std::erase_if(board.plan.marks, [&](const recipes::MarkDef& m) { return m.name == a.name; });
  });
}
void World::happen(const act::MoveMark& a, Time) {
  change_board([&](BoardTruth& board) {
    for (recipes::MarkDef& m : board.plan.marks)
      if (m.name == a.name) m.at = m.at + a.by;
  });
}
void World::happen(const act::Stain& a, Time) {
  change_board([&](BoardTruth& board) {
    const auto& marks = board.plan.marks;
    const auto from = std::find_if(marks.begin(), marks.end(), [&](const auto& m) { return m.name == a.from; });
    board.stains.push_back({from != marks.end() ? from->at + a.by : a.by, a.diameter, a.grey});
  });
}

/// Pictures that were exposed keep the board as it was.
void World::change_board(const std::function<void(BoardTruth&)>& change) {
  if (!board_) return;
  auto changed = std::make_shared<BoardTruth>(*board_);
  change(*changed);
  board_ = std::move(changed);
  keep_board();
}

}  // namespace gantry::sim
