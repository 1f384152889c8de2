#include "motion/plan/sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "motion/plan/gap.hpp"

namespace gantry::motion {
namespace {

constexpr double kFraction_mm = 1e-4;  // how exactly the position of a hit is found

/// Room along one direction between a swept body and a standing one; below 0 they overlap along it.
double room_along(const Solid& a, Vec3 sweep, const Solid& b, Vec3 n) {
  const double ahead = std::max(0.0, dot(n, sweep));
  return dot(n, b.centre - a.centre) - ahead - extent(a, n) - extent(b, n);
}

/// Overlap is allowed down to `margin` < 0: along Z or an upright face normal of the standing body.
std::optional<PairProof> prove_overlap(const Solid& a, Vec3 sweep, const Solid& b, double margin) {
  PairProof best;
  best.room_mm = -std::numeric_limits<double>::infinity();
  for (const Vec3 n : {Vec3{0, 0, 1}, Vec3{b.cos, b.sin, 0}, Vec3{-b.sin, b.cos, 0}})
    for (const double sign : {-1.0, 1.0}) {
      const double room = room_along(a, sweep, b, n * sign);
      if (room > best.room_mm) best.room_mm = room, best.direction = n * sign;
    }
  if (best.room_mm > margin) return best;
  return std::nullopt;
}

std::optional<PairProof> prove(const Solid& a, Vec3 sweep, const Solid& b, double margin) {
  const Gap g = gap(a, sweep, b, margin);
  if (g.lower > margin) return PairProof{0, 0, g.direction, g.lower};
  return margin < 0 ? prove_overlap(a, sweep, b, margin) : std::nullopt;
}

/// Middle of what two overlapping bodies' boxes share.
Vec3 middle_of_overlap(Vec3 a, Vec3 a_half, Vec3 b, Vec3 b_half) {
  const auto middle = [](double p, double p_half, double q, double q_half) {
    return (std::max(p - p_half, q - q_half) + std::min(p + p_half, q + q_half)) / 2;
  };
  return {middle(a.x, a_half.x, b.x, b_half.x), middle(a.y, a_half.y, b.y, b_half.y),
          middle(a.z, a_half.z, b.z, b_half.z)};
}

}  // namespace

double Margins::of(std::size_t head, std::size_t standing) const {
  double least = clearance_mm;
  for (const PairMargin& p : pairs)
    if (p.head == head && p.standing == standing) least = std::min(least, p.clearance_mm);
  return least;
}

bool Margins::by_design(std::size_t head, std::size_t standing) const {
  return std::any_of(pairs.begin(), pairs.end(),
                     [&](const PairMargin& p) { return p.by_design && p.head == head && p.standing == standing; });
}

Result<Margins> make_margins(const Scene& scene, double clearance_mm, const std::vector<AllowedApproach>& approaches,
                             double extra_mm) {
  const auto index = [](const std::vector<SceneBody>& bodies, const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(bodies.begin(), bodies.end(), [&](const SceneBody& b) { return b.name == name; }) -
        bodies.begin());
  };
  Margins out{clearance_mm + extra_mm, {}};
  for (const AllowedApproach& t : approaches) {
    const std::size_t head = index(scene.head(), t.head), standing = index(scene.standing(), t.standing);
    if (head == scene.head().size() || standing == scene.standing().size())
      return fail(Fault::UnknownReference,
                  fmt::format("an allowed approach names '{}' and '{}', but there is no such body {}", t.head,
                              t.standing, head == scene.head().size() ? "on the head" : "in the scene"));
    out.pairs.push_back({head, standing, t.clearance_mm, t.by_design});
  }
  return out;
}

BodySweep::BodySweep(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to)
    : scene_(&scene), head_(head), half_box_(scene.head()[head].half_box) {
  const SceneBody& body = scene.head()[head];
  const Vec3 start = scene.carried(body, from);
  sweep_ = scene.carried(body, to) - start;
  start_ = moved(body.solid, start);
  middle_ = start_.centre + sweep_ * 0.5;
  reach_ = half_box_ + Vec3{std::abs(sweep_.x), std::abs(sweep_.y), std::abs(sweep_.z)} * 0.5;
  const std::array<Vec3, 3> n{{{0, sweep_.z, -sweep_.y}, {-sweep_.z, 0, sweep_.x}, {sweep_.y, -sweep_.x, 0}}};
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = norm(n[i]);
    if (length > 1e-9) across_[i] = n[i] * (1 / length);
  }
}

std::optional<PairProof> BodySweep::prove(std::size_t standing, double margin) const {
  // Three directions along the axes, three across motion and axis: for boxes every direction that can part them.
  const SceneBody& b = scene_->standing()[standing];
  const Vec3 d = b.solid.centre - middle_;
  if (const double room = std::abs(d.x) - reach_.x - b.half_box.x; room > margin)
    return PairProof{head_, standing, {std::copysign(1.0, d.x), 0, 0}, room};
  if (const double room = std::abs(d.y) - reach_.y - b.half_box.y; room > margin)
    return PairProof{head_, standing, {0, std::copysign(1.0, d.y), 0}, room};
  if (const double room = std::abs(d.z) - reach_.z - b.half_box.z; room > margin)
    return PairProof{head_, standing, {0, 0, std::copysign(1.0, d.z)}, room};
  const Vec3 half = half_box_ + b.half_box;
  for (const Vec3 n : across_) {
    const double along = dot(n, d);
    const double room = std::abs(along) - std::abs(n.x) * half.x - std::abs(n.y) * half.y - std::abs(n.z) * half.z;
    if (room > margin && n != Vec3{}) return PairProof{head_, standing, n * std::copysign(1.0, along), room};
  }
  auto proof = motion::prove(start_, sweep_, b.solid, margin);
  if (proof) proof->head = head_, proof->standing = standing;
  return proof;
}

Hit BodySweep::locate(std::size_t standing, double margin) const {
  const SceneBody& b = scene_->standing()[standing];
  double free = 0,
         hit = motion::prove(start_, {}, b.solid, margin) ? 1 : 0;  // a longer motion never frees a shorter one
  while ((hit - free) * norm(sweep_) > kFraction_mm) {
    const double middle = (free + hit) / 2;
    (motion::prove(start_, sweep_ * middle, b.solid, margin) ? free : hit) = middle;
  }
  const Solid there = moved(start_, sweep_ * free);
  const Gap g = measure_gap(there, {}, b.solid);
  return {head_, standing, free,
          g.upper > 0 ? g.on_standing : middle_of_overlap(there.centre, half_box_, b.solid.centre, b.half_box), margin};
}

std::optional<Hit> first_hit(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             std::vector<PairProof>* proofs) {
  std::optional<Hit> first;
  for (std::size_t i = 0; i < scene.head().size(); ++i) {
    const BodySweep body(scene, i, from, to);
    for (std::size_t k = 0; k < scene.standing().size(); ++k) {
      if (proofs == nullptr && body.far(k, margins.clearance_mm)) continue;
      // An allowed approach only lowers a margin, so what keeps the full clearance need not be looked up.
      auto proof = body.prove(k, margins.clearance_mm);
      const double margin = proof || margins.pairs.empty() ? margins.clearance_mm : margins.of(i, k);
      if (!proof && margin < margins.clearance_mm) proof = body.prove(k, margin);
      if (!proof) {
        const Hit hit = body.locate(k, margin);
        if (!first || hit.fraction < first->fraction) first = hit;
      } else if (proofs != nullptr) {
        proofs->push_back(*proof);
      }
    }
  }
  return first;
}

}  // namespace gantry::motion
