#include "app/job/slow_beads.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "app/job/limits.hpp"
#include "app/job/valve_span.hpp"
#include "core/steady_speed.hpp"
#include "motion/geometry.hpp"
#include "motion/profile/speed_profile.hpp"
#include "recipes/asked_speed.hpp"

namespace gantry::job {
namespace {

constexpr double kSurely = 0.02;    // so much more, and a world finds it so, too: its clock is not the plan's
constexpr double kLagsLess = 0.9;   // of what a material allows: a lag that is let pass for sure
constexpr double kLower = 0.95;     // of a speed that it holds, and one that it comes down to is another
constexpr double kStrictly = 1.15;  // than a world judges: what is let pass by so little may be none there

double longest_delay_s(const motion::Limits& limits) {
  double delay_s = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (limits.linear[i]) delay_s = std::max(delay_s, limits.response_delay_s[i]);
  return delay_s;
}

/// The part of its speed that the tool loses in a bend: drives that lag by t make a radius r, and with it the speed on
/// it, smaller by (v t / r)^2 / 2.
double lag_share(const motion::Geometry& g, const motion::State& x, const motion::Limits& limits, double delay_s) {
  const auto bent = motion::derivative<2>(g, x.p);
  double curvature = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (limits.linear[i]) curvature = std::hypot(curvature, bent[i]);
  return std::min(1.0, std::pow(x.v * delay_s * curvature, 2) / 2);
}

/// The speeds of one bead, tick by tick, against what its material wants.
class Tally {
 public:
  Tally(const AskedSpeed& asked, double tick_s)
      : asked_mm_s_(asked.mm_s),
        allowed_mm_s_(asked.tolerance * asked.mm_s),
        tick_s_(tick_s),
        steady_{SteadySpeed(asked, tick_s), SteadySpeed(asked, tick_s, kStrictly)} {}

  /// `lags`: the part of it that the tool may lose to its drives.
  void add(double v_mm_s, double lags) {
    if (!begins_mm_s_) begins_mm_s_ = v_mm_s;
    slows_down_ = slows_down_ || v_mm_s < fastest_mm_s_ - allowed_mm_s_;
    fastest_mm_s_ = std::max(fastest_mm_s_, v_mm_s);
    if (steady_.front().is_good(v_mm_s)) lags_ = std::max(lags_, lags);
    steady_.front().add(v_mm_s * tick_s_);
    steady_.back().add(v_mm_s * (1 - lags) * tick_s_);
  }

  /// Nothing where the bead is as its material wants it.
  [[nodiscard]] std::optional<SlowBead> slow(std::uint32_t feature) {
    for (SteadySpeed& each : steady_) {
      each.end_stretch();
      const auto held_mm_s = each.held_mm_s();
      const bool held = held_mm_s && !each.is_good(*held_mm_s), narrowly = &each != &steady_.front();
      const auto sag = each.sag();
      if (!held && !sag && each.within() >= SteadySpeed::kEnough + (narrowly ? kSurely : 0)) continue;
      SlowBead out{.feature = feature,
                   .asked_mm_s = asked_mm_s_,
                   .steady_mm_s = held ? *held_mm_s : 0,
                   .fastest_mm_s = fastest_mm_s_,
                   .at_speed = each.within(),
                   .narrowly = narrowly};
      if (sag && (!held || sag->low_mm_s < kLower * *held_mm_s))
        out.steady_mm_s = sag->low_mm_s, out.sags_s = sag->lasts_s;
      // The drives' lag takes a part that goes by the square of the speed.
      if (narrowly && held && lags_ > 0) {
        out.lags = lags_;
        const double lags_less_mm_s = asked_mm_s_ * std::sqrt(kLagsLess * allowed_mm_s_ / asked_mm_s_ / lags_);
        out.steady_mm_s = std::min(out.steady_mm_s, lags_less_mm_s);
      }
      if (!slows_down_ && begins_mm_s_ && !each.is_good(*begins_mm_s_)) out.begins_slowly_mm_s = begins_mm_s_;
      return out;
    }
    return std::nullopt;
  }

 private:
  double asked_mm_s_, allowed_mm_s_, tick_s_;
  std::array<SteadySpeed, 2> steady_;  ///< as the material wants it, and more strictly: a world may see it otherwise
  std::optional<double> begins_mm_s_;
  double fastest_mm_s_ = 0;
  double lags_ = 0;  ///< the most that the tool may lose to its drives where its planned speed is good
  bool slows_down_ = false;
};

std::optional<SlowBead> look_at(SegmentIterator first, SegmentIterator last, const AskedSpeed& asked,
                                const ValveSpan& wet, const motion::Limits& limits) {
  const double tick_s = limits.tick_s, delay_s = longest_delay_s(limits);
  Tally tally(asked, tick_s), unrounded(asked, tick_s);
  double begin_mm = 0, begin_s = 0, rest_s = 0, factor = 1, open_s = 0;
  for (auto s = first; s != last; ++s) {
    if (s->kind == motion::SegmentKind::Dwell) continue;
    const double lasts_s = motion::duration(s->nominal);
    double t_s = rest_s;
    for (; t_s < lasts_s; t_s += tick_s) {
      const motion::State x = motion::along(s->nominal, t_s).x;
      if (begin_mm + x.p < wet.opens_mm || begin_mm + x.p > wet.shuts_mm) continue;
      factor = asked.mm_s / s->v_cap;  // all of a bead is played slower by this, so that it takes whole ticks
      const double lags = lag_share(s->geometry, x, limits, delay_s);
      tally.add(x.v, lags), unrounded.add(x.v * factor, lags);
    }
    for (const auto& [at_mm, sign] : {std::pair{wet.opens_mm, -1}, std::pair{wet.shuts_mm, 1}})
      if (at_mm > begin_mm && at_mm <= begin_mm + s->geometry.length)
        open_s += sign * (begin_s + motion::time_at(s->nominal, at_mm - begin_mm));
    rest_s = t_s - lasts_s;
    begin_mm += s->geometry.length, begin_s += lasts_s;
  }
  auto slow = tally.slow(first->feature);
  if (slow && factor > 1 && !unrounded.slow(first->feature))
    slow->lasts_s = open_s, slow->would_last_s = open_s / factor, slow->tick_s = tick_s;
  return slow;
}

/// Where it comes to rest between the two.
std::optional<SlowBead> stands(SegmentIterator first, SegmentIterator last, const ValveSpan& wet) {
  constexpr double kSamePoint_mm = 1e-6;
  SlowBead out{.feature = first->feature};
  double at_mm = 0;
  for (auto s = first; s != last; ++s) {
    at_mm += path_mm(*s);
    if (!s->rests || at_mm <= wet.opens_mm + kSamePoint_mm || at_mm >= wet.shuts_mm - kSamePoint_mm) continue;
    if (out.stands++ == 0) out.stands_at_mm = at_mm - wet.opens_mm;
  }
  if (out.stands == 0) return std::nullopt;
  return out;
}

}  // namespace

void add_slow_beads(std::vector<SlowBead>& to, const recipes::Recipe& recipe,
                    const std::deque<motion::Segment>& segments, const config::Machine& machine, const Breath& breath) {
  const motion::Limits limits = limits_of(machine);
  Pauses pause(breath, 1024);
  for (auto s = segments.begin(); s != segments.end();) {
    const auto first = s;
    const std::uint32_t feature = first->feature;
    s = std::find_if(first, segments.end(),
                     [&](const motion::Segment& each) { return pause(), each.feature != feature; });
    if (feature >= recipe.features.size()) continue;
    const auto* bead = std::get_if<recipes::Bead>(&recipe.features[feature]);
    const recipes::Material* m = bead != nullptr ? recipes::find_material(recipe, bead->material) : nullptr;
    if (m == nullptr || m->flow_follows_speed) continue;
    const auto wet = valve_span(first, s, feature);
    if (!wet || wet->shuts_mm <= wet->opens_mm) continue;
    auto found = bead->corner_tolerance > 0 ? stands(first, s, *wet) : std::nullopt;
    if (found && found->stands <= reversals(*bead)) found.reset();
    if (!found) {
      const AskedSpeed asked = recipes::asked_speed(machine, bead->points, m->speed, m->speed_tolerance);
      found = look_at(first, s, asked, *wet, limits);
    }
    if (found) to.push_back(*found);
  }
}

std::size_t reversals(const recipes::Bead& bead) {
  constexpr double kStraightBack = 1e-9;
  std::size_t found = 0;
  Vec3 before{};
  for (std::size_t i = 1; i < bead.points.size(); ++i) {
    const Vec3 leg = bead.points[i] - bead.points[i - 1];
    if (!(norm(leg) > 0)) continue;
    found += dot(before, leg) < -(1 - kStraightBack) * norm(before) * norm(leg);
    before = leg;
  }
  return found;
}

}  // namespace gantry::job
