#include "motion/plan/scene.hpp"

#include <bit>

namespace gantry::motion {
namespace {

SceneBody make(const config::Body& body) {
  const Solid s = make_solid(body);
  return {body.name, s, body.on_lift, {extent(s, {1, 0, 0}), extent(s, {0, 1, 0}), extent(s, {0, 0, 1})}};
}

class Fnv {
 public:
  void add(std::uint8_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3ULL; }
  void add(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v + 0.0);  // -0 is 0
    for (int i = 0; i < 64; i += 8) add(static_cast<std::uint8_t>(bits >> i));
  }
  void add(const SceneBody& b) {
    for (const char c : b.name) add(static_cast<std::uint8_t>(c));
    add(static_cast<std::uint8_t>(b.solid.kind));
    for (const Vec3 v : {b.solid.centre, b.solid.half}) add(v.x), add(v.y), add(v.z);
    add(b.solid.cos), add(b.solid.sin);
    add(static_cast<std::uint8_t>(b.on_lift));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

}  // namespace

Scene::Scene(const config::Machine& m) : x_(m.x.value), y_(m.y.value), z_(m.z.value), has_lift_(m.u.has_value()) {
  if (m.u) u_ = m.u->value;
  for (const config::Axis& a : m.axes) axes_.push_back({a.name, a.p_min, a.p_max});
  for (const config::Body& b : m.head) head_.push_back(make(b));
  for (const config::Body& b : m.scene) add(b);
}

void Scene::add(const config::Body& body) {
  standing_.push_back(make(body));
  boxes_.push_back({standing_.back().solid.centre, standing_.back().half_box});
}

std::uint64_t Scene::hash() const {
  Fnv hash;
  for (const auto* bodies : {&head_, &standing_}) {
    hash.add(static_cast<double>(bodies->size()));
    for (const SceneBody& b : *bodies) hash.add(b);
  }
  return hash.value();
}

}  // namespace gantry::motion
