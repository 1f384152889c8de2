#include "bench/profile/between_limits.hpp"

#include <array>
#include <cstdio>
#include <random>

#include "bench/profile/reintegrated.hpp"
#include "motion/profile/together.hpp"

namespace gantry::bench {
namespace {

constexpr std::size_t kAxes = 3;
constexpr double kLonger = 1.001;  // than the witness, at most

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}

  /// A case and a motion that solves it in `duration_s`; the limits leave `room` of its extent on either side.
  motion::AxisMove next(double duration_s, double room) {
    for (;;) {
      motion::AxisMove m;
      m.bounds = {bound(), -bound(), bound(), -bound(), bound(), -bound()};
      m.from = {normal_(random_), some(), some()};
      motion::Profile witness{m.from, {}};
      std::array<double, 6> cut;
      for (double& t : cut) t = unit_(random_) * duration_s;
      cut.back() = duration_s;
      std::sort(cut.begin(), cut.end());
      double at = 0, a = m.from.a;
      for (const double t : cut) {
        // As much jerk as keeps the acceleration within its bounds to the end of the phase.
        const double most = std::min(m.bounds.j_max, (m.bounds.a_max - a) / (t - at));
        const double least = std::max(m.bounds.j_min, (m.bounds.a_min - a) / (t - at));
        const double jerk = least + (most - least) * unit_(random_);
        witness.phases.push_back({t - at, jerk});
        a += jerk * (t - at), at = t;
      }
      m.to = motion::end_state(witness);
      const Excess e = reintegrate(witness, m.to, m.bounds, true, true);
      if (e.limit > 0 || !stays(m.from, m.bounds, 1) || !stays(m.to, m.bounds, -1)) continue;
      const motion::Extent gone = motion::extent(witness);
      m.bounds.p_min = gone.low - room * (gone.high - gone.low) * unit_(random_);
      m.bounds.p_max = gone.high + room * (gone.high - gone.low) * unit_(random_);
      return m;
    }
  }
  double uniform(double low, double high) { return low + (high - low) * unit_(random_); }

 private:
  static bool stays(const motion::State& x, const motion::AxisBounds& b, int sign) {
    const double jerk = (x.a > 0) == (sign > 0) ? -b.j_min : b.j_max;
    const double other = x.v + sign * x.a * std::abs(x.a) / (2 * jerk);
    return std::max(x.v, other) <= b.v_max && std::min(x.v, other) >= b.v_min && x.a <= b.a_max && x.a >= b.a_min;
  }
  double bound() { return uniform(0.5, 4); }
  double some() { return unit_(random_) < 0.25 ? 0.0 : 0.8 * normal_(random_); }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

}  // namespace

bool between_limits(std::uint64_t cases, unsigned seed) {
  Draw draw(seed);
  std::uint64_t failed = 0, longer = 0, wrong = 0, bent = 0;
  double worst_end = 0, worst_limit = 0, worst_out = 0;
  for (std::uint64_t n = 0; n < cases; ++n) {
    const double duration_s = draw.uniform(0.3, 8), room = std::pow(10.0, draw.uniform(-3.5, -0.5));
    std::array<motion::AxisMove, kAxes> axes, open;
    for (auto& m : axes) m = draw.next(duration_s, room);
    open = axes;
    for (auto& m : open) m.bounds.p_min = -HUGE_VAL, m.bounds.p_max = HUGE_VAL;
    const motion::Together how{.min_duration_s = draw.uniform(0, 1) < 0.5 ? 0 : duration_s};
    const motion::Joint joint = motion::move_together(axes, how), unlimited = motion::move_together(open, how);
    failed += !joint;
    longer += joint && joint.duration_s > kLonger * duration_s;
    if (!joint || joint.duration_s > kLonger * duration_s)
      std::printf("case %lu: %s, axis %d, %.6g s, witness %.6g s\n", n, motion::name(joint.reason), joint.axis,
                  joint.duration_s, duration_s);
    for (std::size_t i = 0; joint && i < kAxes; ++i) {
      const motion::AxisMove& m = axes[i];
      const Excess e = reintegrate(joint.profiles[i], m.to, m.bounds, true, true);
      const double out = outside(joint.profiles[i], m.to, m.bounds);
      worst_end = std::max(worst_end, e.end), worst_limit = std::max(worst_limit, e.limit);
      worst_out = std::max(worst_out, out);
      const double late = std::abs(motion::duration(joint.profiles[i]) - joint.duration_s);
      wrong += e.end > 1e-9 || e.limit > 1e-9 || out > 1e-9 || late > 1e-12 * (1 + joint.duration_s);
      bent += outside(unlimited.profiles[i], m.to, m.bounds) > 1e-9;
    }
  }
  std::printf(
      "%zu axes between limits        %9lu solved of %lu, %lu longer than their witness; %lu wrong (end %.1e, "
      "limit %.1e, outside %.1e); %lu axes that would leave them\n",
      kAxes, cases - failed, cases, longer, wrong, worst_end, worst_limit, worst_out, bent);
  return failed + longer + wrong == 0;
}

}  // namespace gantry::bench
