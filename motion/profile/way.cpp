#include "motion/profile/way.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

/// share * up + (1 - share) * down, cut where either changes its jerk.
void append(Profile& profile, const scaled::Mix& mix, const Scale& scale) noexcept {
  int i = 0, k = 0;
  double left_up = mix.up.t[0], left_down = mix.down.t[0];
  for (;;) {
    while (left_up <= 0 && ++i < 7) left_up = mix.up.t[i];
    while (left_down <= 0 && ++k < 7) left_down = mix.down.t[k];
    if (i >= 7 || k >= 7) return;
    const double t = std::min(left_up, left_down);
    append(profile, t * scale.t, (mix.share * mix.up.j[i] + (1 - mix.share) * mix.down.j[k]) * scale.j);
    left_up -= t, left_down -= t;
  }
}

}  // namespace

Way::Way(const State& from, const State& to, const AxisBounds& bounds, Outside outside) noexcept
    : entered_{from, {}}, to_(to), scale_(bounds) {
  const State inside = enter(from, bounds, outside, entered_);
  const double scale_p = position_scale(from, to, bounds);
  entered_s_ = duration(entered_);
  p_ = (to.p - inside.p) / scale_.p;
  resolution_ = kResolution * scale_p / scale_.p;
  tolerance_ = 1e-9 * scale_p;
  reachable_.emplace(scale_.ends(inside, to), scale_.box);
  shortest_ = reachable_->first(p_, resolution_);
}

double Way::first_s(double t) noexcept {
  if (t <= shortest_s() * (1 + kEqual)) return shortest_s();
  const scaled::Found found = reachable_->first(p_, resolution_, (t - entered_s_) / scale_.t);
  return found.side == scaled::Side::None ? -1 : entered_s_ + found.duration * scale_.t;
}

bool Way::write(double t, Profile& profile) noexcept {
  profile = entered_;
  if (std::abs(t - shortest_s()) <= kEqual * t) {
    append(profile, reachable_->shape(shortest_), scale_);
  } else {
    const scaled::Mix mix = reachable_->mix((t - entered_s_) / scale_.t, p_, 10 * resolution_);
    if (!mix.possible) return false;
    if (mix.share >= 1)
      append(profile, mix.up, scale_);
    else if (mix.share <= 0)
      append(profile, mix.down, scale_);
    else
      append(profile, mix, scale_);
  }
  const State end = end_state(profile);
  return std::abs(end.p - to_.p) <= tolerance_ &&
         std::abs(end.v - to_.v) <= 1e-9 * scale_.v * std::max(scale_.box.v_up, scale_.box.v_down) &&
         std::abs(end.a - to_.a) <= 1e-9 * scale_.a;
}

double on_grid(double t, double cycle_s) noexcept {
  return cycle_s > 0 ? std::ceil(t / cycle_s * (1 - kEqual)) * cycle_s : t;
}

}  // namespace gantry::motion
