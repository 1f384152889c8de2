#include "app/record/trace.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gantry::record {
namespace {

constexpr double kEvery_s = 0.0095;     // "about every 10 ms" on a 1 ms grid
constexpr double kStanding_mm = 0.002;  // below this the head stands: a few counts
constexpr double kTurned_cos = 0.9962;  // 5 degrees
constexpr double kTurned_mm = 0.02;     // a turn shorter than this is not visible and may be quantisation

bool turned(const Vec3& from, const Vec3& by, const Vec3& to) {
  const Vec3 a = by - from, b = to - by;
  const double na = norm(a), nb = norm(b);
  return na > kTurned_mm && nb > kTurned_mm && dot(a, b) < kTurned_cos * na * nb;
}

Quantiles quantiles(const rt::Histogram& h) { return {h.quantile(0.5), h.quantile(0.99), h.quantile(0.999), h.max()}; }

std::vector<HistogramBucket> buckets(const rt::Histogram& h) {
  std::vector<HistogramBucket> result;
  h.for_each([&](std::int64_t upper_ns, std::uint64_t count) { result.push_back({upper_ns, count}); });
  return result;
}

}  // namespace

void ThinPath::add(const PathPoint& p) {
  if (kept_.empty()) {
    kept_.push_back(p);
    return;
  }
  const PathPoint& kept = kept_.back();
  const bool marked = p.valve != kept.valve || p.block != kept.block;
  const bool moved = norm(p.head - kept.head) > kStanding_mm;
  // Leaving a standstill or a corner: the point before belongs to the picture.
  const bool left = last_ && ((moved && norm(last_->head - kept.head) <= kStanding_mm) ||
                              turned(kept.head, last_->head, p.head) || marked);
  if (left) {
    kept_.push_back(*last_);
    last_.reset();
  }
  if (marked || (moved && p.t_s - kept_.back().t_s >= kEvery_s)) {
    kept_.push_back(p);
    last_.reset();
  } else {
    last_ = p;
  }
}

Path ThinPath::take() {
  if (last_) kept_.push_back(*last_);
  last_.reset();
  return std::exchange(kept_, {});
}

Trace::Trace(const config::Machine& machine, std::optional<std::int64_t> start_ns)
    : xyz_{machine.x.value, machine.y.value, machine.z.value},
      lift_(machine.u ? std::optional<std::size_t>(machine.u->value) : std::nullopt),
      turn_(machine.c ? std::optional<std::size_t>(machine.c->value) : std::nullopt),
      cycle_ns_(machine.bus.cycle.count()),
      start_ns_(start_ns) {
  for (const auto& axis : machine.axes)
    axes_.push_back({.name = axis.name,
                     .rotary = axis.rotary,
                     .allowed_at_rest = axis.following_base,
                     .allowed_at_v_max = axis.following_base + axis.following_per_speed_s * axis.v_max,
                     .per_speed_s = axis.following_per_speed_s});
}

void Trace::add(const cycle::Snapshot& s) {
  add_cycle(s);
  add_valve(s);
  add_following(s);
  if (s.block == 0) return;

  ++block_ticks_;
  if (!start_ns_) start_ns_ = s.time_ns;
  path_.add({.t_s = static_cast<double>(s.time_ns - *start_ns_) * 1e-9,
             .head = {s.actual[xyz_[0]], s.actual[xyz_[1]], s.actual[xyz_[2]]},
             .block = s.block,
             .valve = valve_,
             .lift_mm = lift_ ? s.actual[*lift_] : 0,
             .turn_rad = turn_ ? s.actual[*turn_] : 0});
}

/// The largest, and what is allowed at the speed that the axis has in that cycle.
void Trace::add_following(const cycle::Snapshot& s) {
  const double passed_s = static_cast<double>((s.cycle - std::exchange(target_cycle_, s.cycle)) * cycle_ns_) * 1e-9;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    const double moved = std::abs(s.target[i] - std::exchange(axis.target, s.target[i]));
    const bool seen = s.block != 0 && s.sent && s.inputs_fresh && (s.enabled >> i & 1u) != 0;
    if (!seen || !std::isfinite(s.following[i])) continue;
    const double off = std::abs(s.following[i]),
                 allowed = axis.allowed_at_rest + (passed_s > 0 ? axis.per_speed_s * moved / passed_s : 0);
    if (allowed > 0 && start_ns_) axis.over_time.add(static_cast<double>(s.time_ns - *start_ns_) * 1e-9, off, allowed);
    if (axis.measured && off <= axis.max_following) continue;
    axis.measured = true;
    axis.max_following = off;
    axis.allowed_there = allowed;
  }
}

void Trace::add_cycle(const cycle::Snapshot& s) {
  ++cycles_.cycles;
  if (!s.sent) {
    ++cycles_.skipped;
    ++cycles_.deadline_misses;
    ++asleep_;
    return;
  }
  ++cycles_.sent;
  // How late against the beat that the loop had asked for: the first of those that it slept through.
  wake_.add(s.wake_ns + asleep_ * cycle_ns_);
  cycles_.stalls += asleep_ > 0 || s.wake_ns >= cycle_ns_;
  asleep_ = 0;
  compute_.add(s.compute_ns);
  bus_.add(s.bus_ns);
  if (std::int64_t{s.wake_ns} + s.compute_ns + s.bus_ns > cycle_ns_) ++cycles_.deadline_misses;
  if (s.state == cycle::State::Offline) return;
  if (!s.answered) {
    ++cycles_.frames_lost;
  } else if (!s.complete) {
    ++cycles_.working_counter_errors;
  }
}

void Trace::add_valve(const cycle::Snapshot& s) {
  const bool open = s.outputs & config::bit(config::Output::Valve);
  if (open) {
    ++valve_ticks_;
    if (!valve_) ++valve_openings_;
  }
  valve_ = open;
}

void Trace::fill(JobResult& r) {
  r.actual = path_.take();
  r.actual_s = static_cast<double>(block_ticks_) * static_cast<double>(cycle_ns_) * 1e-9 + r.images_s;
  r.axes.clear();
  for (const auto& a : axes_)
    r.axes.push_back({.name = a.name,
                      .measured = a.measured,
                      .max_following = a.max_following,
                      .allowed_there = a.allowed_there,
                      .rotary = a.rotary,
                      .allowed_at_rest = a.allowed_at_rest,
                      .allowed_at_v_max = a.allowed_at_v_max,
                      .over_time = a.over_time.points()});
  r.valve_openings = valve_openings_;
  r.valve_open_s = static_cast<double>(valve_ticks_) * static_cast<double>(cycle_ns_) * 1e-9;

  // What the thread and the clock know of themselves stays as the caller has set it.
  auto counted = cycles_;
  counted.real_time_priority = r.cycles.real_time_priority;
  counted.memory_locked = r.cycles.memory_locked;
  counted.virtual_time = r.cycles.virtual_time;
  counted.wake = quantiles(wake_), counted.compute = quantiles(compute_), counted.bus = quantiles(bus_);
  counted.wake_histogram = buckets(wake_);
  counted.compute_histogram = buckets(compute_);
  r.cycles = std::move(counted);
}

}  // namespace gantry::record
