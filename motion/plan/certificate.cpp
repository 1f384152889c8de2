#include "motion/plan/certificate.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "motion/plan/gap.hpp"
#include "motion/plan/verify.hpp"

namespace gantry::motion {
namespace {

/// True distance of a pair over the motion, when it is nearer than what is known.
void measure(const Scene& scene, const BodySweep& body, std::size_t head, std::size_t standing, std::size_t motion,
             NearPair& best) {
  const Solid& b = scene.standing()[standing].solid;
  const Gap gap = motion::gap_below(body.start(), body.sweep(), b, best.distance_mm);
  if (gap.upper >= best.distance_mm) return;
  const Solid there = moved(body.start(), body.sweep() * gap.fraction);
  best = {gap.upper, head, standing, motion, gap.fraction, nearest_point(there, b)};
}

/// Goes down the tree, the nearer half first; what cannot be nearer than the best is left out.
void nearest_in(const Scene& scene, const BodySweep& body, std::size_t head, const Margins& margins, std::uint32_t node,
                std::size_t motion, NearPair& best) {
  const auto& nodes = scene.tree().nodes();
  const Tree::Node& at = nodes[node];
  if (at.body != Tree::kInner) {
    if (!margins.by_design(head, at.body)) measure(scene, body, head, at.body, motion, best);
    return;
  }
  std::uint32_t near = node + 1, far = nodes[near].skip;
  double near_mm = body.room(nodes[near].box), far_mm = body.room(nodes[far].box);
  if (far_mm < near_mm) std::swap(near, far), std::swap(near_mm, far_mm);
  if (near_mm < best.distance_mm) nearest_in(scene, body, head, margins, near, motion, best);
  if (far_mm < best.distance_mm) nearest_in(scene, body, head, margins, far, motion, best);
}

/// One body of the head on a motion as a whole: one that turns is larger by what its turn leaves open.
void measure_whole(const Scene& scene, std::size_t head, const BodySweep& body, const Margins& margins,
                   std::size_t motion, NearPairs& nearest) {
  for (const PairMargin& pair : margins.pairs)
    if (pair.head == head && pair.by_design) measure(scene, body, head, pair.standing, motion, nearest.by_design);
  if (!scene.standing().empty() && body.room(scene.tree().nodes().front().box) < nearest.others.distance_mm)
    nearest_in(scene, body, head, margins, 0, motion, nearest.others);
}

constexpr double kMeasuredTurn_mm = 0.01;  // by which a distance of what turns may be told too small

/// The part `begin`..`end` of a motion that turns a body: what is found nearer is cut into halves until it is sure.
void measure_turning(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to, double begin,
                     double end, const Margins& margins, std::size_t motion, NearPairs& nearest) {
  const BodySweep body(scene, head, on_line(from, to, begin), on_line(from, to, end));
  NearPairs found = nearest;
  measure_whole(scene, head, body, margins, motion, found);
  const bool nearer[] = {found.by_design.distance_mm < nearest.by_design.distance_mm,
                         found.others.distance_mm < nearest.others.distance_mm};
  if (!nearer[0] && !nearer[1]) return;
  if (body.left_open_mm() > kMeasuredTurn_mm) {
    const double middle = (begin + end) / 2;
    measure_turning(scene, head, from, to, begin, middle, margins, motion, nearest);
    measure_turning(scene, head, from, to, middle, end, margins, motion, nearest);
    return;
  }
  for (auto [pair, is_nearer] : {std::pair(&found.by_design, nearer[0]), std::pair(&found.others, nearer[1])})
    if (is_nearer) pair->fraction = begin + (end - begin) * pair->fraction;
  nearest = found;
}

}  // namespace

void measure_nearest(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                     std::size_t motion, NearPairs& nearest) {
  for (std::size_t i = 0; i < scene.head().size(); ++i)
    if (scene.turn_of(scene.head()[i], from, to) != 0)
      measure_turning(scene, i, from, to, 0, 1, margins, motion, nearest);
    else
      measure_whole(scene, i, BodySweep(scene, i, from, to), margins, motion, nearest);
}

std::string describe(const Scene& scene, const Hit& hit) {
  return fmt::format("{} {} {} at {}", scene.head()[hit.head].name,
                     hit.clearance_mm > 0 ? fmt::format("comes within {:.3g} mm of", hit.clearance_mm) : "meets",
                     scene.standing()[hit.standing].name, scene.told(hit.point));
}

Error collision(const Scene& scene, const Hit& hit, const AxisVec& from, const AxisVec& to, std::string words) {
  return {Fault::Collision, std::move(words), "",
          std::make_shared<Meeting>(Meeting{scene.head()[hit.head].name, scene.standing()[hit.standing].name, from, to,
                                            between(from, to, hit.fraction), hit.point, hit.clearance_mm})};
}

Result<Certificate> certify(const Scene& scene, std::span<const AxisVec> polyline, const ClearanceRules& rules,
                            double extra_mm, const Breath& breath, const Measuring& measuring) {
  const auto margins = make_margins(scene, rules.clearance_mm, rules.approaches, extra_mm);
  if (!margins) return tl::unexpected(margins.error());
  Certificate out{scene.hash(), rules.clearance_mm, extra_mm, 0, 0, measuring.known};
  Proof proof;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    if (i > 0 && !go_on(breath)) return given_up();
    const AxisVec &from = polyline[i], &to = polyline[i + 1];
    proof.clear();
    if (const auto hit = first_hit(scene, from, to, *margins, &proof))
      return tl::unexpected(collision(scene, *hit, from, to,
                                      fmt::format("{}, {:.0f} % along motion {} of {}", describe(scene, *hit),
                                                  100 * hit->fraction, i + 1, polyline.size() - 1)));
    if (!is_free(scene, from, to, proof, *margins))
      return fail(Fault::Internal,
                  fmt::format("the two collision checks disagree on motion {} of {}", i + 1, polyline.size() - 1));
    measure_nearest(scene, from, to, *margins, i, out.nearest);
    if (measuring.each_motion) measure_nearest(scene, from, to, *margins, i, out.of_motion.emplace_back());
    out.pairs += scene.head().size() * scene.standing().size();
    ++out.motions;
  }
  return out;
}

}  // namespace gantry::motion
