#include "app/job/block_builder.hpp"

#include <algorithm>
#include <array>

namespace gantry::job {

/// A tool over what it works on is near by design; the figure of interest is how near everything else comes.
void BlockBuilder::count(const motion::Certificate& certificate, const motion::PathRules& rules) {
  out_.motions += certificate.motions.size();
  for (const auto& m : certificate.motions) {
    const bool by_design = std::any_of(rules.touches.begin(), rules.touches.end(),
                                       [&](const auto& t) { return t.head == m.head && t.standing == m.standing; });
    if (!by_design) out_.minimum_clearance_mm = std::min(out_.minimum_clearance_mm, m.min_clearance_mm);
  }
}

void BlockBuilder::take(std::span<const motion::Segment> segments, const AxisVec& end, std::uint32_t feature) {
  for (motion::Segment s : segments) {
    s.block = block_;
    s.feature = feature;
    out_.segments.push_back(s);
  }
  out_.duration_s += motion::duration(segments);
  at_ = end;
}

Result<void> BlockBuilder::travel(const AxisVec& to, const motion::PathRules& rules) {
  auto path = motion::find_path(scene_, at_, to, rules);
  if (!path) return tl::unexpected(path.error());
  count(path->certificate, rules);
  for (std::size_t i = 1; i < path->points.size(); ++i)
    take(motion::line_move(limits_, path->points[i - 1], path->points[i]), path->points[i]);
  return {};
}

Result<void> BlockBuilder::prove(std::span<const AxisVec> way, const motion::PathRules& rules, double corner_mm) {
  const auto certificate = motion::certify(scene_, way, rules, corner_mm);
  if (!certificate) return tl::unexpected(certificate.error());
  count(*certificate, rules);
  return {};
}

Result<void> BlockBuilder::straight(const AxisVec& to, const motion::PathRules& rules, double v_cap) {
  if (auto proved = prove(std::array{at_, to}, rules); !proved) return proved;
  take(motion::line_move(limits_, at_, to, v_cap), to);
  return {};
}

PlannedBlock BlockBuilder::finish() {
  if (out_.segments.empty()) take(std::array{motion::dwell(limits_, at_, limits_.tick_s)}, at_);
  out_.segments.back().ends_block = true;
  out_.end = at_;
  return std::move(out_);
}

}  // namespace gantry::job
