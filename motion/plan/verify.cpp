#include "motion/plan/verify.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kRounding = 1e-9;  // mm on a metre, in double precision with room to spare
constexpr double kRounding_mm = 1e-9;

bool within(Vec3 centre, Vec3 half, const Box& box) {
  const Vec3 d = centre - box.centre;
  return std::abs(d.x) + half.x <= box.half.x && std::abs(d.y) + half.y <= box.half.y &&
         std::abs(d.z) + half.z <= box.half.z;
}

double half_along(const Box& box, Vec3 n) {
  return std::abs(n.x) * box.half.x + std::abs(n.y) * box.half.y + std::abs(n.z) * box.half.z;
}

/// Where a body of the head can reach along a unit vector while it is carried and turned: told by turning the vector
/// back instead of the body. Half-way it is exact, elsewhere the body's points are off that by their arc at most, and
/// that in the plane.
class Reach {
 public:
  Reach(const Scene& scene, const SceneBody& body, const AxisVec& from, const AxisVec& to, Vec3 n) {
    const Solid& s = body.solid;
    const Vec3 carried_from = scene.carried(body, from), carried_to = scene.carried(body, to);
    double own = 0;
    if (body.turning_mm > 0) {
      const double angle = (from[scene.c()] + to[scene.c()]) / 2,
                   half_turn = std::abs(to[scene.c()] - from[scene.c()]) / 2;
      const Vec2 axis = scene.turn_axis();
      const Vec3 back{n.x * std::cos(angle) + n.y * std::sin(angle), n.y * std::cos(angle) - n.x * std::sin(angle),
                      n.z};
      own = n.x * axis.x + n.y * axis.y + back.x * (s.centre.x - axis.x) + back.y * (s.centre.y - axis.y) +
            n.z * s.centre.z + extent(s, back) + farthest(s, axis) * std::min(half_turn, 2.0) * std::hypot(n.x, n.y);
    } else {
      own = dot(n, s.centre) + extent(s, n);
    }
    at_from_ = own + dot(n, carried_from), at_to_ = own + dot(n, carried_to);
  }
  /// Furthest of a body that moves along a line is at one of the two ends of its motion; both are looked at.
  [[nodiscard]] double at_from() const { return at_from_; }
  [[nodiscard]] double at_to() const { return at_to_; }

 private:
  /// From the line about which it turns to any point that this takes elsewhere. A round body is one about its middle.
  static double farthest(const Solid& s, Vec2 axis) {
    double most = 0;
    for (const double x : {-s.half.x, s.half.x})
      for (const double y : {-s.half.y, s.half.y}) {
        const bool box = s.kind == Solid::Kind::Box;
        const double corner_x = s.centre.x - axis.x + (box ? s.cos * x - s.sin * y : 0),
                     corner_y = s.centre.y - axis.y + (box ? s.sin * x + s.cos * y : 0);
        most = std::max(most, std::hypot(corner_x, corner_y));
      }
    return most;
  }
  double at_from_ = 0, at_to_ = 0;
};

/// Walks the tree for one body of the head; each separation must be of the node at which the walk stands.
class Walk {
 public:
  Walk(const Scene& scene, const AxisVec& from, const AxisVec& to, std::span<const Separation> proof,
       const Margins& margins)
      : scene_(scene), from_(from), to_(to), proof_(proof), margins_(margins) {}

  bool all() {
    for (std::size_t head = 0; head < scene_.head().size(); ++head)
      for (double begin = 0; begin < 1;) {
        // The parts of a motion follow one another without a gap, from its start to its end.
        const bool in_parts = next_ < proof_.size() && proof_[next_].head == head;
        const double end = in_parts ? proof_[next_].upto : 1;
        if (!(end > begin && end <= 1) || !part(head, begin, end)) return false;
        begin = end;
      }
    return next_ == proof_.size();
  }

 private:
  bool part(std::size_t head, double begin, double end) {
    const auto& nodes = scene_.tree().nodes();
    const AxisVec from = begin > 0 ? between(from_, to_, begin) : from_, to = end < 1 ? between(from_, to_, end) : to_;
    for (std::size_t node = 0; node < nodes.size();) {
      const bool named = next_ < proof_.size() && proof_[next_].head == head && proof_[next_].node == node &&
                         proof_[next_].upto == end;
      if (!named && nodes[node].body != Tree::kInner) return false;  // a body that nothing parts off
      if (named && !parted(head, nodes[node], from, to)) return false;
      node = named ? nodes[node].skip : node + 1;
    }
    return true;
  }

  bool parted(std::size_t head, const Tree::Node& node, const AxisVec& from, const AxisVec& to) {
    const double margin = node.body == Tree::kInner ? margins_.clearance_mm : margins_.of(head, node.body);
    return holds(scene_, from, to, proof_[next_++], margin);
  }

  const Scene& scene_;
  const AxisVec &from_, &to_;
  std::span<const Separation> proof_;
  const Margins& margins_;
  std::size_t next_ = 0;
};

}  // namespace

bool holds_all(const Tree& tree, std::span<const SceneBody> standing) {
  const auto& nodes = tree.nodes();
  std::vector<bool> seen(standing.size(), false);
  std::vector<std::size_t> above;  // inner nodes that are open
  std::size_t bodies = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Tree::Node& node = nodes[i];
    while (!above.empty() && i >= nodes[above.back()].skip) above.pop_back();
    if (i > 0 && above.empty()) return false;
    const bool leaf = node.body != Tree::kInner;
    if (node.skip <= i || node.skip > nodes.size() || (leaf && node.skip != i + 1)) return false;
    if (!above.empty() &&
        (node.skip > nodes[above.back()].skip ||
         !within(node.box.centre, node.box.half - Vec3{kRounding, kRounding, kRounding}, nodes[above.back()].box)))
      return false;
    if (!leaf) {
      above.push_back(i);
      continue;
    }
    if (node.body >= standing.size() || seen[node.body]) return false;
    seen[node.body] = true;
    ++bodies;
  }
  if (bodies != standing.size()) return false;
  // Each body within each box above it: boxes within boxes alone would add their rounding up.
  above.clear();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    while (!above.empty() && i >= nodes[above.back()].skip) above.pop_back();
    above.push_back(i);
    if (nodes[i].body == Tree::kInner) continue;
    const Solid& s = standing[nodes[i].body].solid;
    const Vec3 half{extent(s, {1, 0, 0}), extent(s, {0, 1, 0}), extent(s, {0, 0, 1})};
    for (const std::size_t box : above)
      if (!within(s.centre, half, nodes[box].box)) return false;
  }
  return true;
}

bool holds(const Scene& scene, const AxisVec& from, const AxisVec& to, const Separation& separation, double margin_mm) {
  const Vec3 n = separation.direction;
  if (!(std::abs(dot(n, n) - 1) < kRounding)) return false;
  const SceneBody& a = scene.head()[separation.head];
  const Tree::Node& node = scene.tree().nodes()[separation.node];
  const Reach reach(scene, a, from, to, n);
  double begins = 0;
  if (node.body == Tree::kInner) {
    begins = dot(n, node.box.centre) - half_along(node.box, n);
  } else {
    const Solid& b = scene.standing()[node.body].solid;
    begins = dot(n, b.centre) - extent(b, n);
  }
  return begins - reach.at_from() >= margin_mm + kRounding_mm && begins - reach.at_to() >= margin_mm + kRounding_mm;
}

bool is_free(const Scene& scene, const AxisVec& from, const AxisVec& to, std::span<const Separation> proof,
             const Margins& margins) {
  return scene.tree_holds() && Walk(scene, from, to, proof, margins).all();
}

}  // namespace gantry::motion
