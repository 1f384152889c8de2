#include "app/job/block_builder.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gantry::job {

BlockBuilder::BlockBuilder(const motion::Limits& limits, const motion::Scene& scene, std::uint32_t block,
                           const AxisVec& from, Breath breath)
    : limits_(limits), scene_(scene), at_(from), breath_(std::move(breath)) {
  out_.number_ = block;
}

/// A tool over what it works on is near by design; the figure of interest is how near everything else comes.
void BlockBuilder::count(const motion::Certificate& certificate, const motion::PathRules& rules) {
  out_.motions_ += certificate.motions.size();
  for (const auto& m : certificate.motions) {
    const bool by_design = std::any_of(rules.approaches.begin(), rules.approaches.end(),
                                       [&](const auto& a) { return a.head == m.head && a.standing == m.standing; });
    if (!by_design) out_.minimum_clearance_mm_ = std::min(out_.minimum_clearance_mm_, m.min_clearance_mm);
  }
}

void BlockBuilder::take(std::span<const motion::Segment> segments, const AxisVec& end, std::uint32_t feature) {
  for (const motion::Segment& s : segments) {
    motion::Segment& taken = out_.segments_.emplace_back(s);
    taken.block = out_.number_;
    taken.feature = feature;
  }
  out_.duration_s_ += motion::duration(segments);
  at_ = end;
}

Result<void> BlockBuilder::travel(const AxisVec& to, const motion::PathRules& rules) {
  if (!go_on(breath_)) return given_up();
  auto path = motion::find_path(scene_, at_, to, rules);
  if (!path) return tl::unexpected(path.error());
  count(path->certificate, rules);
  for (std::size_t i = 1; i < path->points.size(); ++i)
    take(motion::line_move(limits_, path->points[i - 1], path->points[i]), path->points[i]);
  return {};
}

Result<void> BlockBuilder::prove(std::span<const AxisVec> polyline, const motion::PathRules& rules, double corner_mm) {
  const auto certificate = motion::certify(scene_, polyline, rules, corner_mm, breath_);
  if (!certificate) return tl::unexpected(certificate.error());
  count(*certificate, rules);
  return {};
}

Result<void> BlockBuilder::straight(const AxisVec& to, const motion::PathRules& rules, double v_cap) {
  if (auto proved = prove(std::array{at_, to}, rules); !proved) return proved;
  take(motion::line_move(limits_, at_, to, v_cap), to);
  return {};
}

Result<void> BlockBuilder::until_probe(const AxisVec& to, const motion::PathRules& rules, double speed_mm_s) {
  if (auto proved = prove(std::array{at_, to}, rules); !proved) return proved;
  take(motion::probe_move(limits_, at_, to, speed_mm_s), at_);
  return {};
}

Result<void> BlockBuilder::bead(const motion::BeadMotion& bead, const motion::PathRules& rules, std::uint32_t feature) {
  if (at_ != bead.start) return fail(Fault::Internal, "a bead was added where the axes do not stand");
  if (auto proved = prove(bead.outline, rules, bead.corner_tolerance_mm); !proved) return proved;
  take(bead.segments, bead.end, feature);
  return {};
}

void BlockBuilder::dwell(double seconds, std::span<const motion::OutputEvent> events, std::uint32_t feature) {
  take(std::array{motion::dwell(limits_, at_, seconds, events)}, at_, feature);
}

void discard(ProvenBlock block, const Breath& breath) {
  constexpr std::size_t kPiece = 256;
  for (std::size_t n = 1; !block.segments_.empty(); ++n) {
    block.segments_.pop_front();
    if (n % kPiece == 0) go_on(breath);
  }
}

ProvenBlock BlockBuilder::finish() {
  if (out_.segments_.empty()) dwell(limits_.tick_s);
  out_.segments_.back().ends_block = true;
  out_.end_ = at_;
  return std::move(out_);
}

}  // namespace gantry::job
