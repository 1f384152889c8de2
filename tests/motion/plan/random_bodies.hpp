// Seeded bodies and machines for the tests of planning. On the grid, faces and edges coincide, as on a fixture; that is
// where collision libraries go wrong.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "motion/geometry.hpp"
#include "motion/types.hpp"

namespace gantry::test {

class RandomBodies {
 public:
  explicit RandomBodies(std::uint64_t seed) : engine(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine); }
  config::Body body(double span, bool grid) {
    config::Body b;
    b.shape.kind = static_cast<config::Shape::Kind>(whole(0, 2));
    const auto place = [&](double s) {
      return grid ? 1.0 * whole(-static_cast<int>(s), static_cast<int>(s)) : real(-s, s);
    };
    const auto size = [&] { return grid ? 2.0 * whole(1, 8) : real(0.5, 16); };
    b.shape.size = {size(), size(), size()};
    if (b.shape.kind != config::Shape::Kind::Box) b.shape.size.y = b.shape.size.x;
    if (b.shape.kind == config::Shape::Kind::Capsule) b.shape.size.z = std::max(b.shape.size.z, b.shape.size.x);
    b.centre = {place(span), place(span), place(span)};
    if (b.shape.kind == config::Shape::Kind::Box)
      b.rotation_rad = grid ? whole(0, 3) * std::numbers::pi / 2 : real(-4, 4);
    return b;
  }
  Vec3 step(double span, bool grid) {
    if (!grid) return {real(-span, span), real(-span, span), real(-span, span)};
    const int s = static_cast<int>(span);
    return {1.0 * whole(-s, s), 1.0 * whole(-s, s), whole(0, 2) == 0 ? 1.0 * whole(-s, s) : 0.0};
  }
  std::mt19937_64 engine;
};

/// X Y Z C U with the head of a dispenser: needle (tip at 0, 0, 0), syringe, camera on Z, probe on the lift.
inline config::Machine bare_machine() {
  config::Machine m;
  const char* const names[] = {"X", "Y", "Z", "C", "U"};
  const double low[] = {-50, -50, 0, -3.2, 0}, high[] = {450, 350, 90, 3.2, 15};
  for (std::uint8_t i = 0; i < 5; ++i) {
    config::Axis a;
    a.id = AxisId{i}, a.name = names[i], a.p_min = low[i], a.p_max = high[i];
    m.axes.push_back(a);
  }
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2}, m.c = AxisId{3}, m.u = AxisId{4};
  using Form = config::Shape::Kind;
  m.head = {{"needle", {Form::Capsule, {1, 1, 20}}, {0, 0, 10}, 0, false},
            {"syringe", {Form::Cylinder, {24, 24, 60}}, {0, 0, 50}, 0, false},
            {"camera", {Form::Box, {40, 40, 50}}, {55, 0, 85}, 0.1, false},
            {"probe", {Form::Capsule, {4, 4, 40}}, {0, 30, 35}, 0, true}};
  return m;
}
inline AxisVec at(double x, double y, double z, double u = 0) { return {x, y, z, 0, u}; }

/// A straight segment; its length is that of X, Y and Z, or where these stand of what turns or lifts farthest.
inline motion::Segment line(const AxisVec& from, const AxisVec& to) {
  AxisVec displacement{};
  for (std::size_t i = 0; i < displacement.size(); ++i) displacement[i] = to[i] - from[i];
  double length = std::hypot(displacement[0], displacement[1], displacement[2]);
  if (length == 0) length = std::max(std::abs(displacement[3]), std::abs(displacement[4]));
  motion::Segment s;
  s.geometry = motion::straight(from, displacement, length);
  return s;
}

/// A body of a scene of `bare_machine`.
inline config::Body box(const char* name, Vec3 size, Vec3 centre, double rotation = 0) {
  return {name, {config::Shape::Kind::Box, size}, centre, rotation, false};
}

}  // namespace gantry::test
