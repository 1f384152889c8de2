#include "sim/world/collisions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gantry::sim {

namespace {
constexpr double kStep_mm = 0.2;
constexpr double kFar = std::numeric_limits<double>::infinity();
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
  std::vector<Pair> pairs(head_.bodies.size() * solids.size());
  for (std::size_t j = 0; j < solids.size(); ++j)
    for (std::size_t old = 0; old < solids_.size(); ++old)
      if (solids_[old].name == solids[j].name)
        for (std::size_t i = 0; i < head_.bodies.size(); ++i)
          pairs[i * solids.size() + j] = pairs_[i * solids_.size() + old];
  solids_ = std::move(solids);
  pairs_ = std::move(pairs);
  touching_ = static_cast<std::size_t>(
      std::count_if(pairs_.begin(), pairs_.end(), [](const Pair& p) { return p.state != Touching::Apart; }));
  solid_shapes_.clear();
  solid_bounds_.clear();
  all_ = {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const Solid& s : solids_) {
    solid_shapes_.emplace_back(s.shape);
    solid_bounds_.push_back(bounds_of(s.shape, s.centre, s.rotation_rad, s.slope));
    all_ = joined(all_, solid_bounds_.back());
  }
  fresh_ = true;
}

bool CollisionWatch::overlaps(std::size_t body, std::size_t solid, Vec3 centre) {
  const Solid moving{{}, {}, centre, head_.bodies[body].rotation_rad, {}};
  return overlap(body_shapes_[body], moving, solid_shapes_[solid], solids_[solid]);
}

Vec3 CollisionWatch::meeting_point(std::size_t body, std::size_t solid, Vec3 centre) const {
  const Bounds a = shifted(body_bounds_[body], centre);
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
    const config::Body& probe = head_.bodies[static_cast<std::size_t>(head_.probe_body)];
    const Vec3 way = head_.place(probe.centre, probe.on_lift, to) - head_.place(probe.centre, probe.on_lift, from);
    went_[steps_++ % went_.size()] = {norm(way), dt_s};
  }
  if (solids_.empty() || (from == to && !fresh_)) return contacts_;
  fresh_ = false;
  for (std::size_t i = 0; i < head_.bodies.size(); ++i) {
    const config::Body& body = head_.bodies[i];
    const Vec3 a = head_.place(body.centre, body.on_lift, from), b = head_.place(body.centre, body.on_lift, to);
    const Bounds swept = joined(shifted(body_bounds_[i], a), shifted(body_bounds_[i], b));
    if (touching_ == 0 && !swept.meets(all_)) continue;
    for (std::size_t j = 0; j < solids_.size(); ++j) {
      Pair& pair = pairs_[i * solids_.size() + j];
      if (swept.meets(solid_bounds_[j])) {
        step_pair(i, j, a, b, dt_s);
      } else if (pair.state != Touching::Apart) {
        pair.state = Touching::Apart;
        --touching_;
      }
    }
  }
  return contacts_;
}

/// The step that has just been noted is one of them.
bool CollisionWatch::slow_of_late(double way_mm, double dt_s) const {
  constexpr double kRounding = 1 + 1e-9;
  if (way_mm <= kTouchSpeed_mm_s * dt_s * kRounding) return true;
  double way = 0, time = 0;
  for (std::size_t back = 1; back <= std::min(steps_, went_.size()) && time < kTouchSpeedOver_s; ++back) {
    const Went& w = went_[(steps_ - back) % went_.size()];
    way += w.way_mm, time += w.dt_s;
  }
  return time >= kTouchSpeedOver_s * (1 - 1e-9) && way <= kTouchSpeed_mm_s * time * kRounding;
}

void CollisionWatch::collide(std::size_t body, std::size_t solid, Vec3 centre) {
  pairs_[body * solids_.size() + solid].state = Touching::Collided;
  contacts_.push_back({head_.bodies[body].name, solids_[solid].name, meeting_point(body, solid, centre)});
}

void CollisionWatch::step_pair(std::size_t body, std::size_t solid, Vec3 from, Vec3 to, double dt_s) {
  Pair& pair = pairs_[body * solids_.size() + solid];
  if (pair.state != Touching::Apart) {
    if (!overlaps(body, solid, to)) {
      pair.state = Touching::Apart;
      --touching_;
    } else if (pair.state == Touching::Touch) {
      const Vec3 since = to - pair.since;
      if (std::hypot(since.x, since.y) > kTouchDrag_mm || since.z < -kTouchOvertravel_mm) collide(body, solid, to);
    }
    return;
  }
  const Vec3 way = to - from;
  const int steps = std::max(1, static_cast<int>(std::ceil(norm(way) / kStep_mm)));
  for (int k = 1; k <= steps; ++k) {
    const Vec3 centre = from + way * (static_cast<double>(k) / steps);
    if (!overlaps(body, solid, centre)) continue;
    ++touching_;
    const bool slow = slow_of_late(norm(way), dt_s);
    const bool down = way.z < 0 && std::hypot(way.x, way.y) <= kTouchDrag_mm * std::abs(way.z);
    if (static_cast<int>(body) == head_.probe_body && slow && down) {
      pair = {Touching::Touch, centre};
      return;
    }
    collide(body, solid, centre);
    return;
  }
}

}  // namespace gantry::sim
