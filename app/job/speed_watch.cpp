#include "app/job/speed_watch.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "app/job/path_mm.hpp"
#include "app/job/slow_beads.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr double kSteady = 0.01;  // the plan changes its speed by less than this part of it
constexpr int kSteadyTicks = 5;   // before and after
constexpr double kRounding_mm = 1e-9;

}  // namespace

void SpeedWatch::begin(const std::deque<motion::Segment>& segments) {
  segments_ = &segments;
  next_ = 0;
  enter(motion::kTravel);
}

void SpeedWatch::end() {
  enter(motion::kTravel);
  segments_ = nullptr;
}

void SpeedWatch::enter(std::uint32_t feature) {
  feature_ = feature;
  material_ = nullptr;
  last_mm_s_ = 0;
  s_mm_ = t_s_ = 0;
  wet_ = false, wet_mm_ = 0;
  open_ticks_.reset();
  if (feature == motion::kTravel || feature >= recipe_.features.size()) return;
  const auto* bead = std::get_if<recipes::Bead>(&recipe_.features[feature]);
  const recipes::Material* material = bead != nullptr ? recipes::find_material(recipe_, bead->material) : nullptr;
  if (material == nullptr || material->flow_follows_speed) return;
  while (next_ < segments_->size() && (*segments_)[next_].feature != feature) ++next_;
  if (next_ == segments_->size()) return;
  segment_ = next_;
  material_ = material;
  may_round_ = bead->corner_tolerance > 0;
}

void SpeedWatch::see(const SpeedCycle& cycle) {
  if (segments_ == nullptr) return;
  if (cycle.feature != feature_) enter(cycle.feature);
  if (material_ == nullptr) return;
  valve_open_ = cycle.valve_open;
  go_on((last_mm_s_ + cycle.path_speed_mm_s) / 2 * tick_s_);
  last_mm_s_ = cycle.path_speed_mm_s;
  open_ticks_ = cycle.valve_open ? std::optional(open_ticks_.value_or(-1) + 1) : std::nullopt;
  // The valve is told ahead of the bead's start.
  if (open_ticks_ && *open_ticks_ * tick_s_ >= material_->valve_open_lead) judge(cycle.path_speed_mm_s);
}

void SpeedWatch::go_on(double by_mm) {
  s_mm_ += by_mm;
  for (;;) {
    const motion::Segment& segment = (*segments_)[segment_];
    const double length_mm = path_mm(segment);
    if (s_mm_ <= length_mm + kRounding_mm) break;
    if (segment_ + 1 >= segments_->size() || (*segments_)[segment_ + 1].feature != feature_) break;
    s_mm_ -= length_mm;
    leave(segment);
    ++segment_;
    t_s_ = 0;
  }
  const motion::SpeedProfile& plan = (*segments_)[segment_].nominal;
  const double lasts_s = motion::duration(plan), step_s = tick_s_ / 4;
  while (t_s_ < lasts_s && motion::along(plan, t_s_).x.p < s_mm_) t_s_ += step_s;
}

void SpeedWatch::leave(const motion::Segment& segment) {
  const double length_mm = path_mm(segment);
  if (wet_) wet_mm_ += length_mm;
  for (const motion::OutputEvent& e : segment.events) {
    if (e.dispense) wet_mm_ = length_mm - (length_mm > 0 ? e.at_s : 0);
    wet_ = e.dispense;
  }
  if (!wet_ || !valve_open_ || !segment.rests || !may_round_ || segment.kind == motion::SegmentKind::Dwell) return;
  OffSpeed& stood = seen();
  if (stood.stands++ == 0) stood.stands_at_mm = wet_mm_;
}

OffSpeed& SpeedWatch::seen() {
  const auto found = std::ranges::find(seen_, feature_, &OffSpeed::feature);
  return found != seen_.end() ? *found : seen_.emplace_back(OffSpeed{.feature = feature_});
}

std::optional<double> SpeedWatch::steady_speed() const {
  double slowest = 1e9, fastest = 0;
  for (int tick = -kSteadyTicks; tick <= kSteadyTicks; ++tick) {
    std::size_t segment = segment_;
    double t_s = t_s_ + tick * tick_s_;
    const auto on = [&](std::size_t i) { return i < segments_->size() && (*segments_)[i].feature == feature_; };
    while (t_s < 0 && segment > 0 && on(segment - 1)) t_s += motion::duration((*segments_)[--segment].nominal);
    for (double lasts_s; (lasts_s = motion::duration((*segments_)[segment].nominal)) < t_s && on(segment + 1);)
      t_s -= lasts_s, ++segment;
    const bool stands = (*segments_)[segment].kind == motion::SegmentKind::Dwell;
    const motion::SpeedProfile& plan = (*segments_)[segment].nominal;
    const double v = stands ? 0 : motion::along(plan, std::clamp(t_s, 0.0, motion::duration(plan))).x.v;
    slowest = std::min(slowest, v), fastest = std::max(fastest, v);
  }
  if (fastest - slowest > kSteady * fastest) return std::nullopt;
  return fastest;
}

void SpeedWatch::judge(double path_speed_mm_s) {
  // Ramps are looked for only where the speed is another one: a whole bead as planned costs nothing.
  const double allowed_mm_s = material_->speed_tolerance * material_->speed;
  if (std::abs(path_speed_mm_s - material_->speed) <= allowed_mm_s) return;
  const auto asked = steady_speed();
  if (!asked || std::abs(path_speed_mm_s - *asked) <= allowed_mm_s) return;
  OffSpeed& seen = this->seen();
  seen.length_mm += path_speed_mm_s * tick_s_;
  seen.due_mm += std::max(path_speed_mm_s, *asked) * tick_s_;
  if (seen.asked_mm_s == 0 || std::abs(path_speed_mm_s - *asked) > std::abs(seen.worst_mm_s - seen.asked_mm_s))
    seen.worst_mm_s = path_speed_mm_s, seen.asked_mm_s = *asked;
}

std::vector<OffSpeed> SpeedWatch::off_speed() const {
  std::vector<OffSpeed> out;
  for (OffSpeed each : seen_) {
    const auto& bead = std::get<recipes::Bead>(recipe_.features[each.feature]);
    if (each.due_mm <= recipes::find_material(recipe_, bead.material)->tolerance_mm) each.length_mm = each.due_mm = 0;
    if (each.stands <= reversals(bead)) each.stands = 0;
    if (each.due_mm > 0 || each.stands > 0) out.push_back(each);
  }
  return out;
}

}  // namespace gantry::job
