#include "app/job/block_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "motion/geometry.hpp"
#include "motion/path/chords.hpp"
#include "motion/path/sound.hpp"
#include "motion/plan/as_sent.hpp"
#include "motion/plan/search_path.hpp"

namespace gantry::job {
namespace {

constexpr double kJoins = 1e-6;  // mm or rad, what two motions may leave between them

constexpr int kSlower = 10;  // times half of the speed, for targets that are nearer to the path

}  // namespace

BlockBuilder::BlockBuilder(const motion::Limits& limits, const motion::Scene& scene, std::uint32_t block,
                           const AxisVec& from, Breath breath, motion::Opinion opinion)
    : limits_(limits),
      scene_(&scene),
      at_(from),
      played_(from),
      breath_(std::move(breath)),
      opinion_(std::move(opinion)) {
  out_.number_ = block;
}

void BlockBuilder::count(const Proved& proved, const motion::Certificate& certificate,
                         std::span<const AxisVec> polyline) {
  out_.motions_ += certificate.motions;
  const Subject& subject = proved.subject;
  const auto words = [&] {
    return subject.kind.empty()   ? std::string(proved.leg)
           : subject.name.empty() ? fmt::format("{} {}", proved.leg, subject.kind)
                                  : fmt::format("{} {} '{}'", proved.leg, subject.kind, subject.name);
  };
  const auto where = [&] {
    return subject.file.empty() ? std::string()
                                : fmt::format("{}:{}:{}", subject.file, subject.location.line, subject.location.column);
  };
  const motion::Scene& scene = *proved.scene;
  const auto take = [&](const motion::NearPair& pair, motion::NearPair& known, std::optional<Nearest>& nearest) {
    if (pair.distance_mm >= known.distance_mm) return;
    known = pair;
    Nearest& n = nearest.emplace();
    n.distance_mm = pair.distance_mm;
    n.head = scene.head()[pair.head].name, n.standing = scene.standing()[pair.standing].name;
    n.motion = words(), n.where = where();
    n.machine_mm = pair.at;
    n.axes = between(polyline[pair.motion], polyline[pair.motion + 1], pair.fraction);
    if (scene.board()) n.board_mm = scene.board()->from_machine(pair.at);
  };
  take(certificate.nearest.by_design, measuring_.known.by_design, out_.nearest_.by_design);
  take(certificate.nearest.others, measuring_.known.others, out_.nearest_.others);
  if (rows_ != nullptr)
    rows_->add(out_.rows_, {out_.number_, words(), where(), scene, polyline, certificate.of_motion});
}

Result<void> BlockBuilder::take(std::span<const motion::Segment> segments, const AxisVec& end, std::uint32_t feature,
                                std::span<const motion::Segment> capped) {
  if (const auto why = motion::unsound(limits_, segments, capped))
    return fail(Fault::Internal, fmt::format("a motion was planned that does not keep what it promises, and is not "
                                             "played: {}; another speed or tolerance may do, and the recipe shows "
                                             "whoever mends it what to mend",
                                             *why));
  if (!segments.empty()) {
    const AxisVec begin = motion::point(segments.front().geometry, 0);
    for (std::size_t i = 0; i < limits_.axes; ++i)
      if (std::abs(begin[i] - played_[i]) > kJoins)
        return fail(Fault::Internal,
                    "a motion was planned that does not begin where the one before it ends, and is not "
                    "played; `jog` the axes to another place, and try again");
    played_ = end;
  }
  for (const motion::Segment& s : segments) {
    motion::Segment& taken = out_.segments_.emplace_back(s);
    taken.block = out_.number_;
    taken.feature = feature;
  }
  out_.duration_s_ += motion::duration(segments);
  at_ = end;
  return {};
}

Result<void> BlockBuilder::ask(const motion::Scene& scene, std::span<const motion::Segment> segments,
                               const motion::PathRules& rules) {
  if (!opinion_ || segments.empty()) return {};
  const auto poses = opinion_(scene, rules, segments);
  if (!poses) return tl::unexpected(poses.error());
  out_.poses_ += *poses;
  return {};
}

Result<motion::Path> BlockBuilder::find_path(const motion::Scene& scene, const AxisVec& from, const AxisVec& to,
                                             const motion::PathRules& rules, bool optional) const {
  auto path = motion::find_path(scene, from, to, rules, 0, measuring_, known_ways_);
  if (kept_ways_ == nullptr) return path;
  if (path && path->kind == motion::PathKind::Detour) kept_ways_->keep(from, to, rules.clearance_mm, path->points);
  if (!path && optional && path.error().fault == Fault::Collision) kept_ways_->keep(from, to, rules.clearance_mm, {});
  return path;
}

Result<void> BlockBuilder::travel(const AxisVec& to, const motion::PathRules& rules, const motion::PathRules& turning) {
  if (!go_on(breath_)) return given_up();
  auto path = find_path(*scene_, at_, to, rules, false);
  if (!path) return tl::unexpected(path.error());
  return wait_for_next({.leg = "travel to",
                        .points = std::move(path->points),
                        .rules = rules,
                        .turning = turning,
                        .certificate = std::move(path->certificate)});
}

Result<void> BlockBuilder::vertical(const AxisVec& to, const motion::PathRules& rules, double alone_mm) {
  auto certificate = motion::certify(*scene_, std::array{at_, to}, rules, 0, breath_, measuring_);
  if (!certificate) return tl::unexpected(certificate.error());
  return wait_for_next({.leg = up_or_down(to),
                        .points = {at_, to},
                        .rules = rules,
                        .alone_mm = alone_mm,
                        .certificate = *std::move(certificate)});
}

/// The straights of a path as fast as the axes may go, where targets are free as they are sent; else how far they are
/// sent beside them at most.
Result<double> BlockBuilder::go_fast(Proved& path) const {
  double most = 0;
  std::vector<std::vector<motion::Segment>> lines;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    auto line = motion::line_move(limits_, path.points[i - 1], path.points[i]);
    if (!line.empty()) most = std::max(most, motion::beside_line_mm(limits_, line.front()));
    lines.push_back(std::move(line));
  }
  for (const auto& line : lines) {
    const motion::AsSent sent(*path.scene, limits_, line);
    const auto proved = sent.certify(0, sent.duration_s(), path.rules, breath_);
    if (!proved && proved.error().fault != Fault::Collision) return tl::unexpected(proved.error());
    if (!proved) return most;
  }
  path.fast = std::move(lines);
  return 0;
}

/// As fast as its targets are free as they are sent. The line itself was proved.
Result<std::vector<motion::Segment>> BlockBuilder::line(const motion::Scene& scene, const AxisVec& from,
                                                        const AxisVec& to, const motion::PathRules& rules,
                                                        double v_cap) const {
  for (int slower = 0;; ++slower) {
    auto line = motion::line_move(limits_, from, to, v_cap);
    // Proved at this rate and at lower ones: no override makes a piece faster than that.
    if (slower > 0)
      for (motion::Segment& s : line) s.kind = motion::SegmentKind::Piece;
    const motion::AsSent sent(scene, limits_, line);
    const auto proved = sent.certify(0, sent.duration_s(), rules, breath_);
    if (proved) return line;
    if (slower == kSlower || proved.error().fault != Fault::Collision) return tl::unexpected(proved.error());
    v_cap = line.front().v_cap / 2;
  }
}

std::string_view BlockBuilder::up_or_down(const AxisVec& to) const {
  const double up = to[scene_->z()] - at_[scene_->z()];
  return up > 0 ? "up from" : up < 0 ? "down to" : "straight to";
}

Result<void> BlockBuilder::prove(std::span<const AxisVec> polyline, const motion::PathRules& rules,
                                 std::string_view leg, double off_mm) {
  const auto certificate = motion::certify(*scene_, polyline, rules, off_mm, breath_, measuring_);
  if (!certificate) return tl::unexpected(certificate.error());
  count({.leg = leg, .scene = scene_, .subject = subject_}, *certificate, polyline);
  return {};
}

Result<void> BlockBuilder::would_be_free(std::span<const AxisVec> polyline, const motion::PathRules& rules,
                                         double off_mm) const {
  motion::Measuring nothing_is_measured;
  nothing_is_measured.known.by_design.distance_mm = nothing_is_measured.known.others.distance_mm =
      -std::numeric_limits<double>::infinity();
  const auto certificate = motion::certify(*scene_, polyline, rules, off_mm, breath_, nothing_is_measured);
  return certificate ? Result<void>{} : tl::unexpected(certificate.error());
}

Result<void> BlockBuilder::would_be_free(std::span<const motion::Segment> segments,
                                         const motion::PathRules& rules) const {
  if (auto free = would_be_free(motion::chords(segments), rules, motion::off_chords_mm(segments)); !free) return free;
  const motion::AsSent sent(*scene_, limits_, segments);
  return sent.certify(0, sent.duration_s(), rules, breath_);
}

Result<void> BlockBuilder::straight(const AxisVec& to, const motion::PathRules& rules, double v_cap) {
  // An axis that stands beyond its travel, as behind its homing, may stay there, or come back.
  for (std::size_t i = 0; i < scene_->axes().size(); ++i) {
    const motion::Scene::Axis& a = scene_->axes()[i];
    const auto beyond = [&](double q) { return std::max({a.p_min - q, q - a.p_max, 0.0}); };
    if (beyond(to[i]) <= beyond(at_[i]) + motion::kLimitRounding) continue;
    return fail(Fault::OutOfReach, fmt::format("axis {} would go to {:.3f}; its limits are {:.3f} and {:.3f}", a.name,
                                               to[i], a.p_min, a.p_max));
  }
  if (auto settled = settle(); !settled) return settled;
  if (auto proved = prove(std::array{at_, to}, rules, up_or_down(to)); !proved) return proved;
  const auto line = this->line(*scene_, at_, to, rules, v_cap);
  if (!line) return tl::unexpected(line.error());
  if (auto asked = ask(*scene_, *line, rules); !asked) return asked;
  return take(*line, to);
}

Result<void> BlockBuilder::unplaced(const AxisVec& to, double v_cap, double most) {
  constexpr double kRounding = 1e-9;
  int moving = 0;
  double farthest = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    moving += to[i] != at_[i] ? 1 : 0;
    farthest = std::max(farthest, std::abs(to[i] - at_[i]));
  }
  if (moving > 1 || farthest > most + kRounding)
    return fail(Fault::Internal, "a motion that cannot be proved was to be more than a walk");
  out_.proved_ = false;
  if (auto settled = settle(); !settled) return settled;
  return take(motion::line_move(limits_, at_, to, v_cap), to);
}

Result<void> BlockBuilder::until_probe(const AxisVec& to, const motion::PathRules& rules, double speed_mm_s) {
  if (auto settled = settle(); !settled) return settled;
  if (auto proved = prove(std::array{at_, to}, rules, "probe down at"); !proved) return proved;
  const auto line = motion::probe_move(limits_, at_, to, speed_mm_s);
  if (auto asked = ask(*scene_, line, rules); !asked) return asked;
  return take(line, at_);
}

Result<void> BlockBuilder::bead(const motion::BeadMotion& bead, const motion::PathRules& rules, std::uint32_t feature) {
  if (at_ != bead.start) return fail(Fault::Internal, "a bead was added where the axes do not stand");
  if (auto settled = settle(); !settled) return settled;
  const std::span<const motion::Segment> all(bead.segments);
  const auto free = [&](std::span<const motion::Segment> played, const std::string& what) {
    Result<void> proved = prove(motion::chords(played), rules, "along", motion::off_chords_mm(played));
    if (!proved && proved.error().fault == Fault::Collision) proved.error().message = what + proved.error().message;
    return proved;
  };
  constexpr const char* kRamp = "{} of {:.3g} mm: ";
  if (auto r = free(all.first(bead.bead_begin), fmt::format(kRamp, "its run-up", bead.run_up_mm)); !r) return r;
  const auto of_bead = all.subspan(bead.bead_begin, bead.bead_end - bead.bead_begin);
  if (auto r = free(of_bead, ""); !r) return r;
  if (auto r = free(all.subspan(bead.bead_end), fmt::format(kRamp, "its run-out", bead.run_out_mm)); !r) return r;
  const motion::AsSent sent(*scene_, limits_, all);
  if (auto r = sent.certify(0, sent.duration_s(), rules, breath_); !r) return r;
  if (auto asked = ask(*scene_, all, rules); !asked) return asked;
  return take(bead.segments, bead.end, feature, of_bead);
}

Result<void> BlockBuilder::path(std::span<const motion::Segment> segments, const AxisVec& to,
                                const motion::PathRules& rules, std::string_view leg) {
  if (auto settled = settle(); !settled) return settled;
  const motion::AsSent sent(*scene_, limits_, segments);
  if (auto r = sent.certify(0, sent.duration_s(), rules, breath_); !r) return r;
  if (auto r = prove(motion::chords(segments), rules, leg, motion::off_chords_mm(segments)); !r) return r;
  if (auto asked = ask(*scene_, segments, rules); !asked) return asked;
  return take(segments, to);
}

Result<void> BlockBuilder::dwell(double seconds, std::span<const motion::OutputEvent> events, std::uint32_t feature) {
  if (auto settled = settle(); !settled) return settled;
  return take(std::array{motion::dwell(limits_, at_, seconds, events)}, at_, feature);
}

void discard(ProvenBlock block, const Breath& breath) {
  for (Pauses pause(breath, 256); !block.segments_.empty(); pause()) block.segments_.pop_front();
}

Result<ProvenBlock> BlockBuilder::finish() {
  if (auto settled = settle(); !settled) return tl::unexpected(settled.error());
  if (out_.segments_.empty())
    if (auto stands = take(std::array{motion::dwell(limits_, at_, limits_.tick_s)}, at_); !stands)
      return tl::unexpected(stands.error());
  out_.segments_.back().ends_block = true;
  out_.end_ = at_;
  return std::move(out_);
}

}  // namespace gantry::job
