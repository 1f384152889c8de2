#include "bench/plan/pallet.hpp"

#include <cmath>
#include <string>

#include "motion/plan/sweep.hpp"

namespace gantry::bench {
namespace {

double draw(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace

config::Machine pallet(int parts, std::uint64_t seed) {
  using Form = config::Shape::Kind;
  std::mt19937_64 random(seed);
  config::Machine m;
  const char* const names[] = {"X", "Y", "Z"};
  const double high[] = {400, 300, 100};
  for (std::uint8_t i = 0; i < 3; ++i) {
    config::Axis a;
    a.id = AxisId{i}, a.name = names[i], a.p_min = 0, a.p_max = high[i];
    m.axes.push_back(a);
  }
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  m.head = {{"needle", {Form::Capsule, {1, 1, 25}}, {0, 0, 12.5}, 0, false},
            {"syringe", {Form::Cylinder, {20, 20, 80}}, {0, 0, 65}, 0, false},
            {"camera", {Form::Box, {40, 40, 60}}, {50, 0, 75}, 0, false},
            {"probe", {Form::Capsule, {4, 4, 40}}, {0, 30, 28}, 0, false}};
  // The more parts, the smaller: between a third and two thirds of the pallet are covered.
  const double size = std::min(30.0, 260 / std::sqrt(static_cast<double>(parts)));
  for (int i = 0; i < parts; ++i) {
    config::Body b;
    b.name = "part " + std::to_string(i);
    const bool is_box = i % 3 != 0;
    const double height = draw(random, 2, 30);
    b.shape.kind = is_box ? Form::Box : Form::Cylinder;
    b.shape.size = {draw(random, 0.3, 1) * size, draw(random, 0.3, 1) * size, height};
    if (!is_box) b.shape.size.y = b.shape.size.x;
    b.centre = {draw(random, 0, 400), draw(random, 0, 300), height / 2};
    if (is_box && i % 2 == 0) b.rotation_rad = draw(random, 0, 3.14);
    m.scene.push_back(b);
  }
  return m;
}

std::vector<Line> lines(const motion::Scene& scene, int count, std::uint64_t seed, bool blocked_only) {
  std::mt19937_64 random(seed);
  const motion::Margins margins{};
  const auto somewhere = [&] {
    for (;;) {
      const AxisVec q{draw(random, 0, 400), draw(random, 0, 300), draw(random, 0, 35)};
      if (motion::is_clear(scene, q, q, margins)) return q;
    }
  };
  std::vector<Line> out;
  while (out.size() < static_cast<std::size_t>(count)) {
    const Line line{somewhere(), somewhere()};
    if (!blocked_only || !motion::is_clear(scene, line.from, line.to, margins)) out.push_back(line);
  }
  return out;
}

}  // namespace gantry::bench
