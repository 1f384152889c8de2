#include "app/job/slow_beads.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "app/job/level.hpp"
#include "app/job/valve_span.hpp"
#include "core/digits.hpp"
#include "core/steady_speed.hpp"
#include "motion/geometry.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr double kEnough = 0.5;      // of a bead's length is to be at its speed
constexpr double kLongest_mm = 1e4;  // a radius beyond it is none
constexpr double kStraight_mm = 0.01;

SteadySpeed planned_steady(const recipes::Material& m, double tick_s) {
  return SteadySpeed({.mm_s = m.speed, .tolerance = m.speed_tolerance}, tick_s);
}

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
  Tally(const recipes::Material& m, double tick_s)
      : asked_mm_s_(m.speed),
        allowed_mm_s_(m.speed_tolerance * m.speed),
        tick_s_(tick_s),
        steady_{planned_steady(m, tick_s), planned_steady(m, tick_s)} {}

  /// `lags`: the part of it that the tool may lose to its drives.
  void add(double v_mm_s, double lags) {
    if (!begins_mm_s_) begins_mm_s_ = v_mm_s;
    slows_down_ = slows_down_ || v_mm_s < fastest_mm_s_ - allowed_mm_s_;
    fastest_mm_s_ = std::max(fastest_mm_s_, v_mm_s);
    steady_.front().add(v_mm_s * tick_s_);
    steady_.back().add(v_mm_s * (1 - lags) * tick_s_);
  }

  /// Nothing where the bead is as its material wants it.
  [[nodiscard]] std::optional<SlowBead> slow(std::uint32_t feature) {
    for (SteadySpeed& each : steady_) {
      each.end_stretch();
      const auto held_mm_s = each.held_mm_s();
      const bool held = held_mm_s && !each.is_good(*held_mm_s);
      if (!held && each.within() >= kEnough) continue;
      SlowBead out{.feature = feature,
                   .asked_mm_s = asked_mm_s_,
                   .steady_mm_s = held ? *held_mm_s : 0,
                   .fastest_mm_s = fastest_mm_s_,
                   .at_speed = each.within(),
                   .narrowly = &each != &steady_.front()};
      if (!slows_down_ && begins_mm_s_ && !each.is_good(*begins_mm_s_)) out.begins_slowly_mm_s = begins_mm_s_;
      return out;
    }
    return std::nullopt;
  }

 private:
  double asked_mm_s_, allowed_mm_s_, tick_s_;
  std::array<SteadySpeed, 2> steady_;  ///< as the material wants it, and with what the drives may take of it
  std::optional<double> begins_mm_s_;
  double fastest_mm_s_ = 0;
  bool slows_down_ = false;
};

std::optional<SlowBead> look_at(SegmentIterator first, SegmentIterator last, const recipes::Material& m,
                                const ValveSpan& wet, const motion::Limits& limits) {
  const double tick_s = limits.tick_s, delay_s = longest_delay_s(limits);
  Tally tally(m, tick_s), unrounded(m, tick_s);
  double begin_mm = 0, begin_s = 0, rest_s = 0, factor = 1, open_s = 0;
  for (auto s = first; s != last; ++s) {
    if (s->kind == motion::SegmentKind::Dwell) continue;
    const double lasts_s = motion::duration(s->nominal);
    double t_s = rest_s;
    for (; t_s < lasts_s; t_s += tick_s) {
      const motion::State x = motion::along(s->nominal, t_s).x;
      if (begin_mm + x.p < wet.opens_mm || begin_mm + x.p > wet.shuts_mm) continue;
      factor = m.speed / s->v_cap;  // all of a bead is played slower by this, so that it takes whole ticks
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

/// The smallest on a curve that its points sample, seen from above: of the circle through three neighbours.
std::optional<double> radius_mm(const recipes::Bead& bead) {
  if (bead.curve_mm == 0) return std::nullopt;
  double least_mm = std::numeric_limits<double>::max();
  for (std::size_t i = 1; i + 1 < bead.points.size(); ++i) {
    const Vec3 a = bead.points[i - 1], b = bead.points[i], c = bead.points[i + 1];
    const double area = std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
    if (area > 0) least_mm = std::min(least_mm, norm(b - a) * norm(c - b) * norm(c - a) / (4 * area));
  }
  if (least_mm > kLongest_mm) return std::nullopt;
  return least_mm;
}

/// No corner that a tolerance could round.
bool is_straight(const recipes::Bead& bead) {
  const Vec3 along = bead.points.back() - bead.points.front();
  const double length = norm(along);
  return std::all_of(bead.points.begin(), bead.points.end(), [&](Vec3 p) {
    const Vec3 to = p - bead.points.front();
    const double on = length > 0 ? dot(to, along) / length : 0;
    return norm(to) * norm(to) - on * on < kStraight_mm * kStraight_mm;
  });
}

/// "20.84 ms"
std::string in_ms(double seconds) { return fmt::format("{:.4g} ms", seconds * 1e3); }

}  // namespace

void add_slow_beads(std::vector<SlowBead>& to, const recipes::Recipe& recipe,
                    const std::deque<motion::Segment>& segments, const motion::Limits& limits, const Breath& breath) {
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
    if (!found) found = look_at(first, s, *m, *wet, limits);
    if (found) to.push_back(*found);
  }
}

std::string standstill_in_words(std::size_t times, double at_mm, const recipes::Bead& bead,
                                const recipes::Material& material) {
  const double upright_mm = recipes::upright_tolerance_mm(bead.corner_tolerance, material);
  const bool by_gap = !is_level(bead) && upright_mm < bead.corner_tolerance;
  return fmt::format(
      "stands still {}with its valve open, {}{:.3g} mm from where that opens: no path without a stop was found within "
      "{}; write a larger one, or draw it with fewer points",
      times > 1 ? fmt::format("{} times ", times) : "", times > 1 ? "first " : "", at_mm,
      by_gap ? fmt::format("the {:.3g} mm that its gap and its `gap_tolerance` leave of its `corner_tolerance`",
                           upright_mm)
             : fmt::format("its `corner_tolerance` of {:.3g} mm", bead.corner_tolerance));
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

std::string in_words(const SlowBead& slow, const recipes::Recipe& recipe) {
  const auto& bead = std::get<recipes::Bead>(recipe.features[slow.feature]);
  const auto radius = radius_mm(bead);
  const bool straight = is_straight(bead);
  if (slow.stands > 0)
    return standstill_in_words(slow.stands, slow.stands_at_mm, bead, *recipes::find_material(recipe, bead.material));
  constexpr const char* kElse = "or `flow_follows_speed: true` where the dispenser doses by the speed of the needle";
  if (slow.narrowly)
    return fmt::format(
        "may be dispensed slower than its {:.3g} mm/s, but for its `speed_tolerance`: in narrow bends the drives' lag "
        "takes a part of the speed; write {}a larger radius or `corner_tolerance`, a larger `speed_tolerance`, {}",
        slow.asked_mm_s,
        slow.steady_mm_s > 0 ? fmt::format("`speed: {:.3g} mm/s`, ", in_digits_down(slow.steady_mm_s, 3)) : "", kElse);
  if (slow.lasts_s > 0)
    return fmt::format(
        "goes at {:.3g} mm/s instead of {:.3g} mm/s: it takes whole cycles of {}, {} instead of {}; write `speed: "
        "{:.4g} "
        "mm/s`, a larger `speed_tolerance`, {}",
        slow.fastest_mm_s, slow.asked_mm_s, in_ms(slow.tick_s), in_ms(slow.lasts_s), in_ms(slow.would_last_s),
        in_digits_up(slow.asked_mm_s * slow.would_last_s / slow.lasts_s, 4), kElse);
  if (slow.steady_mm_s == 0)
    return fmt::format(
        "comes to its {:.3g} mm/s along {:.0f} % of its length: {} for the axes' a_max and j_max; write a lower "
        "`speed`, {} {}",
        slow.asked_mm_s, slow.at_speed * 100,
        slow.begins_slowly_mm_s
            ? fmt::format(
                  "it begins {}, and its {:.3g} mm are too short to speed up",
                  *slow.begins_slowly_mm_s > 0 ? fmt::format("at {:.2g} mm/s", *slow.begins_slowly_mm_s) : "from rest",
                  recipes::length_mm(bead))
        : straight ? fmt::format("the {:.3g} mm of it are too short", recipes::length_mm(bead))
        : radius   ? fmt::format(
                         "its curve, radius {:.3g} mm at its narrowest and less by up to its `corner_tolerance`, is too "
                           "narrow",
                         *radius)
                 : std::string("its corners lie too near to each other"),
        slow.begins_slowly_mm_s || straight ? "draw it longer,"
        : radius                            ? "a larger radius, a smaller `corner_tolerance`,"
                                            : "a larger `corner_tolerance`,",
        kElse);
  if (slow.steady_mm_s < SteadySpeed::kCreeps * slow.asked_mm_s && !radius && !straight)
    return fmt::format(
        "creeps at {:.2g} mm/s instead of {:.3g} mm/s for a tenth of a second and more, where its corners lie too near "
        "to each other; draw it with fewer points there, write a lower `speed`, a larger `corner_tolerance`, {}",
        slow.steady_mm_s, slow.asked_mm_s, kElse);
  return fmt::format(
      "planned at {:.3g} mm/s instead of {:.3g} mm/s: the axes' limits allow no more on {}; write "
      "`speed: {:.3g} mm/s`,{} {}",
      slow.steady_mm_s, slow.asked_mm_s,
      radius     ? fmt::format("its curve, radius {:.3g} mm", *radius)
      : straight ? std::string("a straight line of its direction")
                 : std::string("its path"),
      in_digits_down(slow.steady_mm_s, 3),
      radius     ? " a larger radius,"
      : straight ? ""
                 : " a larger `corner_tolerance`,",
      kElse);
}

}  // namespace gantry::job
