// How what waits in a builder is taken: as one arch, across as early as is free, or motion by motion.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/job/block_builder.hpp"
#include "core/meeting.hpp"
#include "motion/path/arch.hpp"
#include "motion/path/chords.hpp"
#include "motion/plan/as_sent.hpp"

namespace gantry::job {
namespace {

constexpr std::array kRoom{1.0, 1.0 / 8, 1.0 / 64, 1.0 / 512};  // of what targets are beside a path at full speed
constexpr std::array kUp_mm{1.0, 4.0, 16.0, 64.0};              // from where an end of a path leaves no room beside it
constexpr int kSteps = 4;  // in which the motions up and down go on alone for longer, where across is not free yet

double level_mm(const motion::Scene& scene, const AxisVec& a, const AxisVec& b) {
  return std::hypot(a[scene.x()] - b[scene.x()], a[scene.y()] - b[scene.y()]);
}

/// How long one end of an arch goes up or down alone.
struct End {
  double least_mm = 0, all_mm = 0;
  int step = 0;
  [[nodiscard]] double alone_mm() const { return least_mm + (all_mm - least_mm) * step / kSteps; }
};

End end_of(bool work, double alone_mm, double all_mm) {
  return {work ? std::min(alone_mm, all_mm) : all_mm / 2, all_mm, all_mm > 0 ? 0 : kSteps};
}

}  // namespace

/// The order is up, path, down; what does not go on in it begins anew.
Result<void> BlockBuilder::wait_for_next(Proved proved) {
  const bool path = proved.turning.has_value();
  const bool has_path = std::any_of(waiting_.begin(), waiting_.end(), [](const Proved& p) { return p.turning; });
  const bool goes_on = waiting_.empty() || (path ? !has_path : waiting_.back().turning.has_value());
  if (!goes_on)
    if (auto settled = settle(); !settled) return settled;
  proved.scene = scene_;
  proved.subject = subject_;
  at_ = proved.points.back();
  waiting_.push_back(std::move(proved));
  return {};
}

Result<void> BlockBuilder::settle() {
  std::vector<Proved> legs = std::exchange(waiting_, {});
  if (legs.empty()) return {};
  for (;;) {
    const Result<bool> taken = take_as_arch(legs);
    if (!taken) return tl::unexpected(taken.error());
    if (*taken) return {};
    const Result<bool> other = find_room(legs);
    if (!other) return tl::unexpected(other.error());
    if (!*other) return take_legs(legs);
  }
}

/// Where targets that are sent beside a path are not free, another path that leaves them room. False: it is free, or
/// there is none; then the path is gone along so slowly that it is, where any speed is slow enough: a path that leads
/// along a body at the very clearance leaves targets no room at all.
Result<bool> BlockBuilder::find_room(std::span<Proved> legs) const {
  const auto path = std::find_if(legs.begin(), legs.end(), [](const Proved& p) { return p.turning.has_value(); });
  if (path == legs.end() || path->has_room) return false;
  const auto beside = go_fast(*path);
  if (!beside) return tl::unexpected(beside.error());
  if (*beside == 0) return false;
  // With less room it is gone along more slowly.
  for (const double share : kRoom) {
    motion::PathRules wider = path->rules;
    wider.clearance_mm += *beside * share;
    auto other = find_path(*path->scene, path->points.front(), path->points.back(), wider, true);
    if (!other) continue;
    path->points = std::move(other->points), path->certificate = std::move(other->certificate);
    path->has_room = true;
    return true;
  }
  return find_room_above(*path, *beside);
}

/// One of its ends stands beside a body at the very clearance, where only one axis alone has targets on its path: up
/// from there, on with room, and down.
bool BlockBuilder::find_room_above(Proved& path, double beside_mm) const {
  const std::size_t z = path.scene->z();
  const AxisVec from = path.points.front(), to = path.points.back();
  motion::PathRules wider = path.rules;
  wider.clearance_mm += beside_mm;
  for (const double up_mm : kUp_mm) {
    AxisVec above_from = from, above_to = to;
    above_from[z] = std::min(from[z] + up_mm, limits_.axis[z].p_max);
    above_to[z] = std::min(to[z] + up_mm, limits_.axis[z].p_max);
    const auto across = find_path(*path.scene, above_from, above_to, wider, true);
    if (!across) continue;
    std::vector<AxisVec> points{from};
    points.insert(points.end(), across->points.begin(), across->points.end());
    points.push_back(to);
    const auto same = std::unique(points.begin(), points.end());
    points.erase(same, points.end());
    auto certificate = motion::certify(*path.scene, points, path.rules, 0, breath_, measuring_);
    if (!certificate) continue;
    path.points = std::move(points), path.certificate = *std::move(certificate);
    path.has_room = true;
    return true;
  }
  return false;
}

Result<void> BlockBuilder::take_legs(std::span<const Proved> legs) {
  for (const Proved& proved : legs) {
    count(proved, proved.certificate, proved.points);
    for (std::size_t i = 1; i < proved.points.size(); ++i) {
      const auto timed = proved.fast.empty() ? line(*proved.scene, proved.points[i - 1], proved.points[i], proved.rules)
                                             : Result<std::vector<motion::Segment>>(proved.fast[i - 1]);
      if (!timed) return tl::unexpected(timed.error());
      if (auto asked = ask(*proved.scene, *timed, proved.rules); !asked) return asked;
      if (auto taken = take(*timed, proved.points[i]); !taken) return taken;
    }
  }
  return {};
}

/// False: it has another shape, it is not free, or it saves no time.
Result<bool> BlockBuilder::take_as_arch(std::span<const Proved> legs) {
  const auto path = std::find_if(legs.begin(), legs.end(), [](const Proved& p) { return p.turning.has_value(); });
  if (path == legs.end()) return false;
  const motion::Scene& scene = *path->scene;
  std::vector<AxisVec> points;
  double by_legs_s = 0;
  for (const Proved& proved : legs) {
    if (proved.scene != path->scene) return false;
    points.insert(points.end(), proved.points.begin(), proved.points.end());
    for (std::size_t i = 1; i < proved.points.size(); ++i)
      by_legs_s += motion::duration(motion::line_move(limits_, proved.points[i - 1], proved.points[i]));
  }
  // Lift and turn carry some bodies of the head and not the others: chords would not tell how far they go.
  const auto moves = [&](std::size_t axis) {
    return std::any_of(points.begin(), points.end(), [&](const AxisVec& q) { return q[axis] != points.front()[axis]; });
  };
  if ((scene.has_lift() && moves(scene.u())) || (scene.turns() && moves(scene.c()))) return false;
  std::optional<motion::ArchSpec> spec = motion::arch_over(points, scene.z());
  if (!spec) return false;

  End up = end_of(path != legs.begin(), legs.front().alone_mm, spec->top - spec->from[scene.z()]);
  End down = end_of(&*path != &legs.back(), legs.back().alone_mm, spec->top - spec->to[scene.z()]);
  for (;;) {
    spec->leave_mm = up.alone_mm(), spec->arrive_mm = down.alone_mm();
    const motion::Arch arch = motion::arch(limits_, *spec);
    if (motion::duration(arch.segments) > by_legs_s - limits_.tick_s / 2) return false;
    const std::span<const motion::Segment> all(arch.segments);
    std::array parts{Part{all.first(arch.up), &legs.front(), &legs.front().rules},
                     Part{all.subspan(arch.up, all.size() - arch.up - arch.down), &*path, &*path->turning},
                     Part{all.last(arch.down), &legs.back(), &legs.back().rules}};
    if (const auto proved = prove_parts(parts, all)) {
      for (const Part& part : parts) {
        if (auto asked = ask(scene, part.segments, *part.rules); !asked) return tl::unexpected(asked.error());
        count(*part.by, part.certificate, part.chords);
      }
      if (auto taken = take(all, spec->to); !taken) return tl::unexpected(taken.error());
      return true;
    } else if (proved.error().fault != Fault::Collision || !proved.error().meeting) {
      return tl::unexpected(proved.error());
    } else {
      const AxisVec& met = proved.error().meeting->axes;
      const bool leaving = level_mm(scene, met, spec->from) < level_mm(scene, met, spec->to);
      End& tried = (leaving ? up : down).step < kSteps ? (leaving ? up : down) : (leaving ? down : up);
      if (tried.step == kSteps) return false;
      ++tried.step;
    }
  }
}

/// Straight up and down by themselves, what lies between by its chords; and all of it as its targets are sent.
Result<void> BlockBuilder::prove_parts(std::span<Part> parts, std::span<const motion::Segment> all) const {
  if (!go_on(breath_)) return given_up();
  const motion::AsSent sent(*parts.front().by->scene, limits_, all);
  double begin_s = 0;
  for (Part& part : parts) {
    if (part.segments.empty()) continue;
    part.chords = motion::chords(part.segments);
    const bool straight = part.rules == &part.by->rules;
    auto certificate = motion::certify(*part.by->scene, part.chords, *part.rules, straight ? 0 : motion::kChord_mm,
                                       breath_, measuring_);
    if (!certificate) return tl::unexpected(certificate.error());
    part.certificate = *std::move(certificate);
    const double end_s = begin_s + motion::duration(part.segments);
    const bool last = part.segments.data() + part.segments.size() == all.data() + all.size();
    if (auto free = sent.certify(begin_s, last ? sent.duration_s() : end_s, *part.rules, breath_); !free) return free;
    begin_s = end_s;
  }
  return {};
}

}  // namespace gantry::job
