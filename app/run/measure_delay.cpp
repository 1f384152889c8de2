#include "app/run/measure_delay.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <vector>

#include "app/job/jog.hpp"
#include "core/units.hpp"

namespace gantry::run {
namespace {

constexpr double kSteady_s = 0.5;        // of constant speed, in each direction
constexpr double kSettles = 0.5;         // of that time, until the lag has settled
constexpr double kSameSpeed = 1e-3;      // relative
constexpr double kMostDrift_s = 0.2e-3;  // of the lag, from the first half of what counts to the second
constexpr std::size_t kFewest = 20;

struct Sample {
  CycleIndex cycle = 0;
  double target = 0, actual = 0;
};

/// The longest stretch in which the target goes on at one speed.
std::span<const Sample> steady(const std::vector<Sample>& all, double cycle_s, double& speed) {
  std::span<const Sample> best;
  const auto speed_at = [&](std::size_t i) {
    return (all[i].target - all[i - 1].target) / (static_cast<double>(all[i].cycle - all[i - 1].cycle) * cycle_s);
  };
  for (std::size_t from = 1; from < all.size();) {
    const double v = speed_at(from);
    std::size_t to = from + 1;
    while (to < all.size() && std::abs(speed_at(to) - v) <= kSameSpeed * std::abs(v)) ++to;
    if (v != 0 && to - from > best.size()) best = std::span(all).subspan(from, to - from), speed = v;
    from = to;
  }
  return best;
}

double mean_lag(std::span<const Sample> samples, double speed) {
  double sum = 0;
  for (const Sample& s : samples) sum += (s.target - s.actual) / speed;
  return sum / static_cast<double>(samples.size());
}

struct Leg {
  double lag_s = 0, speed = 0;
};

Result<Leg> lag_of(const std::vector<Sample>& all, const config::Axis& axis, double cycle_s) {
  Leg leg;
  const auto run = steady(all, cycle_s, leg.speed);
  const auto counts = run.subspan(static_cast<std::size_t>(kSettles * static_cast<double>(run.size())));
  if (counts.size() < kFewest)
    return fail(Fault::Refused, "it was not long enough at one speed: was it held, or overridden? Measure again",
                "axis " + axis.name);
  leg.lag_s = mean_lag(counts, leg.speed);
  const auto half = counts.size() / 2;
  const double drift = std::abs(mean_lag(counts.first(half), leg.speed) - mean_lag(counts.subspan(half), leg.speed));
  const double count_s = 1 / (axis.counts_per_unit * std::abs(leg.speed));
  if (drift > kMostDrift_s + count_s)
    return fail(
        Fault::Refused,
        fmt::format("its lag has not settled: it drifts by {:.2f} ms at constant speed; measure at a lower --speed",
                    drift * 1e3),
        "axis " + axis.name);
  return leg;
}

Result<const config::Axis*> measured_axis(const config::Machine& machine, const std::string& name) {
  const auto found = job::axis_named(machine, name);
  if (!found) return found;
  const config::Axis* axis = *found;
  for (const config::DriveRef& ref : axis->drives)
    if (const auto& profile = machine.stations[ref.station.value].profile; !profile.drive->closed_loop)
      return fail(Fault::Refused,
                  fmt::format("{} runs open loop: its 6064h is the command, no measurement, so that its delay does not "
                              "show there; find it with an indicator or a camera, and state response_delay",
                              profile.title),
                  "axis " + name);
  if (axis->kind == config::AxisKind::Positioned)
    return fail(Fault::PositionedAxisInMove, "it positions by itself and has no response_delay", "axis " + name);
  return axis;
}

/// Ramps at both ends (v/a + a/j each, at half the speed on the mean), and what is measured.
double distance_at(const config::Axis& axis, double speed) {
  return speed * (kSteady_s + speed / axis.a_max + axis.a_max / axis.j_max);
}

Error too_short(const config::Axis& axis, double needed, double has) {
  const auto text = [&](double x) {
    return axis.rotary ? fmt::format("{:.6g} deg", units::deg(x)) : fmt::format("{:.6g} mm", x);
  };
  return {Fault::OutOfReach,
          fmt::format("it needs {} of travel at this speed, and has {}; measure at a lower --speed", text(needed),
                      text(has)),
          "axis " + axis.name};
}

}  // namespace

Result<double> measuring_speed(const config::Machine& machine, const DelayWords& words) {
  const auto found = measured_axis(machine, words.axis);
  if (!found) return tl::unexpected(found.error());
  const config::Axis& axis = **found;
  double speed = std::min(axis.rotary ? units::rad(45) : 50.0, axis.v_max / 2);
  if (!words.speed.empty()) {
    const auto asked =
        units::parse(words.speed, axis.rotary ? units::Dimension::AngularSpeed : units::Dimension::Speed);
    if (!asked) return fail(Fault::Usage, asked.error().message, "--speed");
    speed = *asked;
    if (speed > axis.v_max)
      return fail(Fault::Usage,
                  fmt::format("more than v_max of axis {}, {:.6g} {}/s; write that or less", axis.name,
                              axis.rotary ? units::deg(axis.v_max) : axis.v_max, axis.rotary ? "deg" : "mm"),
                  "--speed");
  }
  if (const double slowest = axis.rotary ? job::kSlowestJog_rad_s : job::kSlowestJog_mm_s; !(speed >= slowest))
    return fail(Fault::Usage, fmt::format("no slower than {}", axis.rotary ? "0.01 deg/s" : "0.01 mm/s"), "--speed");
  if (const double needed = distance_at(axis, speed); needed > axis.p_max - axis.p_min)
    return tl::unexpected(too_short(axis, needed, axis.p_max - axis.p_min));
  return speed;
}

Result<config::MeasuredDelay> measure_delay(Owner& owner, const config::Machine& machine, const DelayWords& words,
                                            const std::function<void()>& poll) {
  const auto asked = measuring_speed(machine, words);
  if (!asked) return tl::unexpected(asked.error());
  const config::Axis& axis = *config::find_axis(machine, words.axis);
  const double speed = *asked;
  const std::size_t i = axis.id.value;
  const double cycle_s = seconds(machine.bus.cycle);

  const double distance = distance_at(axis, speed);
  const double from = owner.latest().target[i], near = std::clamp(from, axis.p_min, axis.p_max);
  const double up = axis.p_max - near, down = near - axis.p_min;
  if (distance > std::max(up, down)) return tl::unexpected(too_short(axis, distance, std::max(up, down)));
  const double to = up >= down ? near + distance : near - distance;

  std::vector<Sample> samples;
  owner.on_step([&] {
    const cycle::Snapshot& s = owner.latest();
    if (s.inputs_fresh && (samples.empty() || samples.back().cycle != s.cycle))
      samples.push_back({s.cycle, s.target[i], s.actual[i]});
    if (poll) poll();
  });
  const auto leg = [&](double displacement) -> Result<Leg> {
    samples.clear();
    job::JogWords jog;
    jog.by[axis.name] =
        axis.rotary ? fmt::format("{:.12f} deg", units::deg(displacement)) : fmt::format("{:.12f} mm", displacement);
    jog.speed = axis.rotary ? fmt::format("{:.9f} deg/s", units::deg(speed)) : fmt::format("{:.9f} mm/s", speed);
    if (const auto gone = owner.jog(jog); !gone) return tl::unexpected(gone.error());
    return lag_of(samples, axis, cycle_s);
  };
  const auto there = leg(to - from);
  const auto back = there ? leg(near - to) : there;
  owner.on_step(poll);
  if (!back) return tl::unexpected(back.error());

  config::MeasuredDelay out;
  out.delay_s = (there->lag_s + back->lag_s) / 2 - cycle_s;
  out.speed = std::abs(back->speed);
  out.within_s = 1 / (axis.counts_per_unit * out.speed) + std::abs(there->lag_s - back->lag_s) / 2;
  return out;
}

}  // namespace gantry::run
