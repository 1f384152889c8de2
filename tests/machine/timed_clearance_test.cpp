// What is certified is what is played: the targets of every cycle of whole jobs as they are sent to drives of unlike
// delay, blends and run-ups included, keep the clearance from every body. The judge knows upright bodies by closed
// forms of its own and where they stand from machine file and recipe; it shares nothing with the proof.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <random>
#include <set>

#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

using config::Body;
using Kind = config::Shape::Kind;
using test::Rig;

constexpr double kRounding_mm = 1e-6;

std::array<Vec2, 4> corners(const Body& box, Vec2 at) {
  const double c = std::cos(box.rotation_rad), s = std::sin(box.rotation_rad);
  std::array<Vec2, 4> out;
  constexpr std::array<std::array<double, 2>, 4> kSigns{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = kSigns[i][0] * box.shape.size.x / 2, y = kSigns[i][1] * box.shape.size.y / 2;
    out[i] = {at.x + c * x - s * y, at.y + s * x + c * y};
  }
  return out;
}

/// Of a point from a rectangle, seen from above; 0 within it.
double point_to_box(Vec2 p, const Body& box, Vec2 at) {
  const double c = std::cos(box.rotation_rad), s = std::sin(box.rotation_rad);
  const double x = c * (p.x - at.x) + s * (p.y - at.y), y = c * (p.y - at.y) - s * (p.x - at.x);
  return std::hypot(std::max(0.0, std::abs(x) - box.shape.size.x / 2),
                    std::max(0.0, std::abs(y) - box.shape.size.y / 2));
}

double edge_to_edge(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const auto cross_of = [](Vec2 u, Vec2 v) { return u.x * v.y - u.y * v.x; };
  const double den = cross_of(b - a, d - c);
  if (den != 0) {
    const double t = cross_of(c - a, d - c) / den, u = cross_of(c - a, b - a) / den;
    if (t >= 0 && t <= 1 && u >= 0 && u <= 1) return 0;
  }
  const auto from = [](Vec2 p, Vec2 q, Vec2 r) {
    const Vec2 l = r - q;
    const double t = std::clamp(dot(p - q, l) / dot(l, l), 0.0, 1.0);
    return norm(p - q - l * t);
  };
  return std::min({from(a, c, d), from(b, c, d), from(c, a, b), from(d, a, b)});
}

/// Seen from above. Round bodies are discs.
double level_gap(const Body& a, Vec2 at_a, const Body& b, Vec2 at_b) {
  const bool round_a = a.shape.kind != Kind::Box, round_b = b.shape.kind != Kind::Box;
  const double r_a = a.shape.kind == Kind::Cylinder ? a.shape.size.x / 2 : 0;  // a capsule's is taken off in space
  const double r_b = round_b ? b.shape.size.x / 2 : 0;
  if (round_a && round_b) return std::max(0.0, norm(at_a - at_b) - r_a - r_b);
  if (round_a) return std::max(0.0, point_to_box(at_a, b, at_b) - r_a);
  if (round_b) return std::max(0.0, point_to_box(at_b, a, at_a) - r_b);
  if (point_to_box(at_a, b, at_b) == 0 || point_to_box(at_b, a, at_a) == 0) return 0;
  const auto p = corners(a, at_a), q = corners(b, at_b);
  double gap = 1e9;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) gap = std::min(gap, edge_to_edge(p[i], p[(i + 1) % 4], q[k], q[(k + 1) % 4]));
  return gap;
}

/// Between a body of the head that is carried to `at` and one that stands, which is a box or a cylinder.
double gap_mm(const Body& head, Vec3 at, const Body& stands) {
  const bool capsule = head.shape.kind == Kind::Capsule;
  const double r = capsule ? head.shape.size.x / 2 : 0;
  const double half = head.shape.size.z / 2 - r, low = at.z - half, high = at.z + half;
  const double bottom = stands.centre.z - stands.shape.size.z / 2, top = stands.centre.z + stands.shape.size.z / 2;
  const double up = std::max({0.0, low - top, bottom - high});
  return std::hypot(level_gap(head, flat(at), stands, flat(stands.centre)), up) - r;
}

/// Not more than gap_mm(): between the upright cylinders around both.
double at_least_mm(const Body& head, Vec3 at, const Body& stands) {
  const auto around = [](const Body& b) {
    return b.shape.kind == Kind::Box ? std::hypot(b.shape.size.x, b.shape.size.y) / 2 : b.shape.size.x / 2;
  };
  const double level = norm(flat(at) - flat(stands.centre)) - around(head) - around(stands);
  const double up = std::abs(at.z - stands.centre.z) - (head.shape.size.z + stands.shape.size.z) / 2;
  return std::max(level, up) - kRounding_mm;
}

/// The board and what is on it, as the recipe draws it, without turn or tilt.
std::vector<Body> drawn(const recipes::Recipe& recipe, const config::Machine& machine) {
  const Vec3 corner = config::find_frame(machine, recipe.board.frame)->origin;
  const double top = recipe.board.thickness;
  const auto box = [&](const std::string& name, Vec2 at, double z, Vec3 size, double rotation) {
    return Body{name, {Kind::Box, size}, corner + Vec3{at.x, at.y, z + size.z / 2}, rotation, false};
  };
  const Vec2 size = recipe.board.size;
  std::vector<Body> out{box("board", recipe.board.at + size * 0.5, 0, {size.x, size.y, top}, 0)};
  for (const recipes::Part& p : recipe.parts)
    out.push_back(box(p.name, recipe.board.at + p.at, p.fixture ? p.underside : top, p.size, p.rotation));
  return out;
}

/// The least gap over all cycles of a job, of pairs that are not to come near each other.
struct Watch {
  std::vector<Body> standing;
  std::vector<Body> only;  ///< nothing else is watched, where there are any
  std::set<std::string> needle_may_near{"board"};
  double least_mm = 1e9;
  std::string pair;
  std::size_t cycles = 0;

  void see(const config::Machine& m, const cycle::Snapshot& s) {
    if (s.block == 0) return;
    ++cycles;
    for (const Body& head : m.head) {
      const Vec3 at = head.centre + Vec3{s.target[m.x.value], s.target[m.y.value],
                                         s.target[m.z.value] - (head.on_lift ? s.target[m.u->value] : 0)};
      for (const Body& stands : standing) {
        if (at_least_mm(head, at, stands) > least_mm) continue;
        if (head.name == "needle" && needle_may_near.contains(stands.name)) continue;
        if (head.name == "probe_stylus" && stands.name == "board") continue;
        const double gap = gap_mm(head, at, stands);
        if (gap < least_mm)
          least_mm = gap,
          pair =
              fmt::format("{} and {} in cycle {}, feature {}, {:.1f} mm/s, tool at ({:.3f}, {:.3f}, {:.3f})", head.name,
                          stands.name, s.cycle, static_cast<int>(s.feature), s.path_speed, at.x, at.y, at.z);
      }
    }
  }
};

record::JobResult watched(Rig& rig, const recipes::Recipe& recipe, Watch& watch) {
  watch.standing = drawn(recipe, rig.machine());
  watch.standing.insert(watch.standing.end(), rig.machine().scene.begin(), rig.machine().scene.end());
  if (!watch.only.empty()) watch.standing = watch.only;
  for (const recipes::Feature& f : recipe.features)
    std::visit([&](const auto& each) { watch.needle_may_near.insert(each.on); }, f);
  rig.on_step = [&](run::Owner& owner) { watch.see(rig.machine(), owner.latest()); };
  return rig.run(recipe);
}

/// Targets are sent ahead by what each axis answers later than others: with unlike delays they are beside the path.
void as_shipped(config::Machine&) {}
void far_apart(config::Machine& m) {
  m.axes[m.x.value].response_delay_s = 0.003;
  m.axes[m.y.value].response_delay_s = 0.009;
  m.axes[m.z.value].response_delay_s = 0.0053;
}
struct Delays {
  const char* words;
  void (*change)(config::Machine&);
};
constexpr std::array kDelays{Delays{"as shipped", as_shipped}, Delays{"3, 9 and 5.3 ms", far_apart}};

constexpr const char* kTrue = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg";

/// Dots and beads between parts so high that the needle has to go over or round them.
recipes::Recipe random_recipe(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::string parts, features;
  for (int i = 0; i < 5; ++i)
    parts += fmt::format(
        "{}p{}: {{at: [{:.3f} mm, {:.3f} mm], size: [{:.3f} mm, {:.3f} mm, {:.3f} mm], rotation: {:.2f} deg}}",
        i == 0 ? "" : ", ", i, uniform(12, 68), uniform(8, 47), uniform(1, 8), uniform(1, 8), uniform(0.3, 9),
        uniform(-90, 90));
  for (int i = 0; i < 7; ++i) {
    const double x = uniform(6, 74), y = uniform(5, 50);
    if (i % 2 == 0)
      features += fmt::format("  - dot: {{name: d{}, material: glue, at: [{:.3f} mm, {:.3f} mm]}}\n", i, x, y);
    else
      features += fmt::format(
          "  - polyline: {{name: l{}, material: glue, corner_tolerance: 0.05 mm, points: [[{:.3f} mm, {:.3f} mm], "
          "[{:.3f} "
          "mm, {:.3f} mm], [{:.3f} mm, {:.3f} mm]]}}\n",
          i, x, y, std::clamp(x + uniform(-9, 9), 2.0, 78.0), y, std::clamp(x + uniform(-9, 9), 2.0, 78.0),
          std::clamp(y + uniform(-9, 9), 2.0, 53.0));
  }
  const std::string text = fmt::format(
      "version: 1\nrecipe: r\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, frame: pallet}}\n"
      "parts: {{{}}}\nmaterials:\n  glue: {{speed: {:.1f} mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: "
      "6 "
      "ms, dot_time: 30 ms, retract: {:.2f} mm, flow_follows_speed: true{}}}\nfeatures:\n{}",
      parts, uniform(10, 120), uniform(1, 4), uniform(0, 1) < 0.3 ? ", start_dwell: 50 ms" : "", features);
  const auto recipe = recipes::parse(text, "r.yaml");
  return recipe ? *recipe : recipes::Recipe{};
}

TEST(TimedClearance, the_judge_knows_its_closed_forms) {
  const Body box{"b", {Kind::Box, {4, 2, 6}}, {0, 0, 3}, 0, false},
      disc{"c", {Kind::Cylinder, {2, 2, 6}}, {0, 0, 3}, 0, false};
  const Body capsule{"k", {Kind::Capsule, {2, 2, 10}}, {}, 0, true}, head{"h", {Kind::Box, {2, 2, 2}}, {}, 0, false};
  EXPECT_NEAR(gap_mm(capsule, {5, 0, 5}, box), 2, 1e-12);   // 5 - 2 - 1
  EXPECT_NEAR(gap_mm(capsule, {0, 0, 14}, box), 3, 1e-12);  // its end at 9
  EXPECT_NEAR(gap_mm(capsule, {5, 5, 5}, box), 4, 1e-12);   // 3-4-5 from the edge, and its radius
  EXPECT_NEAR(gap_mm(capsule, {0, 6, 5}, disc), 4, 1e-12);
  EXPECT_NEAR(gap_mm(head, {6, 0, 10}, box), std::hypot(3, 3), 1e-12);
  Body turned = box;
  turned.rotation_rad = std::numbers::pi / 2;
  EXPECT_NEAR(gap_mm(capsule, {5, 0, 5}, turned), 3, 1e-9);  // 5 - 1 - 1
  for (const Body& body : {box, disc, turned})
    for (double x = -9; x < 9; x += 0.7)
      for (double z = -9; z < 15; z += 0.8) {
        EXPECT_LE(at_least_mm(head, {x, 1.5, z}, body), gap_mm(head, {x, 1.5, z}, body));
        EXPECT_LE(at_least_mm(capsule, {x, 1.5, z}, body), gap_mm(capsule, {x, 1.5, z}, body));
      }
  turned.rotation_rad = std::numbers::pi / 4;
  EXPECT_NEAR(gap_mm(head, {5, 0, 3}, turned), 4 - 3 / std::numbers::sqrt2, 1e-9);  // to its corner
}

TEST(TimedClearance, every_setpoint_of_random_jobs_keeps_the_clearance_as_it_is_sent) {
  const double kept_mm = 2;
  for (const auto& [delays, change] : kDelays) {
    int played = 0;
    double least_mm = 1e9;
    for (std::uint64_t seed = 1; seed < 200 && played < 12; ++seed) {
      const recipes::Recipe recipe = random_recipe(seed);
      if (recipe.features.empty()) continue;
      Rig rig({.placement = kTrue, .change = change});
      Watch watch;
      const record::JobResult r = watched(rig, recipe, watch);
      if (watch.cycles == 0) continue;  // refused: something stands on the way
      if (r.features_done != r.features_total) continue;
      ++played;
      EXPECT_GE(watch.least_mm, kept_mm - kRounding_mm)
          << "delays " << delays << ", seed " << seed << ": " << watch.pair << "; by the proof "
          << job::to_text(r.minimum_clearance.others);
      least_mm = std::min(least_mm, watch.least_mm);
    }
    EXPECT_EQ(played, 12) << delays;
    EXPECT_LT(least_mm, kept_mm + 0.1) << "they go as near as they may, " << delays;
  }
}

/// Two zones across the way to the first mark: the world holds nothing there and would not say so; the judge looks at
/// each cycle.
TEST(TimedClearance, every_setpoint_keeps_out_of_zones) {
  const config::Body door{"keep-out door", {Kind::Box, {20, 20, 40}}, {60, 76, -60}, 0.3, false, false, true};
  recipes::Recipe recipe = test::load_recipe("recipes/demo-board.yaml");
  recipe.keep_out = {{.name = "hose", .at = {-100, -50}, .size = {16, 16, 60}, .location = {}, .underside = 40}};
  const auto least_mm = [&](bool zones) {
    recipes::Recipe asked = recipe;
    if (!zones) asked.keep_out.clear();
    Rig rig({.placement = kTrue, .change = [&](config::Machine& m) {
               if (zones) m.keep_out = {door};
             }});
    Watch watch;
    watch.only = {door};
    for (const recipes::Part& z : recipe.keep_out) {
      const Vec3 corner = config::find_frame(rig.machine(), "pallet")->origin;
      watch.only.push_back(
          {"keep-out hose", {Kind::Box, z.size}, corner + Vec3{z.at.x, z.at.y, z.underside + z.size.z / 2}, 0, false});
    }
    const record::JobResult r = watched(rig, asked, watch);
    EXPECT_TRUE(r.errors.empty()) << to_text(r.errors.front());
    EXPECT_TRUE(r.collisions.empty()) << "a zone is no matter";
    EXPECT_EQ(r.features_done, r.features_total);
    return watch.least_mm;
  };
  EXPECT_LT(least_mm(false), 0) << "else this tells nothing";
  EXPECT_GE(least_mm(true), 2 - 0.05);
}

TEST(TimedClearance, every_setpoint_of_the_shipped_recipes_keeps_it) {
  for (const auto& [delays, change] : kDelays)
    for (const char* file : {"recipes/demo-board.yaml", "recipes/patterns.yaml"}) {
      const recipes::Recipe recipe = test::load_recipe(file);
      Rig rig({.placement = kTrue, .change = change});
      Watch watch;
      const record::JobResult r = watched(rig, recipe, watch);
      EXPECT_TRUE(r.errors.empty()) << file << ", delays " << delays << ": "
                                    << (r.errors.empty() ? "" : to_text(r.errors.front()));
      // Marks and touches are found within some hundredths of a mm of where they are.
      EXPECT_GE(watch.least_mm, 2 - 0.05) << file << ", delays " << delays << ": " << watch.pair;
      EXPECT_GT(watch.cycles, 10'000u);
    }
}

}  // namespace
}  // namespace gantry
