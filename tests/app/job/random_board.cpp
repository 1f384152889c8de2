#include "tests/app/job/random_board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/units.hpp"

namespace gantry::test {
namespace {

/// Draws one board. mt19937_64 and the arithmetic below are the same everywhere.
class Draw {
 public:
  Draw(const config::Machine& machine, std::uint64_t number) : engine_(number * 0x9E3779B97F4A7C15u + 1) {
    out_.machine = machine;
    recipe_.name = "random", recipe_.file = "random.yaml";
  }

  RandomBoard board() {
    recipe_.board = {.size = {real(50, 115), real(35, 78)},
                     .thickness = chance(0.3) ? real(0.8, 2) : real(2, 12),
                     .frame = "pallet",
                     .at = {},
                     .frame_location = location()};
    recipe_.materials.push_back({.name = "glue",
                                 .speed = 20,
                                 .gap = real(0.15, 0.8),
                                 .valve_open_lead = 0.008,
                                 .valve_close_lead = 0.006,
                                 .dot_time = 0.03,
                                 .settle_time = 0.01,
                                 .retract = real(0.8, 4),
                                 .location = location()});
    recipe_.touch_rules = {.max_residual_mm = 0.1,
                           .window_mm = std::min(real(0.5, 2.5), recipe_.board.thickness - 0.2)};
    recipe_.mark_rules = {.max_residual_mm = 0.05, .max_shift_mm = real(0, 3), .max_rotation_rad = real(0, 0.03)};
    const int marks = whole(0, 3), touches = whole(0, 4), features = whole(1, 6), bodies = whole(1, 9);
    for (int i = 0; i < marks; ++i)
      recipe_.marks.push_back(
          {.name = "m" + std::to_string(i), .at = on_board(), .diameter = 1.5, .location = location()});
    for (int i = 0; i < touches; ++i)
      recipe_.touches.push_back({.name = "t" + std::to_string(i), .at = on_board(), .location = location()});
    for (int i = 0; i < features; ++i) feature(i);
    for (int i = 0; i < bodies; ++i) body(i);
    placement();
    out_.recipe = recipe_;
    return out_;
  }

 private:
  double real(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  int whole(int low, int high) { return low + static_cast<int>(engine_() % static_cast<unsigned>(high - low + 1)); }
  bool chance(double share) { return real(0, 1) < share; }
  recipes::Location location() { return {++line_, 5}; }
  Vec2 on_board() { return {real(1, recipe_.board.size.x - 1), real(1, recipe_.board.size.y - 1)}; }
  Vec2 unit() { return rotated({1, 0}, real(-M_PI, M_PI)); }

  void feature(int i) {
    if (chance(0.6)) {
      recipe_.features.emplace_back(
          recipes::Dot{.id = "d" + std::to_string(i), .at = on_board(), .material = "glue", .location = location()});
      return;
    }
    recipes::Bead bead;
    bead.id = "b" + std::to_string(i), bead.material = "glue", bead.location = location();
    const int points = whole(2, 4);
    for (int k = 0; k < points; ++k) {
      const Vec2 p = on_board();
      bead.points.push_back({p.x, p.y, 0});
    }
    bead.corner_tolerance = chance(0.5) ? 0.2 : 0;
    recipe_.features.emplace_back(std::move(bead));
  }

  /// Where the job works: bodies are put around these.
  Vec2 somewhere_worked() {
    std::vector<Vec2> points{on_board()};
    for (const auto& t : recipe_.touches) points.push_back(t.at), points.push_back(t.at);
    for (const auto& m : recipe_.marks) points.push_back(m.at);
    for (const auto& f : recipe_.features)
      points.push_back(std::holds_alternative<recipes::Dot>(f) ? std::get<recipes::Dot>(f).at
                                                               : flat(std::get<recipes::Bead>(f).points.front()));
    return points[static_cast<std::size_t>(whole(0, static_cast<int>(points.size()) - 1))];
  }

  /// Distances about which a proof decides: the clearance itself, give or take next to nothing.
  double about_clearance() {
    constexpr std::array kOff{0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5, 1e-3, -1e-3};
    return out_.machine.clearance_mm + kOff[static_cast<std::size_t>(whole(0, kOff.size() - 1))];
  }

  void body(int i) {
    const double t = recipe_.board.thickness;
    const Vec2 centre = somewhere_worked();
    const std::string name = "body" + std::to_string(i);
    Vec3 size{real(1, 14), real(1, 14), chance(0.6) ? real(0.05, 3) : real(3, 20)};
    const bool level = chance(0.5);
    const double turn = level ? 0 : real(-M_PI, M_PI);
    Vec2 at = centre + unit() * real(0, 14);
    if (chance(0.4)) {  // beside the stylus or the needle, as near as is just allowed
      const double radius = chance(0.5) ? 1.5 : 0.8;
      at = centre + Vec2{(chance(0.5) ? 1 : -1) * (radius + size.x / 2 + about_clearance()), real(-0.3, 0.3) * size.y};
    } else if (chance(0.2)) {  // under the needle in a touch, or under the camera, as high as is just allowed
      at = centre + Vec2{40, 0};
      size.z = std::max(0.05, 6 - recipe_.touch_rules.window_mm - about_clearance());
    }
    switch (whole(0, 3)) {
      case 0:
      case 1:
        recipe_.parts.push_back({.name = name, .at = at, .size = size, .rotation = turn, .location = location()});
        break;
      case 2:
        recipe_.parts.push_back({.name = name,
                                 .at = at,
                                 .size = {size.x, size.y, std::max(0.3, t + size.z - 1)},
                                 .rotation = turn,
                                 .fixture = true,
                                 .location = location()});
        break;
      default: {  // of the machine: a ledge beside the board, or a shelf over it
        const bool shelf = chance(0.6);
        const double bottom = shelf ? real(1, 80) : -t + real(0, t + 2) - size.z;
        const Vec3 extent = shelf ? Vec3{real(5, 70), real(5, 70), real(1, 5)} : size;
        const Vec3 p = recipes::to_machine(recipe_, out_.machine, {}, {}, at, bottom + extent.z / 2);
        out_.machine.scene.push_back({name, {config::Shape::Kind::Box, extent}, p, level ? 0 : turn, false});
      }
    }
  }

  /// Within the rules: what no rule measures lies as by drawing.
  void placement() {
    sim::BoardPlacement& p = out_.placement;
    if (!recipe_.marks.empty()) p.shift = unit() * real(0, recipe_.mark_rules.max_shift_mm);
    if (recipe_.marks.size() >= 2)
      p.rotation_rad = real(-recipe_.mark_rules.max_rotation_rad, recipe_.mark_rules.max_rotation_rad);
    if (recipe_.touches.empty()) return;
    const double w = recipe_.touch_rules.window_mm;
    const Vec2 size = recipe_.board.size;
    if (recipe_.touches.size() < 3) {
      // As far as the rule allows, which way the touches do not show.
      const double most = units::rad(real(0.01, 0.5));
      if (chance(0.8)) recipe_.touch_rules.max_tilt_rad = most;
      const double slope = recipe_.touch_rules.max_tilt_rad ? std::tan(most) : std::tan(units::rad(0.15));
      p.slope = unit() * slope * (chance(0.5) ? 1.0 : real(0, 1));
    } else {
      recipe_.touch_rules.max_tilt_rad = units::rad(5);
      const double lean = real(0, 1) * w;
      const Vec2 share{real(-1, 1), real(-1, 1)};
      p.slope = {lean * share.x / size.x, lean * share.y / size.y};
    }
    // The whole face within the window.
    const double most = std::abs(p.slope.x) * size.x + std::abs(p.slope.y) * size.y;
    p.slope = p.slope * (most > w ? w / most : 1.0);
    const double up = std::max(0.0, p.slope.x * size.x) + std::max(0.0, p.slope.y * size.y);
    const double down = std::max(0.0, -p.slope.x * size.x) + std::max(0.0, -p.slope.y * size.y);
    p.z0_mm = real(-w + down, w - up);
  }

  std::mt19937_64 engine_;
  RandomBoard out_;
  recipes::Recipe recipe_;
  int line_ = 0;
};

}  // namespace

RandomBoard random_board(const config::Machine& machine, std::uint64_t number) { return Draw(machine, number).board(); }

}  // namespace gantry::test
