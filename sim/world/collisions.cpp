#include "sim/world/collisions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <unordered_map>

namespace gantry::sim {

namespace {
constexpr double kStep_mm = 0.2;
constexpr double kHair_mm = 1e-6;
constexpr double kAnywhere = std::numeric_limits<double>::infinity();
Bounds shifted(const Bounds& b, Vec3 by) { return {b.low + by, b.high + by}; }
}  // namespace

CollisionWatch::CollisionWatch(const Head& head) : head_(head) {
  for (const config::Body& body : head.bodies) {
    body_shapes_.emplace_back(body.shape);
    body_bounds_.push_back(bounds_of(body.shape, {}, body.rotation_rad, {}));
  }
  set_solids({});
}

void CollisionWatch::set_solids(std::vector<Solid> solids) {
  std::unordered_map<std::string_view, std::size_t> known;
  for (std::size_t old = 0; old < solids_.size(); ++old) known[solids_[old].name] = old;
  std::vector<Pair> pairs(head_.bodies.size() * solids.size());
  in_contact_.clear();
  for (std::size_t j = 0; j < solids.size(); ++j) {
    const auto old = known.find(solids[j].name);
    if (old == known.end()) continue;
    for (std::size_t i = 0; i < head_.bodies.size(); ++i) {
      Pair& pair = pairs[i * solids.size() + j] = pairs_[i * solids_.size() + old->second];
      if (pair.state != PairState::Apart) in_contact_.push_back({i, j});
    }
  }
  solids_ = std::move(solids);
  pairs_ = std::move(pairs);
  solid_shapes_.clear();
  solid_bounds_.clear();
  for (const Solid& s : solids_) {
    solid_shapes_.emplace_back(s.shape);
    solid_bounds_.push_back(bounds_of(s.shape, s.centre, s.rotation_rad, s.slope));
  }
  tree_ = SolidTree(solid_bounds_);
  near_.reserve(solids_.size());
  fresh_ = true;
}

std::span<const std::uint32_t> CollisionWatch::solids_at(Vec2 at) {
  tree_.meets({{at.x - kHair_mm, at.y - kHair_mm, -kAnywhere}, {at.x + kHair_mm, at.y + kHair_mm, kAnywhere}}, near_);
  return near_;
}

CollisionWatch::Pose CollisionWatch::pose(std::size_t body, const AxisVec& q) const {
  return {head_.centre(head_.bodies[body], q), head_.turn_rad(head_.bodies[body], q)};
}

Bounds CollisionWatch::bounds(std::size_t body, const Pose& at) const {
  const config::Body& b = head_.bodies[body];
  if (at.turn_rad == 0) return shifted(body_bounds_[body], at.centre);
  return bounds_of(b.shape, at.centre, b.rotation_rad + at.turn_rad, {});
}

bool CollisionWatch::overlaps(std::size_t body, std::size_t solid, const Pose& at) {
  const Solid moving{{}, {}, at.centre, head_.bodies[body].rotation_rad + at.turn_rad, {}};
  return overlap(body_shapes_[body], moving, solid_shapes_[solid], solids_[solid]);
}

Vec3 CollisionWatch::meeting_point(std::size_t body, std::size_t solid, const Pose& at) const {
  const Bounds a = bounds(body, at);
  const Bounds& b = solid_bounds_[solid];
  const auto middle = [](double l1, double h1, double l2, double h2) {
    return (std::max(l1, l2) + std::min(h1, h2)) / 2;
  };
  return {middle(a.low.x, a.high.x, b.low.x, b.high.x), middle(a.low.y, a.high.y, b.low.y, b.high.y),
          middle(a.low.z, a.high.z, b.low.z, b.high.z)};
}

std::span<const Contact> CollisionWatch::step(const AxisVec& from, const AxisVec& to, double dt_s) {
  contacts_.clear();
  if (head_.probe_body >= 0) {
    const auto probe = static_cast<std::size_t>(head_.probe_body);
    const Vec3 displacement = pose(probe, to).centre - pose(probe, from).centre;
    went_[steps_++ % went_.size()] = {norm(displacement), dt_s};
  }
  if (solids_.empty() || (from == to && !fresh_)) return contacts_;
  fresh_ = false;
  for (std::size_t i = 0; i < head_.bodies.size(); ++i) {
    const Pose a = pose(i, from), b = pose(i, to);
    Bounds swept = joined(bounds(i, a), bounds(i, b));
    if (a.turn_rad != b.turn_rad) {  // meanwhile no point of it is farther than half its arc from where it ends
      const double half_arc = head_.swing_mm(head_.bodies[i]) * std::abs(b.turn_rad - a.turn_rad) / 2;
      swept = {swept.low - Vec3{half_arc, half_arc, 0}, swept.high + Vec3{half_arc, half_arc, 0}};
    }
    part_what_is_left_behind(i, swept);
    tree_.meets(swept, near_);
    for (const std::uint32_t j : near_) step_pair(i, j, from, to, dt_s);
  }
  return contacts_;
}

void CollisionWatch::part(std::size_t body, std::size_t solid) {
  pairs_[body * solids_.size() + solid].state = PairState::Apart;
  std::erase_if(in_contact_, [&](const Index& pair) { return pair.body == body && pair.solid == solid; });
}

void CollisionWatch::part_what_is_left_behind(std::size_t body, const Bounds& swept) {
  std::erase_if(in_contact_, [&](const Index& pair) {
    const bool left = pair.body == body && !swept.meets(solid_bounds_[pair.solid]);
    if (left) pairs_[body * solids_.size() + pair.solid].state = PairState::Apart;
    return left;
  });
}

/// The step that has just been noted is one of them.
bool CollisionWatch::slow_of_late(double travelled_mm, double dt_s) const {
  constexpr double kRounding = 1 + 1e-9;
  if (travelled_mm <= kTouchSpeed_mm_s * dt_s * kRounding) return true;
  double all_mm = 0, time = 0;
  for (std::size_t back = 1; back <= std::min(steps_, went_.size()) && time < kTouchSpeedOver_s; ++back) {
    const Went& w = went_[(steps_ - back) % went_.size()];
    all_mm += w.travelled_mm, time += w.dt_s;
  }
  return time >= kTouchSpeedOver_s * (1 - 1e-9) && all_mm <= kTouchSpeed_mm_s * time * kRounding;
}

void CollisionWatch::collide(std::size_t body, std::size_t solid, const Pose& at) {
  pairs_[body * solids_.size() + solid].state = PairState::Collided;
  contacts_.push_back({head_.bodies[body].name, solids_[solid].name, meeting_point(body, solid, at)});
}

void CollisionWatch::step_pair(std::size_t body, std::size_t solid, const AxisVec& from, const AxisVec& to,
                               double dt_s) {
  Pair& pair = pairs_[body * solids_.size() + solid];
  const Pose start = pose(body, from), end = pose(body, to);
  if (pair.state != PairState::Apart) {
    if (!overlaps(body, solid, end)) {
      part(body, solid);
    } else if (pair.state == PairState::ProbeTouch) {
      const Vec3 since = end.centre - pair.since;
      if (std::hypot(since.x, since.y) > kTouchDrag_mm || since.z < -kTouchOvertravel_mm) collide(body, solid, end);
    }
    return;
  }
  const Vec3 displacement = end.centre - start.centre;
  const double turned_rad = std::abs(end.turn_rad - start.turn_rad);
  double farthest_mm = norm(displacement);
  if (turned_rad > 0) {
    const bool lifts = head_.bodies[body].on_lift;
    farthest_mm = norm(head_.in_machine({}, lifts, to) - head_.in_machine({}, lifts, from)) +
                  head_.swing_mm(head_.bodies[body]) * turned_rad;
  }
  const int steps = std::max(1, static_cast<int>(std::ceil(farthest_mm / kStep_mm)));
  for (int k = 1; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    const Pose at = turned_rad > 0 ? pose(body, between(from, to, share))
                                   : Pose{start.centre + displacement * share, start.turn_rad};
    if (!overlaps(body, solid, at)) continue;
    in_contact_.push_back({body, solid});
    const bool slow = slow_of_late(norm(displacement), dt_s);
    const bool down =
        displacement.z < 0 && std::hypot(displacement.x, displacement.y) <= kTouchDrag_mm * std::abs(displacement.z);
    if (static_cast<int>(body) == head_.probe_body && slow && down) {
      pair = {PairState::ProbeTouch, at.centre};
      return;
    }
    collide(body, solid, at);
    return;
  }
}

}  // namespace gantry::sim
