// A small machine and board made by hand, so that the world's tests depend on no file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "config/machine.hpp"
#include "recipes/recipe.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim::sample {

/// A path of this process alone: tests of several checkouts run at once.
inline std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / (name + "." + std::to_string(::getpid()))).string();
}

inline config::Axis axis(std::uint8_t id, const char* name, bool rotary = false) {
  config::Axis a;
  a.id = AxisId{id};
  a.name = name;
  a.rotary = rotary;
  return a;
}

inline config::Machine machine() {
  config::Machine m;
  m.name = "sample";
  m.axes = {axis(0, "X"), axis(1, "Y"), axis(2, "Z"), axis(3, "C", true), axis(4, "U")};
  m.stations.resize(1);
  m.stations[0].name = "drives";
  for (config::Axis& a : m.axes) a.drives = {{StationId{0}, a.id.value, false}};
  for (auto& input : m.inputs) input = config::Channel{};
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  m.c = AxisId{3}, m.u = AxisId{4};
  m.sim.axes.resize(5);
  using Kind = config::Shape::Kind;
  m.tools = {{"needle", {0, 0, -100}, 0}, {"camera", {60, 0, -110}, 0}, {"probe", {-40, 0, -90}, 15}};
  m.head = {{"needle", {Kind::Capsule, {1, 1, 30}}, {0, 0, -85}, 0, false},
            {"syringe", {Kind::Cylinder, {20, 20, 60}}, {0, 0, -40}, 0, false},
            {"lens", {Kind::Box, {40, 40, 40}}, {60, 0, 0}, 0, false},
            {"probe", {Kind::Capsule, {4, 4, 40}}, {-40, 0, -70}, 0, true}};
  m.scene = {{"pallet", {Kind::Box, {400, 300, 20}}, {200, 150, -10}, 0, false},
             {"post", {Kind::Cylinder, {20, 20, 60}}, {350, 250, 30}, 0, false}};
  m.frames = {{"pallet", {100, 80, 0}}};
  m.camera.width_px = 640, m.camera.height_px = 512, m.camera.mm_per_px = 0.02;
  m.probe.axis = m.z;
  m.sim.valve_open_lag_s = 0.0023;
  m.sim.valve_close_lag_s = 0.0017;
  m.sim.height_spread_mm = 0.3;
  m.sim.tilt_spread_rad = 0.001;
  m.sim.placement_spread_mm = 1.5;
  m.sim.placement_spread_rad = 0.02;
  m.sim.camera_noise = 2;
  return m;
}

inline recipes::Recipe recipe() {
  recipes::Recipe r;
  r.name = "sample board";
  r.board = {{120, 80}, 1.6, "pallet", {20, 10}, 0};
  r.parts = {{"relay", {60, 40}, {20, 10, 15}, 0.2, false, {}}, {"clamp", {-6, 40}, {10, 20, 12}, 0, true, {}}};
  r.marks = {{"M1", {10, 10}, 2, true, {}}, {"M2", {110, 10}, 2, true, {}}, {"M3", {110, 70}, 3, false, {}}};
  r.materials = {{"glue", 20, 0.3, 0, 0, 0.05, 0.02, 1}};
  r.features = {recipes::Dot{"d1", {20, 20}, "glue", {}}, recipes::Dot{"d2", {25, 20}, "glue", {}},
                recipes::Bead{"b1", {{30, 60}, {60, 60}, {60, 70}}, false, 0, "glue", {}}};
  return r;
}

/// Axis coordinates that put a tool's configured tip at a machine point.
inline AxisVec tool_at(const config::Machine& m, const char* tool, Vec3 at) {
  AxisVec q{};
  const config::Tool* t = config::find_tool(m, tool);
  q[0] = at.x - t->tip.x, q[1] = at.y - t->tip.y, q[2] = at.z - t->tip.z + t->lift_mm;
  q[4] = t->lift_mm;
  return q;
}

/// Steps a world at 1 kHz.
struct Stepper {
  World& world;
  std::uint64_t cycle = 0;
  Time now = seconds_(1);
  std::uint32_t outputs = 0;

  static Time seconds_(int s) { return Time(std::int64_t{s} * 1'000'000'000); }
  Senses to(const AxisVec& q) {
    now += milliseconds(1);
    return world.step(++cycle, now, {q, outputs});
  }
  /// Straight from one place to another in `ticks`.
  Senses move(const AxisVec& a, const AxisVec& b, int ticks) {
    Senses last;
    for (int k = 1; k <= ticks; ++k) {
      AxisVec q = a;
      for (std::size_t i = 0; i < q.size(); ++i) q[i] += (b[i] - a[i]) * k / ticks;
      last = to(q);
    }
    return last;
  }
};

}  // namespace gantry::sim::sample
