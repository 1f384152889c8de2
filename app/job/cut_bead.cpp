#include "app/job/cut_bead.hpp"

#include <algorithm>
#include <cmath>

#include "app/job/limits.hpp"
#include "app/job/valve_span.hpp"
#include "motion/rt/compensation.hpp"

namespace gantry::job {
namespace {

// That are kept up to the cut, and behind it: more than the longest lead has. A stop may take more.
constexpr std::size_t kCycles = 4096;
constexpr double kSamePoint_mm = 1e-6;
constexpr double kAtStart_mm = 0.05;  // so far before it what comes out lies on a bead's start

int delay_ticks(const config::Machine& machine) {
  const motion::Limits limits = limits_of(machine);
  return motion::Compensation(limits, limits.response_delay_s).delay_ticks();
}

}  // namespace

CutWatch::CutWatch(const config::Machine& machine)
    : tick_s_(seconds(machine.bus.cycle)), delay_ticks_(delay_ticks(machine)) {}

void CutWatch::begin() {
  seen_.clear();
  cut_.reset(), shut_.reset(), stops_.reset();
  stands_ = 0;
}

void CutWatch::see(const BlockCycle& cycle) {
  const bool stands = !seen_.empty() && std::abs(cycle.along_block_mm - last_mm_) <= kSamePoint_mm;
  stands_ = stands ? stands_ + (cycle.plays ? 1 : 0) : 0;
  last_mm_ = cycle.along_block_mm;
  if (cycle.valve_open && (seen_.empty() || !seen_.back().valve_open)) opened_ = cycle.cycle;
  if (cycle.valve_open)
    shut_.reset(), stops_.reset();
  else if (!seen_.empty() && seen_.back().valve_open)
    shut_ = cycle.cycle;
  if (shut_ && !stops_ && !cycle.plays) stops_ = cycle.cycle;
  if (cut_ && cycle.cycle > *cut_ + static_cast<CycleIndex>(kCycles)) return;
  if (!cut_ && seen_.size() == kCycles) seen_.pop_front();
  seen_.push_back(cycle);
  if (cycle.valve_cut && !cut_) cut_ = cycle.cycle;
}

void CutWatch::see_cut(CycleIndex cycle) {
  if (!seen_.empty()) see({.cycle = cycle, .along_block_mm = last_mm_, .valve_cut = true, .plays = false});
}

std::optional<ShutAt> CutWatch::shut_at(double close_lead_s) const {
  const double lead = close_lead_s / tick_s_;
  const bool stopped_early = shut_ && stops_ && static_cast<double>(*stops_ - *shut_) < lead;
  if (!cut_ && !stopped_early) return std::nullopt;
  const double at = static_cast<double>((cut_ ? *cut_ : *shut_) - delay_ticks_) + lead;
  const auto later =
      std::find_if(seen_.begin(), seen_.end(), [&](const BlockCycle& c) { return static_cast<double>(c.cycle) >= at; });
  if (later == seen_.begin()) return ShutAt{later->along_block_mm, 0};
  const BlockCycle& a = *std::prev(later);
  auto came = std::prev(later);
  while (came != seen_.begin() && std::abs(std::prev(came)->along_block_mm - a.along_block_mm) <= kSamePoint_mm) --came;
  const double stood_s = (at - static_cast<double>(came->cycle)) * tick_s_;
  if (later == seen_.end()) return ShutAt{a.along_block_mm, stood_s};  // the block has ended before: the tool stands
  const double part = (at - static_cast<double>(a.cycle)) / static_cast<double>(later->cycle - a.cycle);
  return ShutAt{a.along_block_mm + part * (later->along_block_mm - a.along_block_mm), stood_s};
}

std::optional<double> CutWatch::flowed_s(double open_lead_s, double close_lead_s) const {
  if (!cut_) return std::nullopt;
  return static_cast<double>(*cut_ - opened_) * tick_s_ + close_lead_s - open_lead_s;
}

std::optional<Laid> laid_part(const std::deque<motion::Segment>& segments, const LaidPart& before, const ShutAt& shut) {
  const auto span = valve_span(segments.begin(), segments.end(), static_cast<std::uint32_t>(before.feature));
  if (!span) return std::nullopt;
  const double laid_mm = shut.along_block_mm - span->opens_mm;
  const bool at_start = before.mm == 0 && laid_mm >= -kAtStart_mm && laid_mm <= kSamePoint_mm;
  return Laid{before.mm + (at_start ? 0 : std::max(0.0, laid_mm)), before.mm + span->shuts_mm - span->opens_mm,
              before.stood_s + (at_start ? shut.stood_s : 0)};
}

}  // namespace gantry::job
