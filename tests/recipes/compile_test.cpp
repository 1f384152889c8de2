#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "core/units.hpp"
#include "recipes/bus_notes.hpp"
#include "recipes/job.hpp"
#include "recipes/seat.hpp"

namespace gantry::recipes {
namespace {

config::Machine dispenser() {
  auto m = config::load_machine("config/machines/dispenser.yaml");
  if (!m)
    for (const Error& e : m.error()) ADD_FAILURE() << to_text(e);
  return m ? *m : config::Machine{};
}
Recipe demo() { return *load("recipes/demo-board.yaml"); }

TEST(Compile, the_demo_board_is_a_job_on_the_reference_machine) {
  const auto job = compile(demo(), dispenser());
  if (!job)
    for (const Error& e : job.error()) ADD_FAILURE() << to_text(e);
  ASSERT_TRUE(job);
  ASSERT_EQ(job->blocks.size(), 4u + 3u + 1u + 1u);
  for (std::size_t i = 0; i < job->blocks.size(); ++i) EXPECT_EQ(job->blocks[i].number, i + 1);
  EXPECT_EQ(std::get<LookAtMark>(job->blocks[3].what).mark, 3u);
  EXPECT_EQ(std::get<Touch>(job->blocks[6].what).touch, 2u);
  EXPECT_EQ(std::get<Dispense>(job->blocks[7].what).features.size(), demo().features.size());
  EXPECT_TRUE(std::holds_alternative<Park>(job->blocks[8].what));
}

/// Zones are no matter: they may stand in the board, in parts and in each other, and be called as these are.
TEST(Compile, a_zone_to_keep_out_of_may_be_anywhere) {
  Recipe r = demo();
  config::Machine m = dispenser();
  r.keep_out = {{.name = "post", .at = {60, 40}, .size = {90, 60, 40}, .location = {}},
                {.name = r.parts[0].name, .at = r.parts[0].at, .size = {5, 5, 5}, .location = {}}};
  m.keep_out = {
      {"keep-out door", {config::Shape::Kind::Box, {300, 300, 300}}, {240, 190, -132}, 0, false, false, true}};
  const auto job = compile(r, m);
  EXPECT_TRUE(job) << to_text(job.error().front());
  const auto all = zones(r, m);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].name, "keep-out post");
  EXPECT_TRUE(all[0].keep_out);
  const Vec3 origin = m.frames[0].origin;
  EXPECT_EQ(all[0].centre, origin + (Vec3{60 + r.board.at.x, 40 + r.board.at.y, 20}));
}

/// What the demo must allow: +-2 mm and +-1.5 deg, its corners included.
std::vector<WorkOffset> placements() {
  std::vector<WorkOffset> all;
  for (const double x : {-2.0, 0.0, 2.0})
    for (const double y : {-2.0, 0.0, 2.0})
      for (const double turn : {-1.5, 0.0, 1.5}) all.push_back({{x, y}, units::rad(turn)});
  return all;
}

TEST(DemoBoard, every_point_is_in_reach_wherever_the_board_lies) {
  const auto m = dispenser();
  const Recipe r = demo();
  const auto inside = [&](const AxisVec& q, const std::string& what) {
    for (const config::Axis& a : m.axes) {
      EXPECT_GE(q[a.id.value], a.p_min) << what << ' ' << a.name;
      EXPECT_LE(q[a.id.value], a.p_max) << what << ' ' << a.name;
    }
  };
  for (const WorkOffset& offset : placements())
    for (const double height : {-0.5, 0.5}) {
      const Surface surface{height, {}};
      const auto tool = [&](const char* name, Vec2 at, double up) {
        inside(tool_at(m, *config::find_tool(m, name), to_machine(r, m, offset, surface, at, up), 0), name);
      };
      for (const MarkDef& mark : r.marks) tool("camera", mark.at, 0);
      for (const TouchPoint& t : r.touches) tool("probe", t.at, -2), tool("probe", t.at, 5);
      for (const Feature& f : r.features) {
        if (const auto* d = std::get_if<Dot>(&f)) tool("needle", d->at, 0.2);
        if (const auto* b = std::get_if<Bead>(&f))
          for (const Vec3 p : b->points) tool("needle", flat(p), 0.4), tool("needle", flat(p), 5);
      }
    }
}

TEST(DemoBoard, marks_stay_in_the_picture_wherever_the_board_lies) {
  const auto m = dispenser();
  const Recipe r = demo();
  for (const WorkOffset& offset : placements())
    for (const MarkDef& mark : r.marks) {
      const Vec3 d = to_machine(r, m, offset, {}, mark.at, 0) - to_machine(r, m, {}, {}, mark.at, 0);
      EXPECT_LE(std::hypot(d.x, d.y), m.camera.search_mm) << mark.name;
      EXPECT_LT(std::abs(d.x) + mark.diameter, 0.5 * m.camera.width_px * m.camera.mm_per_px) << mark.name;
      EXPECT_LT(std::abs(d.y) + mark.diameter, 0.5 * m.camera.height_px * m.camera.mm_per_px) << mark.name;
      EXPECT_LE(norm(offset.shift), r.mark_rules.max_shift_mm);
      EXPECT_LE(std::abs(offset.rotation), r.mark_rules.max_rotation_rad);
    }
}

/// Horizontal distance from a point to an upright box, 0 inside.
double apart(Vec2 p, const config::Body& box) {
  const Vec2 q = rotated(p - Vec2{box.centre.x, box.centre.y}, -box.rotation_rad);
  return std::hypot(std::max(0.0, std::abs(q.x) - box.shape.size.x / 2),
                    std::max(0.0, std::abs(q.y) - box.shape.size.y / 2));
}
double top(const config::Body& b) { return b.centre.z + b.shape.size.z / 2; }

/// Brute force over the postures of the job: every body of the head against everything that stands higher than its
/// underside, by horizontal distance. `slack` is kept over and above.
void expect_free(const config::Machine& m, const std::vector<config::Body>& standing, const AxisVec& q, double kept,
                 const std::string& what) {
  for (const config::Body& h : m.head) {
    const Vec2 at{h.centre.x + q[m.x.value], h.centre.y + q[m.y.value]};
    const double z = q[m.z.value] - (h.on_lift ? q[m.u->value] : 0);
    const double under = h.centre.z - h.shape.size.z / 2 + z;
    const double radius =
        h.shape.kind == config::Shape::Kind::Box ? std::hypot(h.shape.size.x, h.shape.size.y) / 2 : h.shape.size.x / 2;
    for (const config::Body& s : standing) {
      if (s.name == "board" || top(s) + kept <= under) continue;
      EXPECT_GE(apart(at, s), radius + kept) << what << ": " << h.name << " and " << s.name;
    }
  }
}

TEST(DemoBoard, no_posture_of_the_job_meets_a_part_or_a_clamp) {
  const auto m = dispenser();
  const Recipe r = demo();
  for (const WorkOffset& offset : placements()) {
    auto standing = bodies(r, m, offset, {});
    standing.insert(standing.end(), m.scene.begin(), m.scene.end());
    const auto posture = [&](const char* name, Vec2 at, double up, const std::string& what) {
      expect_free(m, standing, tool_at(m, *config::find_tool(m, name), to_machine(r, m, offset, {}, at, up), 0),
                  m.clearance_mm, what);
    };
    for (const MarkDef& mark : r.marks) posture("camera", mark.at, 0, mark.name);
    for (const TouchPoint& t : r.touches) posture("probe", t.at, 0, t.name);
    for (const Feature& f : r.features) {
      if (const auto* d = std::get_if<Dot>(&f)) posture("needle", d->at, 0.2, d->id);
      if (const auto* b = std::get_if<Bead>(&f))
        for (std::size_t i = 0; i + 1 < b->points.size(); ++i)
          for (double u = 0; u <= 1; u += 0.05)
            posture("needle", flat(b->points[i] + (b->points[i + 1] - b->points[i]) * u), 0.4, b->id);
    }
  }
}

Vec3 raised(Vec2 at, double z) { return {at.x, at.y, z}; }
const Dot& first_dot(const Recipe& r) {
  return std::get<Dot>(*std::find_if(r.features.begin(), r.features.end(),
                                     [](const Feature& f) { return std::holds_alternative<Dot>(f); }));
}

Part& clamp(Recipe& r) { return *std::ranges::find_if(r.parts, &Part::fixture); }

struct Wrong {
  const char* name;
  void (*change)(Recipe&, config::Machine&);
  Fault fault;
  const char *about, *says;
};
class NotFeasible : public testing::TestWithParam<Wrong> {};

TEST_P(NotFeasible, is_told_with_the_place_in_the_recipe) {
  const Wrong& w = GetParam();
  Recipe r = demo();
  config::Machine m = dispenser();
  w.change(r, m);
  const auto job = compile(r, m);
  ASSERT_FALSE(job);
  EXPECT_EQ(job.error()[0].fault, w.fault) << to_text(job.error()[0]);
  EXPECT_NE(job.error()[0].message.find(w.says), std::string::npos) << to_text(job.error()[0]);
  EXPECT_NE(job.error()[0].message.find(w.about), std::string::npos) << to_text(job.error()[0]);
  EXPECT_EQ(job.error()[0].where.rfind("recipes/demo-board.yaml:", 0), 0u) << job.error()[0].where;
}

INSTANTIATE_TEST_SUITE_P(
    Compile, NotFeasible,
    testing::Values(
        Wrong{"frame", [](Recipe& r, config::Machine&) { r.board.frame = "palet"; }, Fault::UnknownReference, "palet",
              "pallet"},
        Wrong{"speed", [](Recipe& r, config::Machine&) { r.materials[1].speed = 600; }, Fault::SpeedNotReachable,
              "sealant", "500 mm/s"},
        Wrong{"needle_x", [](Recipe& r, config::Machine& m) { r.board.at.x = 215, m.scene.clear(); }, Fault::OutOfReach,
              "axis X", "500"},
        Wrong{"camera_x", [](Recipe& r, config::Machine& m) { r.board.at.x = -130, m.scene.clear(); },
              Fault::OutOfReach, "front_left", "camera"},
        Wrong{"too_low", [](Recipe&, config::Machine& m) { m.frames[0].origin.z -= 30, m.scene.clear(); }, Fault::OutOfReach, "axis Z",
              "probe"},
        Wrong{"margin",
              [](Recipe& r, config::Machine& m) {
                m.scene.clear();
                r.board.at.x = 193;
                r.mark_rules.max_shift_mm = 6;
              },
              Fault::OutOfReach, "axis X", "off by up to"},
        Wrong{"mark", [](Recipe& r, config::Machine&) { r.marks[0].diameter = 16, r.marks[0].at = {9, 9}, r.board.clamp_margin = 0; },
              Fault::OutOfReach, "front_left", "camera sees"},
        Wrong{"window", [](Recipe& r, config::Machine&) { r.touch_rules.window_mm = 6; }, Fault::OutOfReach,
              "front_left", "window"},
        Wrong{"part_named_as_a_body_of_the_machine",
              [](Recipe& r, config::Machine&) { r.parts[0].name = "post"; }, Fault::DuplicateKey, "'post'",
              "choose another name"},
        Wrong{"part_named_board", [](Recipe& r, config::Machine&) { r.parts[0].name = "board"; }, Fault::DuplicateKey,
              "'board'", "choose another name"},
        Wrong{"zone_named_as_one_of_the_machine",
              [](Recipe& r, config::Machine& m) {
                r.keep_out = {{.name = "door", .at = {150, 9}, .size = {9, 9, 9}, .location = {12, 3}}};
                m.keep_out = {{"keep-out door", {config::Shape::Kind::Box, {9, 9, 9}}, {400, 300, -20}}};
              },
              Fault::DuplicateKey, "'door'", "choose another name"},
        Wrong{"no_valve",
              [](Recipe&, config::Machine& m) { m.outputs[static_cast<std::size_t>(config::Output::Valve)].reset(); },
              Fault::UnknownReference, "'valve'", "nothing is dispensed"},
        Wrong{"no_trigger",
              [](Recipe&, config::Machine& m) {
                m.outputs[static_cast<std::size_t>(config::Output::CameraTrigger)].reset();
              },
              Fault::UnknownReference, "'camera_trigger'", "sees no mark"},
        Wrong{"no_camera", [](Recipe&, config::Machine& m) { m.camera = {}; }, Fault::UnknownReference, "'camera'",
              "no mark is seen"},
        Wrong{"no_probe", [](Recipe&, config::Machine& m) { m.probe.speed_mm_s = 0; }, Fault::UnknownReference,
              "'probe'", "no height is touched"},
        Wrong{"no_needle", [](Recipe&, config::Machine& m) { m.tools.erase(m.tools.begin()); }, Fault::UnknownReference,
              "'needle'", "nothing is dispensed"},
        Wrong{"larger_than_its_seat",
              [](Recipe& r, config::Machine&) {
                r.board.size = {240, 80};
              },
              Fault::OutOfRange, "240 x 80 mm", "does not fit on 'pallet_plate'"},
        Wrong{"on_nothing", [](Recipe& r, config::Machine&) { r.board.at.x = 200; }, Fault::OutOfRange,
              "nothing carries the board: it lies from (380, 150) to (500, 230) mm",
              "'pallet_plate' ends there, from (130, 100) to (350, 280) mm"},
        Wrong{"over_nothing", [](Recipe&, config::Machine& m) { m.frames[0].origin.z += 40; }, Fault::OutOfRange,
              "nothing carries the board", "underside at z -82 mm"},
        Wrong{"in_a_rail", [](Recipe& r, config::Machine&) { r.board.at.y = -12; }, Fault::Inconsistent,
              "the board lies in 'clamp_rail'", "correct the board's placement 'at'"},
        Wrong{"in_a_post", [](Recipe& r, config::Machine&) { r.board.at = {-10, 28}; }, Fault::Inconsistent,
              "the board lies in 'post'", "z -122 to -62 mm"},
        Wrong{"in_its_plate", [](Recipe&, config::Machine& m) { m.frames[0].origin.z -= 8; }, Fault::Inconsistent,
              "the board lies in 'pallet_plate'", "the origin of frame 'pallet' in the machine file"},
        Wrong{"a_mark_over_the_edge", [](Recipe& r, config::Machine&) { r.marks[0].at.x = 0.7, r.board.clamp_margin = 0; }, Fault::OutOfRange,
              "mark 'front_left' of 1.5 mm", "the board's edge, which is 0.7 mm from its centre"},
        Wrong{"a_fixture_in_the_board", [](Recipe& r, config::Machine&) { clamp(r).at = {30, 12}, clamp(r).underside = 5, clamp(r).size.z = 2; },
              Fault::Inconsistent, "fixture 'front_clamp' is inside the board", "it ends 7 mm over"},
        Wrong{"a_fixture_in_a_part", [](Recipe& r, config::Machine&) { clamp(r).at = {24, 46}, clamp(r).underside = 25.9; },
              Fault::Inconsistent, "fixture 'front_clamp'", "in part 'capacitor', from z 25.9 to 47.9 mm"},
        Wrong{"purge_on_a_dot",
              [](Recipe& r, config::Machine&) {
                r.purge = Purge{.material = "adhesive", .frame = "", .at = raised(first_dot(r).at + Vec2{0.9, 0}, 0), .shots = 1, .location = {}, .at_location = first_dot(r).location};
              },
              Fault::Inconsistent, "the purge shoots onto 'spreader[0][0]'", "put its 'at' beside the work"},
        Wrong{"purge_of_a_frame_on_a_dot",
              [](Recipe& r, config::Machine& m) {
                m.frames.push_back({"cup", m.frames[0].origin + raised(first_dot(r).at, 12.2)});
                r.purge = Purge{.material = "adhesive", .frame = "cup", .at = {}, .shots = 1, .location = {}, .at_location = first_dot(r).location};
              },
              Fault::Inconsistent, "the purge shoots onto 'spreader[0][0]'", "put its 'at' beside the work"},
        Wrong{"feature_in_the_margin", [](Recipe& r, config::Machine&) { r.board.clamp_margin = 11.5; },
              Fault::OutOfRange, "'clamp_margin'", "mark 'front_left'"},
        Wrong{"dot_in_a_part",
              [](Recipe& r, config::Machine&) {
                r.parts[0].at = {36, 34};
              },
              Fault::Inconsistent, "dot 'spreader[0][0]'", "part 'capacitor'"},
        Wrong{"bead_through_a_part",
              [](Recipe& r, config::Machine&) {
                r.parts[0].at = {70, 11};
              },
              Fault::Inconsistent, "bead 'front_seam'", "`on: capacitor`"},
        Wrong{"open_lead", [](Recipe& r, config::Machine&) { r.materials[0].valve_open_lead = 0.5; }, Fault::NoSolution,
              "adhesive", "before the needle is on the last stretch to 'spreader[0][0]'"},
        Wrong{"open_lead_without_a_descent",
              [](Recipe& r, config::Machine&) {
                r.materials[0].retract = 0;
                r.materials[0].settle_time = 0.005;
              },
              Fault::NoSolution, "write 5 ms or less", "'settle_time' or 'retract'"},
        Wrong{"close_lead", [](Recipe& r, config::Machine&) { r.materials[0].valve_close_lead = 0.068; },
              Fault::Inconsistent, "adhesive", "'valve_close_lead' of 68 ms closes the valve before it has been open"}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(Compile, a_feature_may_lie_on_the_part_that_it_names) {
  Recipe r = demo();
  r.parts[0].at = {70, 11};
  std::get<Bead>(r.features.back()).on = "capacitor";
  EXPECT_TRUE(compile(r, dispenser()));
}

/// A touch has no `on`: what it touches is the board.
TEST(Compile, a_touch_on_a_part_is_moved_and_not_told_to_lie_on_it) {
  Recipe r = demo();
  r.parts[0].at = r.touches[0].at;
  const auto job = compile(r, dispenser());
  ASSERT_FALSE(job);
  std::string all;
  for (const Error& e : job.error()) all += e.message + "\n";
  EXPECT_NE(all.find("touch '" + r.touches[0].name + "' is on part 'capacitor'"), std::string::npos) << all;
  EXPECT_NE(all.find("move it"), std::string::npos) << all;
  EXPECT_EQ(all.find("`on:"), std::string::npos) << all;
}

TEST(Compile, frame_material_and_speed_are_told_at_once) {
  std::string text = *config::read_text_file("recipes/demo-board.yaml");
  const auto change = [&](const std::string& from, const std::string& to) {
    const auto at = text.rfind(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  change("frame: pallet", "frame: palett");
  change("material: sealant", "material: selant");
  change("speed: 20 mm/s", "speed: 900 mm/s");
  const std::string file = testing::TempDir() + "/gantry-three-mistakes.yaml";
  std::ofstream(file) << text;
  const auto loaded = load_for(file, dispenser());
  std::remove(file.c_str());
  ASSERT_FALSE(loaded);
  std::string all;
  for (const Error& e : loaded.error()) all += to_text(e) + "\n";
  EXPECT_EQ(loaded.error().size(), 3u) << all;
  for (const char* each : {"palett", "selant", "900 mm/s"}) EXPECT_NE(all.find(each), std::string::npos) << all;
}

TEST(Compile, an_unknown_frame_is_told_where_it_stands) {
  Recipe r = demo();
  r.board.frame = "palet";
  const auto job = compile(r, dispenser());
  ASSERT_FALSE(job);
  const std::string text = *config::read_text_file("recipes/demo-board.yaml");
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(text.find("frame: pallet")), '\n');
  EXPECT_EQ(job.error()[0].where, "recipes/demo-board.yaml:" + std::to_string(line) + ":10");
}

TEST(Compile, notes_tell_what_a_bus_loss_and_a_lost_program_cost_at_the_recipes_speeds) {
  const auto told = bus_notes(demo(), dispenser());
  ASSERT_EQ(told.size(), 4u);
  EXPECT_NE(told[0].find("adhesive: a bus that is lost on a bead costs 1.5 mm"), std::string::npos) << told[0];
  EXPECT_NE(told[1].find("adhesive: when the program dies on a bead, X, Z, C, U are left to their stations"),
            std::string::npos)
      << told[1];
  EXPECT_NE(told[1].find("1.5 mm at 15 mm/s until a watchdog of 100 ms"), std::string::npos) << told[1];
  EXPECT_NE(told[2].find("sealant: a bus that is lost on a bead costs 2.0 mm"), std::string::npos) << told[2];
  EXPECT_NE(told[3].find("2.0 mm at 20 mm/s until a watchdog of 100 ms"), std::string::npos) << told[3];
}

TEST(Compile, notes_tell_the_tolerances_of_each_material) {
  const auto told = notes(demo(), dispenser());
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0], "adhesive: a deposit is good within 0.1 mm of its place, 0.1 mm of its gap and 5 % of its speed");
}

TEST(Compile, notes_tell_fills_that_leave_a_place_bare) {
  const auto of_fills = [](const std::string& fills) {
    const auto r = parse(
        "version: 1\nrecipe: r\nplacement: fixture\nboard: {size: [90 mm, 60 mm], thickness: 8 mm, frame: "
        "pallet}\nmaterials:\n  a: {speed: 20 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, "
        "valve_close_lead: 6 ms, dot_time: 60 ms, retract: 3 mm}\nfeatures:\n" +
            fills,
        "r.yaml");
    EXPECT_TRUE(r) << to_text(r.error()[0]);
    auto told = r ? notes(*r, dispenser()) : std::vector<std::string>{};
    std::erase_if(told, [](const std::string& note) { return note.find("fill '") != 0; });
    return told;
  };
  // An arm of 10 x 1.5 mm at a square of 10 mm: 13 % of 115 square millimetres.
  const auto arm = of_fills(
      "  - fill: {name: l, material: a, spacing: 2 mm, points: [[20 mm, 20 mm], [40 mm, 20 mm], [40 mm, "
      "21.5 mm], [30 mm, 21.5 mm], [30 mm, 30 mm], [20 mm, 30 mm]]}\n");
  ASSERT_EQ(arm.size(), 1u);
  EXPECT_EQ(arm[0].find("fill 'l' (line 8): 13 % of its area is not covered, up to 10.9 mm from the nearest line, at "
                        "(40, 20.25) mm"),
            0u)
      << arm[0];
  // What is left over beside strips: no note; nearly half of the area: one.
  EXPECT_TRUE(
      of_fills("  - fill: {name: s, material: a, spacing: 2 mm, at: [20 mm, 20 mm], size: [20 mm, 7 mm]}\n").empty());
  EXPECT_EQ(
      of_fills("  - fill: {name: s, material: a, spacing: 2 mm, at: [20 mm, 20 mm], size: [20 mm, 3.9 mm]}\n").size(),
      1u);
}

// A job that is taken up again looks and touches anew, where by then material lies.
TEST(Compile, notes_tell_marks_and_touches_that_are_dispensed_over) {
  Recipe r = demo();
  const Vec2 dot = std::get<Dot>(r.features.front()).at;
  r.marks[1].at = {dot.x + r.marks[1].diameter / 2 - 0.01, dot.y};
  auto told = notes(r, dispenser());
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].find("mark 'front_right' (line"), 0u) << told[0];
  EXPECT_NE(told[0].find("is covered by 'spreader[0][0]'"), std::string::npos) << told[0];
  r.marks[1].at.x += 0.02;
  EXPECT_EQ(notes(r, dispenser()).size(), 2u);
  const auto bead = std::ranges::find_if(r.features, [](const Feature& f) { return std::holds_alternative<Bead>(f); });
  const auto& points = std::get<Bead>(*bead).points;
  r.touches[0].at = (flat(points[0]) + flat(points[1])) * 0.5;
  told = notes(r, dispenser());
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].find(fmt::format("touch '{}' (line", r.touches[0].name)), 0u) << told[0];
  EXPECT_NE(told[0].find(fmt::format("lies on '{}'", id_of(*bead))), std::string::npos) << told[0];
}

TEST(Compile, notes_tell_marks_and_touches_that_may_disagree_by_more_than_a_deposit_may_be_off) {
  Recipe r = demo();
  r.mark_rules.max_residual_mm = 0.2;
  r.materials[1].tolerance_mm = 0.15;
  auto told = notes(r, dispenser());
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].find("`mark_rules.max_residual` of 0.2 mm is more than `tolerance` of 'adhesive', 0.1 mm"), 0u)
      << told[0];
  r.mark_rules.max_residual_mm = 0.1;
  r.touches.push_back(r.touches[0]);
  r.materials[1].gap_tolerance_mm = 0.05;
  told = notes(r, dispenser());
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].find("`touch_rules.max_residual` of 0.1 mm is more than `gap_tolerance` of 'sealant', 0.05 mm"), 0u)
      << told[0];
  r.touches.pop_back();
  EXPECT_EQ(notes(r, dispenser()).size(), 2u) << "three touches always agree";
}

TEST(Compile, a_board_is_carried_by_what_is_in_the_scene_where_anything_is) {
  Recipe r = demo();
  config::Machine m = dispenser();
  r.board.at = {0, -6.95};
  EXPECT_TRUE(compile(r, m)) << "it touches the rail's side";
  r.board.at = {0, 0};
  m.frames[0].origin.z += 0.9;
  EXPECT_TRUE(compile(r, m)) << "a plate that is a little lower";
  m.scene.clear(), m.frames[0].origin.z += 5;
  EXPECT_TRUE(compile(r, m)) << "nothing is known of what carries it";
}

TEST(Compile, a_clamp_may_reach_onto_the_board_hold_its_side_and_stand_on_a_part) {
  const auto told = [](Vec2 at, double underside, double height) {
    Recipe r = demo();
    clamp(r).at = at, clamp(r).underside = underside, clamp(r).size.z = height;
    config::Mistakes mistakes(r.file);
    check_seat(r, dispenser(), mistakes);
    return mistakes.none() ? std::string() : to_text(mistakes.errors().front());
  };
  EXPECT_EQ(told({30, 0}, 0, 22), "");
  EXPECT_EQ(told({30, 0}, 0, 8), "") << "it grips the board's side";
  EXPECT_EQ(told({24, 46}, 26, 5), "") << "it stands on the capacitor";
}

TEST(Compile, notes_tell_that_marks_have_no_light) {
  config::Machine m = dispenser();
  m.outputs[static_cast<std::size_t>(config::Output::CameraLight)].reset();
  Recipe r = demo();
  EXPECT_NE(notes(r, m).front().find("no output 'camera_light'"), std::string::npos) << notes(r, m).front();
  r.marks.clear();
  for (const std::string& note : notes(r, m)) EXPECT_EQ(note.find("camera_light"), std::string::npos) << note;
}

TEST(Compile, notes_tell_a_valve_lead_that_the_virtual_valve_does_not_have) {
  Recipe r = demo();
  r.materials[0].valve_open_lead = 0.030;
  r.materials[1].valve_close_lead = 0.002;
  const auto told = notes(r, dispenser());
  ASSERT_EQ(told.size(), 4u);
  EXPECT_NE(told[1].find("adhesive: valve_open_lead is 30 ms, but the virtual valve opens 8 ms after"),
            std::string::npos)
      << told[1];
  EXPECT_NE(told[1].find("22 ms early, 0.33 mm"), std::string::npos) << told[1];
  EXPECT_NE(told[3].find("sealant: valve_close_lead is 2 ms"), std::string::npos) << told[3];
  EXPECT_NE(told[3].find("4 ms late, 0.08 mm"), std::string::npos) << told[3];
}

TEST(Compile, an_array_out_of_reach_is_told_once) {
  Recipe r = demo();
  for (Feature& f : r.features)
    if (auto* dot = std::get_if<Dot>(&f); dot != nullptr && dot->id.starts_with("spreader"))
      dot->at.x += 300, dot->off_board = true;
  const auto job = compile(r, dispenser());
  ASSERT_FALSE(job);
  EXPECT_EQ(std::count_if(job.error().begin(), job.error().end(),
                          [](const Error& e) { return e.message.find("spreader") != std::string::npos; }),
            1);
}

}  // namespace
}  // namespace gantry::recipes
