#include "motion/plan/scene.hpp"

#include <bit>
#include <fmt/format.h>

#include "motion/plan/verify.hpp"

namespace gantry::motion {
namespace {

SceneBody make(const config::Body& body) {
  const Solid s = make_solid(body);
  return {.name = body.name, .solid = s, .on_lift = body.on_lift, .half_box = half_box(s), .keep_out = body.keep_out};
}

void add(Fnv1a& hash, double v) {
  const auto bits = std::bit_cast<std::uint64_t>(v + 0.0);  // -0 is 0
  for (int i = 0; i < 64; i += 8) hash.add(static_cast<std::uint8_t>(bits >> i));
}
void add_geometry(Fnv1a& hash, const SceneBody& b) {
  hash.add(static_cast<std::uint8_t>(b.solid.kind));
  for (const Vec3 v : {b.solid.centre, b.solid.half}) add(hash, v.x), add(hash, v.y), add(hash, v.z);
  add(hash, b.solid.cos), add(hash, b.solid.sin);
  hash.add(static_cast<std::uint8_t>(b.on_lift));
  if (b.turning_mm > 0) add(hash, b.turning_mm);
}
void add(Fnv1a& hash, const SceneBody& b) {
  for (const char c : b.name) hash.add(static_cast<std::uint8_t>(c));
  hash.add(0);
  add_geometry(hash, b);
}
std::uint64_t hash_of_geometry(const SceneBody& b, bool of_head) {
  Fnv1a hash;
  hash.add(static_cast<std::uint8_t>(of_head));
  add_geometry(hash, b);
  return hash.value();
}

}  // namespace

Scene::Scene(const config::Machine& m) : x_(m.x.value), y_(m.y.value), z_(m.z.value), has_lift_(m.u.has_value()) {
  if (m.u) u_ = m.u->value;
  if (m.c) c_ = m.c->value, turn_axis_ = config::turn_axis(m);
  for (const config::Axis& a : m.axes) axes_.push_back({a.name, a.p_min, a.p_max});
  for (const config::Body& b : m.head) {
    head_.push_back(make(b));
    if (b.on_turn && m.c) head_.back().turning_mm = turning_radius(head_.back().solid, turn_axis_);
    turns_ = turns_ || head_.back().turning_mm > 0;
    motion::add(hash_, head_.back());
    geometry_ += motion::hash_of_geometry(head_.back(), true);
  }
  if (turns_) {
    Fnv1a axis;
    for (const double v : {turn_axis_.x, turn_axis_.y}) motion::add(hash_, v), motion::add(axis, v);
    geometry_ += axis.value();
  }
  motion::add(hash_, static_cast<double>(head_.size()));
  std::vector<config::Body> standing = m.scene;
  standing.insert(standing.end(), m.keep_out.begin(), m.keep_out.end());
  add(standing);
}

void Scene::add(std::span<const config::Body> bodies) {
  for (const config::Body& body : bodies) {
    standing_.push_back(make(body));
    motion::add(hash_, standing_.back());
    geometry_ += motion::hash_of_geometry(standing_.back(), false);
  }
  std::vector<Box> boxes;
  for (const SceneBody& b : standing_) boxes.push_back({b.solid.centre, b.half_box});
  tree_ = Tree(boxes), wide_tree_ = WideTree(tree_);
  tree_holds_ = holds_all(tree_, standing_);
}

Vec3 BoardFrame::from_machine(Vec3 p) const {
  const Vec2 at = rotated(Vec2{p.x - origin.x, p.y - origin.y}, -rotation_rad);
  return {at.x, at.y, p.z - origin.z - dot(slope, at)};
}

std::string Scene::told(Vec3 p) const {
  const std::string machine = fmt::format("{:.2f}, {:.2f}, {:.2f}", p.x, p.y, p.z);
  if (!board_) return fmt::format("({}) mm", machine);
  const Vec3 b = board_->from_machine(p);
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm [machine {}]", b.x, b.y, b.z, machine);
}

}  // namespace gantry::motion
