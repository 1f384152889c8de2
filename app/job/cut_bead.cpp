#include "app/job/cut_bead.hpp"

#include <algorithm>
#include <cmath>

#include "app/job/limits.hpp"
#include "app/job/valve_span.hpp"
#include "motion/rt/compensation.hpp"

namespace gantry::job {
namespace {

constexpr std::size_t kCycles = 4096;  // that are kept: a stop takes fewer

int delay_ticks(const config::Machine& machine) {
  AxisVec delays{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) delays[i] = machine.axes[i].response_delay_s;
  return motion::Compensation(limits_of(machine), delays).delay_ticks();
}

}  // namespace

CutWatch::CutWatch(const config::Machine& machine)
    : tick_s_(seconds(machine.bus.cycle)), delay_ticks_(delay_ticks(machine)) {}

void CutWatch::begin() {
  seen_.clear();
  cut_.reset();
}

void CutWatch::see(const BlockCycle& cycle) {
  if (seen_.size() == kCycles) seen_.pop_front();
  seen_.push_back(cycle);
  if (cycle.valve_cut && !cut_) cut_ = cycle.cycle;
}

std::optional<double> CutWatch::shut_at_mm(double close_lead_s) const {
  if (!cut_) return std::nullopt;
  const double at = static_cast<double>(*cut_ - delay_ticks_) + close_lead_s / tick_s_;
  const auto later =
      std::find_if(seen_.begin(), seen_.end(), [&](const BlockCycle& c) { return static_cast<double>(c.cycle) >= at; });
  if (later == seen_.end()) return seen_.back().along_block_mm;
  if (later == seen_.begin()) return later->along_block_mm;
  const BlockCycle &a = *std::prev(later), &b = *later;
  const double part = (at - static_cast<double>(a.cycle)) / static_cast<double>(b.cycle - a.cycle);
  return a.along_block_mm + part * (b.along_block_mm - a.along_block_mm);
}

std::optional<Laid> laid_part(const std::deque<motion::Segment>& segments, std::size_t feature, double shut_at_mm,
                              double before_mm) {
  const auto span = valve_span(segments.begin(), segments.end(), static_cast<std::uint32_t>(feature));
  if (!span) return std::nullopt;
  return Laid{before_mm + std::max(0.0, shut_at_mm - span->opens_mm), before_mm + span->shuts_mm - span->opens_mm};
}

}  // namespace gantry::job
