// What a slow bead is told: how slow it is, why, and what would help.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "app/job/level.hpp"
#include "app/job/slow_beads.hpp"
#include "core/digits.hpp"
#include "core/steady_speed.hpp"

namespace gantry::job {
namespace {

constexpr double kLongest_mm = 1e4;  // a radius beyond it is none
constexpr double kStraight_mm = 0.01;
constexpr const char* kElse = "or `flow_follows_speed: true` where the dispenser doses by the speed of the needle";

/// Chords that turn by less than that sample a curve, wherever they come from.
constexpr double kSmooth = 0.5;  // rad
constexpr std::size_t kFewest = 5;

bool is_smooth(const std::vector<Vec3>& points) {
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vec3 in = points[i] - points[i - 1], out = points[i + 1] - points[i];
    if (!(dot(in, out) > std::cos(kSmooth) * norm(in) * norm(out))) return false;
  }
  return points.size() >= kFewest;
}

/// The smallest on a curve that its points sample: of the circle through three neighbours.
std::optional<double> radius_mm(const recipes::Bead& bead) {
  if (bead.curve_mm == 0 && !is_smooth(bead.points)) return std::nullopt;
  double least_mm = std::numeric_limits<double>::max();
  for (std::size_t i = 1; i + 1 < bead.points.size(); ++i) {
    const Vec3 a = bead.points[i - 1], b = bead.points[i], c = bead.points[i + 1];
    const double area = norm(cross(b - a, c - a)) / 2;
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

/// What its shape is to its speed.
struct Shape {
  double length_mm = 0;
  std::optional<double> radius_mm{};  ///< of a curve
  bool straight = false;
};

std::string narrowly(const SlowBead& slow) {
  const std::string why =
      slow.sags_s > 0
          ? fmt::format("it slows down to {:.3g} mm/s, and is too slow for {}, hardly less than is a defect",
                        slow.steady_mm_s, in_ms(slow.sags_s))
      : slow.lags > 0 ? fmt::format("in narrow bends the drives' lag takes {:.2g} % of the speed", slow.lags * 100)
      : slow.steady_mm_s > 0
          ? fmt::format("it is planned at {:.3g} mm/s for nearly as long as is a defect", slow.steady_mm_s)
          : fmt::format(
                "it is planned so along {:.0f} % of its length, hardly more than the half that it must be, and "
                "the drives' lag takes a part of the speed",
                slow.at_speed * 100);
  return fmt::format(
      "may be dispensed slower than its {:.3g} mm/s, but for its `speed_tolerance`: {}; write {}a larger radius or "
      "`corner_tolerance`, a larger `speed_tolerance`, {}",
      slow.asked_mm_s, why,
      slow.steady_mm_s > 0 ? fmt::format("`speed: {:.3g} mm/s`, ", in_digits_down(slow.steady_mm_s, 3)) : "", kElse);
}

std::string by_whole_cycles(const SlowBead& slow) {
  return fmt::format(
      "goes at {:.3g} mm/s instead of {:.3g} mm/s: it takes whole cycles of {}, {} instead of {}; write `speed: {:.4g} "
      "mm/s`, a larger `speed_tolerance`, {}",
      slow.fastest_mm_s, slow.asked_mm_s, in_ms(slow.tick_s), in_ms(slow.lasts_s), in_ms(slow.would_last_s),
      in_digits_up(slow.asked_mm_s * slow.would_last_s / slow.lasts_s, 4), kElse);
}

/// It holds no speed, and has its own along too little of its length.
std::string mostly_slow(const SlowBead& slow, const Shape& shape) {
  std::string why, remedy;
  if (slow.begins_slowly_mm_s) {
    const double from_mm_s = *slow.begins_slowly_mm_s;
    why = fmt::format("it begins {}, and its {:.3g} mm are too short to speed up",
                      from_mm_s > 0 ? fmt::format("at {:.2g} mm/s", from_mm_s) : "from rest", shape.length_mm);
    remedy = "draw it longer";
  } else if (shape.straight) {
    why = fmt::format("the {:.3g} mm of it are too short", shape.length_mm);
    remedy = "draw it longer";
  } else if (shape.radius_mm) {
    why = fmt::format(
        "its curve, radius {:.3g} mm at its narrowest and less by up to its `corner_tolerance`, is too narrow",
        *shape.radius_mm);
    remedy = "a larger radius, a smaller `corner_tolerance`";
  } else {
    why = "its corners lie too near to each other";
    remedy = "a larger `corner_tolerance`";
  }
  return fmt::format(
      "comes to its {:.3g} mm/s along {:.0f} % of its length: {} for the axes' a_max and j_max; write a lower `speed`, "
      "{}, {}",
      slow.asked_mm_s, slow.at_speed * 100, why, remedy, kElse);
}

/// From corner to corner, or around a corner that is rounded widely.
std::string slow_at_corners(const SlowBead& slow) {
  if (slow.sags_s > 0)
    return fmt::format(
        "slows down to {:.2g} mm/s instead of {:.3g} mm/s at its corners, and is too slow for {}: they follow too near "
        "upon each other, or a `corner_tolerance` rounds them more widely than its `speed_tolerance` allows; draw it "
        "with fewer points there, write a lower `speed`, another `corner_tolerance`, {}",
        slow.steady_mm_s, slow.asked_mm_s, in_ms(slow.sags_s), kElse);
  return fmt::format(
      "creeps at {:.2g} mm/s instead of {:.3g} mm/s for a tenth of a second and more, where its corners lie too near "
      "to each other; draw it with fewer points there, write a lower `speed`, a larger `corner_tolerance`, {}",
      slow.steady_mm_s, slow.asked_mm_s, kElse);
}

/// It holds a lower speed, or comes down to it for longer than a corner does.
std::string too_fast_for_its_axes(const SlowBead& slow, const Shape& shape) {
  const std::string on = shape.radius_mm  ? fmt::format("its curve, radius {:.3g} mm", *shape.radius_mm)
                         : shape.straight ? "a straight line of its direction"
                                          : "its path";
  return fmt::format(
      "{} {:.3g} mm/s instead of {:.3g} mm/s{}: the axes' limits allow no more on {}; write `speed: {:.3g} mm/s`,{} {}",
      slow.sags_s > 0 ? "slows down to" : "planned at", slow.steady_mm_s, slow.asked_mm_s,
      slow.sags_s > 0 ? fmt::format(", and is too slow for {}", in_ms(slow.sags_s)) : std::string(), on,
      in_digits_down(slow.steady_mm_s, 3),
      shape.radius_mm  ? " a larger radius,"
      : shape.straight ? ""
                       : " a larger `corner_tolerance`,",
      kElse);
}

}  // namespace

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

std::string in_words(const SlowBead& slow, const recipes::Recipe& recipe) {
  const auto& bead = std::get<recipes::Bead>(recipe.features[slow.feature]);
  if (slow.stands > 0)
    return standstill_in_words(slow.stands, slow.stands_at_mm, bead, *recipes::find_material(recipe, bead.material));
  const Shape shape{recipes::length_mm(bead), radius_mm(bead), is_straight(bead)};
  if (slow.narrowly) return narrowly(slow);
  if (slow.lasts_s > 0) return by_whole_cycles(slow);
  if (slow.steady_mm_s == 0) return mostly_slow(slow, shape);
  const bool corners = slow.sags_s > 0 || slow.steady_mm_s < SteadySpeed::kCreeps * slow.asked_mm_s;
  return corners && !shape.radius_mm && !shape.straight ? slow_at_corners(slow) : too_fast_for_its_axes(slow, shape);
}

}  // namespace gantry::job
