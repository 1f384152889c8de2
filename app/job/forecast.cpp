#include "app/job/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <utility>

#include "app/job/block_wanted.hpp"
#include "app/job/limits.hpp"
#include "app/job/park.hpp"
#include "app/job/rise.hpp"
#include "app/job/surroundings.hpp"
#include "motion/geometry.hpp"
#include "motion/path/moves.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"
#include "motion/profile/touch_end.hpp"

namespace gantry::job {
namespace {

/// The first motion of a job, planned from somewhere: of features the first alone, since the others do not change.
std::optional<double> first_motion_s(const BlockPlanner& planner, const recipes::Block& block, const AxisVec& from) {
  BlockWanted first{std::visit([](const auto& what) -> BlockStep { return what; }, block.what), 1, from, {}};
  if (auto* all = std::get_if<recipes::Dispense>(&first.step); all != nullptr && all->features.size() > 1)
    *all = recipes::Dispense{{all->features.front()}};
  const Result<ProvenBlock> planned = plan(planner, first);
  return planned ? std::optional(planned->duration_s()) : std::nullopt;
}

void change(Forecast& forecast, std::size_t step, double to_s) {
  forecast.s += to_s - forecast.steps[step].s;
  forecast.steps[step].s = to_s;
}

/// The step of this block is come to from another place than it was planned from. False where one cannot be planned.
bool come_from(Forecast& forecast, std::size_t step, const BlockPlanner& planner, const recipes::Block& block,
               const AxisVec& was, const AxisVec& is) {
  const auto was_s = first_motion_s(planner, block, was), is_s = first_motion_s(planner, block, is);
  if (!was_s || !is_s) return false;
  const double more_s = *is_s - *was_s;
  change(forecast, step, std::max(0.0, forecast.steps[step].s + more_s));
  if (const auto* all = std::get_if<recipes::Dispense>(&block.what); all != nullptr && !all->features.empty())
    forecast.features[all->features.front()].travel_s += more_s;
  return true;
}

/// What is dispensed first is then come to from where the purge would have begun.
void leave_out(Forecast& forecast, const PurgeStep& purge, const BlockPlanner& planner, const recipes::Job& job) {
  change(forecast, purge.step, 0);
  const auto dispenses = [](const recipes::Block& block) {
    const auto* all = std::get_if<recipes::Dispense>(&block.what);
    return all != nullptr && !all->features.empty();
  };
  const auto first = std::ranges::find_if(job.blocks, dispenses);
  if (first != job.blocks.end() && purge.step + 1 < forecast.steps.size())
    come_from(forecast, purge.step + 1, planner, *first, purge.to, purge.from);
}

}  // namespace

std::string words_of(const Next& step, const recipes::Recipe& recipe) {
  if (const auto* look = std::get_if<recipes::LookAtMark>(&step)) return "mark '" + recipe.marks[look->mark].name + "'";
  if (const auto* touch = std::get_if<recipes::Touch>(&step))
    return "touch '" + recipe.touches[touch->touch].name + "'";
  if (const auto* up = std::get_if<Retract>(&step)) return "up from touch '" + recipe.touches[up->touch].name + "'";
  if (std::holds_alternative<recipes::PurgeNeedle>(step)) return "purge";
  if (const auto* all = std::get_if<recipes::Dispense>(&step))
    return fmt::format("dispense {} feature{}", all->features.size(), all->features.size() == 1 ? "" : "s");
  return std::holds_alternative<recipes::Park>(step) ? "park" : "";
}

BlockEnd touched(const config::Machine& machine, const ProvenBlock& block, const AxisVec& surface) {
  const motion::Segment& line = block.segments().back();
  const motion::Limits limits = limits_of(machine);
  const std::size_t axis = machine.probe.axis.value;
  const double slope = motion::derivative<1>(line.geometry, 0)[axis];
  const double lasts_s = motion::duration(line.nominal);
  double fastest = 0;
  constexpr int kSamples = 64;
  for (int i = 0; i <= kSamples; ++i)
    fastest = std::max(fastest, motion::along(line.nominal, lasts_s * i / kSamples).x.v);
  motion::Bounds bounds = motion::line_bounds(limits, motion::derivative<1>(line.geometry, 0));
  bounds.v = fastest;
  const double latched = slope != 0 ? (surface[axis] - line.geometry.from[axis]) / slope : line.geometry.length;
  const double end = std::clamp(motion::touch_end(latched, bounds), 0.0, line.geometry.length);
  // The same motion with less of its path at full speed.
  const double left_s = fastest > 0 ? (line.geometry.length - end) / fastest : 0;
  BlockEnd out{block.duration_s() - left_s, block.end()};
  out.at[axis] = line.geometry.from[axis] + slope * end;
  return out;
}

void add_times(std::vector<FeatureTime>& features, const ProvenBlock& block, const Breath& breath) {
  Pauses pause(breath, 1024);
  double travel_s = 0;
  for (const motion::Segment& s : block.segments()) {
    pause();
    const double lasts_s = motion::duration(s.nominal);
    if (s.feature >= features.size()) {
      travel_s += lasts_s;
    } else {
      features[s.feature].travel_s += std::exchange(travel_s, 0);
      features[s.feature].on_it_s += lasts_s;
    }
  }
}

Forecast from_here(Forecast forecast, const config::Machine& machine, const recipes::Recipe& recipe,
                   const recipes::Job& job, const AxisVec& at, std::optional<double> shut_s) {
  if (forecast.steps.empty() || job.blocks.empty()) return forecast;
  const auto steps_before = [&](std::size_t step) {
    return std::accumulate(forecast.steps.begin(), forecast.steps.begin() + static_cast<std::ptrdiff_t>(step), 0.0,
                           [](double sum, const StepTime& each) { return sum + each.s; });
  };
  BlockPlanner planner(machine, recipe);
  planner.know_ways(forecast.ways);
  if (const auto purge = forecast.purge;
      purge && shut_s && *shut_s + steps_before(purge->step) <= recipe.purge->after_s)
    leave_out(forecast, *purge, planner, job);
  AxisVec from = at;
  double rise_s = 0;
  if (const auto up = plan_rise(machine, *planner.surroundings(), 1, at); up && *up)
    rise_s = (*up)->duration_s(), from = (*up)->end();
  if (come_from(forecast, 0, planner, job.blocks.front(), parked(machine, {}), from)) forecast.s += rise_s;
  return forecast;
}

}  // namespace gantry::job
