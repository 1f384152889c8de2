#include "devices/rt/home_edge.hpp"

#include <cmath>
#include <cstdlib>

namespace gantry::devices {
namespace {

constexpr double kMostOfCycle = 2;  // of its faster speed; a drive overshoots when it starts

}  // namespace

HomeEdge::HomeEdge(const HomingRules& rules, std::int64_t within, const Feedback& f) noexcept
    : reference_(rules.reference & rules.known),
      level_(closed_switches(f) & reference_),
      within_(within),
      most_(std::llround(kMostOfCycle * rules.counts_per_cycle) + 1),
      last_(f.counts) {
  // One that is read now and then is seen too late to say where.
  if (f.inputs != InputSource::EveryCycle || rules.counts_per_cycle <= 0) within_ = 0;
}

void HomeEdge::look(const Feedback& f, std::int64_t elapsed) noexcept {
  const std::int64_t step = f.counts.value - last_.value;
  last_ = f.counts;
  if (std::abs(step) <= most_ * elapsed) travelled_ += step;
  const auto level = static_cast<std::uint8_t>(closed_switches(f) & reference_);
  if (level == level_) return;
  level_ = level;
  seen_ = true;
  travelled_ = 0;
}

bool HomeEdge::agrees(std::int64_t off) const noexcept {
  return within_ <= 0 || !seen_ || std::abs(off - travelled_) <= within_;
}

}  // namespace gantry::devices
