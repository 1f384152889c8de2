#include "tests/app/record/made_up_job.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "vision/camera.hpp"

namespace gantry::record {
namespace {

constexpr double kNeedleZ = -60, kCameraX = 45;
const Vec3 kBoard{100, 80, 12};  // origin of the top face in the machine

struct Pen {
  JobResult& r;
  Vec3 head{0, 0, 120};
  double t = 0;
  std::uint32_t block = 1;
  Vec3 tip{0, 0, kNeedleZ};
  std::mt19937 random{7};

  Vec3 head_for(Vec3 board) const {
    const Vec2 p = rotated({board.x, board.y}, r.offset.rotation) + r.offset.shift;
    return kBoard + Vec3{p.x, p.y, board.z} - tip;
  }
  void to(Vec3 target, double speed, bool valve) {
    std::normal_distribution<double> noise(0, 0.004);
    const double length = norm(target - head);
    const int n = std::max(1, static_cast<int>(length / speed / 0.01));
    const Vec3 from = head;
    for (int i = 1; i <= n; ++i) {
      const Vec3 p = from + (target - from) * (double(i) / n);
      t += length / speed / n;
      r.planned.push_back({t, p, block, valve});
      r.actual.push_back({t, p + Vec3{noise(random), noise(random), 0}, block, valve});
    }
    head = target;
  }
  void wait(double s, bool valve) {
    t += s;
    r.planned.push_back({t, head, block, valve});
    r.actual.push_back({t, head, block, valve});
  }
  void over(Vec2 p, double gap) {
    to({head.x, head.y, head_for({p.x, p.y, 14}).z}, 150, false);
    to(head_for({p.x, p.y, 14}), 250, false);
    to(head_for({p.x, p.y, gap}), 120, false);
  }
};

void look(Pen& pen, const char* name, Vec2 at, double residual) {
  pen.r.drawing.tip_of_block.push_back({kCameraX, 0, -90});
  pen.tip = {kCameraX, 0, -90};
  pen.to(pen.head_for({at.x, at.y, 0}), 200, false);
  pen.wait(0.2, false);
  MarkResult m;
  m.name = name, m.found = true, m.nominal = at;
  m.measured = rotated(at, pen.r.offset.rotation) + pen.r.offset.shift + Vec2{residual, -residual / 2};
  m.residual_mm = std::abs(residual) * 1.118;
  m.attempts = 1;
  pen.r.marks.push_back(m);
  ++pen.block;
}

void touch(Pen& pen, const char* name, Vec2 at, double height) {
  pen.r.drawing.tip_of_block.push_back({-30, 10, -70});
  pen.tip = {-30, 10, -70};
  pen.to(pen.head_for({at.x, at.y, 8}), 200, false);
  pen.to(pen.head_for({at.x, at.y, 0.1}), 20, false);
  pen.to(pen.head_for({at.x, at.y, 8}), 60, false);
  pen.r.touches.push_back({name, at, height, 0.004});
  ++pen.block;
}

}  // namespace

JobResult made_up_job() {
  JobResult r;
  r.job = "demo-board-0001";
  r.recipe_file = "recipes/demo-board.yaml";
  r.recipe_name = "demo-board";
  r.machine_name = "dispenser";
  r.bus = "sim";
  r.dry_run = true;
  r.started = "2026-11-21T08:30:16.000Z";
  r.offset = {{1.3, -0.7}, 0.8 * std::numbers::pi / 180};
  r.offset_rms_mm = 0.0021;
  r.has_offset = true;
  r.surface = {0.12, {0.0004, -0.0002}};
  r.has_surface = true;
  auto& d = r.drawing;
  d.board_size = {120, 80};
  d.board_origin = kBoard;
  d.parts = {{"J1 connector", {22, 60}, {24, 9, 11}, 0, false},
             {"U3", {60, 42}, {16, 16, 2}, 0.2, false},
             {"C7 capacitor", {98, 58}, {10, 10, 14}, 0, false},
             {"clamp left", {-3, 40}, {10, 16, 12}, 0, true},
             {"clamp right", {123, 40}, {10, 16, 12}, 0, true}};
  d.tip_of_block.push_back({0, 0, kNeedleZ});
  using Role = DrawnBody::Role;
  using Kind = config::Shape::Kind;
  d.bodies = {{Role::Machine, {"pallet", {Kind::Box, {200, 140, 20}}, {160, 120, 0}}},
              {Role::Machine, {"post", {Kind::Cylinder, {16, 16, 60}}, {80, 180, 30}}},
              {Role::Board, {"board", {Kind::Box, {120, 80, 2}}, {160, 120, 11}, r.offset.rotation}},
              {Role::Part, {"relay", {Kind::Box, {16, 16, 9}}, {160, 122, 16.5}, r.offset.rotation + 0.2}},
              {Role::Fixture, {"clamp left", {Kind::Box, {10, 16, 22}}, {97, 120, 21}}},
              {Role::Head, {"needle", {Kind::Capsule, {1.6, 1.6, 26}}, {0, 0, kNeedleZ + 13}}},
              {Role::Head, {"camera", {Kind::Box, {40, 40, 60}}, {kCameraX, 0, -20}}}};
  d.spots = {{"lower left", {105, 85, 12}, false}, {"t1", {112, 92, 12}, true}};
  d.asked = {{{120, 94, 12}}, {{160, 92, 12}, {160, 106, 12}, {184, 106, 12}}};

  Pen pen{r};
  look(pen, "lower left", {5, 5}, 0.0015);
  look(pen, "lower right", {115, 5}, -0.0021);
  look(pen, "upper right", {115, 75}, 0.0008);
  look(pen, "upper left", {5, 75}, -0.0012);
  touch(pen, "t1", {12, 12}, 0.121);
  touch(pen, "t2", {108, 14}, 0.164);
  touch(pen, "t3", {60, 70}, 0.108);

  d.tip_of_block.push_back({0, 0, kNeedleZ});
  pen.tip = {0, 0, kNeedleZ};
  std::normal_distribution<double> spread(0, 0.003);
  const auto near = [&](Vec2 p, double gap) {
    return Vec3{p.x + spread(pen.random), p.y + spread(pen.random), gap + spread(pen.random)};
  };
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 6; ++column) {
      const Vec2 at{20 + 5.0 * column, 14 + 5.0 * row};
      pen.over(at, 0.3);
      pen.wait(0.06, true);
      pen.wait(0.02, false);
      Deposit dot{"dots[" + std::to_string(row) + "][" + std::to_string(column) + "]", "dot", {{at.x, at.y, 0.3}}, {}};
      dot.board_mm = {near(at, 0.3)};
      dot.error_mm = std::hypot(dot.board_mm[0].x - at.x, dot.board_mm[0].y - at.y);
      dot.gap_mm = dot.board_mm[0].z;
      dot.asked_gap_mm = dot.nominal_mm[0].z;
      r.deposits.push_back(dot);
    }
  const std::vector<std::pair<std::string, std::vector<Vec2>>> beads{
      {"L", {{60, 12}, {60, 26}, {84, 26}}},
      {"rectangle", {{48, 32}, {72, 32}, {72, 54}, {48, 54}, {48, 32}}},
      {"polyline", {{80, 34}, {86, 40}, {84, 48}, {90, 52}, {88, 60}, {94, 68}}},
      {"edge", {{12, 72}, {50, 72}}},
      {"shield", {{94, 12}, {110, 12}, {110, 24}, {94, 24}}},
      {"foot", {{40, 62}, {60, 62}, {70, 66}}}};
  for (const auto& [id, points] : beads) {
    pen.over(points.front(), 0.25);
    Deposit bead{id, "bead", {}, {}};
    for (const auto& p : points) {
      pen.to(pen.head_for({p.x, p.y, 0.25}), 20, true);
      bead.nominal_mm.push_back({p.x, p.y, 0.25});
      bead.board_mm.push_back(near(p, 0.25));
    }
    pen.wait(0.01, false);
    bead.error_mm = 0.004 + std::abs(spread(pen.random));
    bead.gap_mm = 0.25 + spread(pen.random);
    bead.asked_gap_mm = 0.25;
    r.deposits.push_back(bead);
  }
  ++pen.block;
  d.tip_of_block.push_back({0, 0, kNeedleZ});
  pen.to({pen.head.x, pen.head.y, 120}, 150, false);
  pen.to({0, 0, 120}, 300, false);

  r.has_world = true;
  r.predicted_s = pen.t - 0.012;
  r.actual_s = pen.t;
  r.wall_s = 0.71;
  r.blocks_done = r.blocks_total = 9;
  r.features_done = r.features_total = 30;
  r.valve_openings = 30;
  r.valve_open_s = 11.2;
  r.axes = {{"X", true, 0.0123, 2.5, false, 0.5, 5.5},
            {"Y", true, 0.0181, 0, false},
            {"Z", true, 0.0049, 0, false},
            {"C", false, 0, 0, true},
            {"U", false, 0, 0, false}};
  r.motions_certified = 148;
  r.minimum_clearance.by_design = job::Nearest{0.25,
                                               "needle",
                                               "board",
                                               "down to dot 'a'",
                                               "recipes/made-up.yaml:30:5",
                                               {190, 170, -110},
                                               Vec3{10, 20, 0},
                                               {190, 170, -50}};
  r.minimum_clearance.others = job::Nearest{2.31,
                                            "needle",
                                            "relay",
                                            "along bead 'seam'",
                                            "recipes/made-up.yaml:40:5",
                                            {190, 170, -107},
                                            Vec3{10, 20, 3},
                                            {192, 171, -45}};
  r.setpoint_hash = 0x3f9ac27780be1d05u;
  r.setpoint_ticks = static_cast<std::uint64_t>(pen.t * 1000);
  r.cycles.cycles = r.cycles.sent = 61234;
  r.cycles.wake = {3500, 21000, 48000, 133000};
  r.cycles.compute = {21000, 38000, 61000, 98000};
  r.cycles.bus = {9000, 14000, 22000, 61000};
  for (int i = 0; i < 60; ++i) {
    const auto ns = static_cast<std::int64_t>(1000 * std::pow(1.09, i));
    const double x = (std::log(static_cast<double>(ns)) - std::log(4000.0)) / 0.6;
    const auto count = static_cast<std::uint64_t>(5000 * std::exp(-x * x / 2));
    if (count > 0) r.cycles.wake_histogram.push_back({ns, count});
  }
  r.cycles.wake_histogram.push_back({133000, 1});
  r.cycles.real_time_priority = true;
  r.placement = "dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg, dz=0.12 mm";
  r.environment = {{"program", "gantry 0.1.0"}, {"kernel", "Linux 6.1.0-13-amd64 x86_64"}, {"processor", "2 x Xeon"}};
  r.events = {"0.000 s  job starts", "3.100 s  work offset: 1.300 mm, -0.700 mm, 0.800 deg"};
  return r;
}

JobResult made_up_failure() {
  auto r = made_up_job();
  r.dry_run = false;
  r.exit_code = ExitCode::Device;
  r.errors = {{Fault::DriveFault,
               "axis Y, station y1: overvoltage <bus> & \"supply\" (603Fh = 3210h); check the regenerative resistor",
               "station 2 'y1'"}};
  r.features_done = 17;
  r.blocks_done = 7;
  r.interrupted = {"dots[2][5]"};
  r.collisions = {{"needle", "C7 capacitor", {198, 138, 25}, 21400, 21.4}};
  r.marks[2].found = false;
  r.marks[2].reason = "contrast 4 below 20";
  r.setpoint_stream_complete = false;
  r.deposits.resize(18);
  return r;
}

}  // namespace gantry::record
