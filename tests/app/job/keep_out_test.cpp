// Zones of the machine file and of a recipe: nothing of the head enters them, in whatever it does. The judges are
// closed forms (tests/motion/plan/prism_distance.hpp), and the same bodies as matter, of which boards_test shows that
// they are kept clear of.
#include <gtest/gtest.h>
#include <regex>

#include "app/job/block_plan.hpp"
#include "app/job/jog.hpp"
#include "app/job/park.hpp"
#include "app/job/prove_homing.hpp"
#include "app/job/rise.hpp"
#include "app/job/wherever.hpp"
#include "motion/path/chords.hpp"
#include "tests/app/job/random_board.hpp"
#include "tests/app/job/reference.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::job {
namespace {

using config::Body;

Body zone(const char* name, Vec3 centre, Vec3 size) {
  Body body{config::zone_name(name), {config::Shape::Kind::Box, size}, centre};
  body.keep_out = true;
  return body;
}

/// The reference machine with a board of dots and touches.
struct KeepOut : testing::Test {
  config::Machine machine = test::reference();
  recipes::Recipe recipe = test::dots(
      1, 2, "touches:\n  t0: {at: [10 mm, 10 mm]}\n  t1: {at: [70 mm, 10 mm]}\n  t2: {at: [40 mm, 45 mm]}\n");
  AxisVec park = test::parked(machine);

  AxisVec at(double x, double y, double z) const {
    AxisVec q = park;
    q[machine.x.value] = x, q[machine.y.value] = y, q[machine.z.value] = z;
    return q;
  }
  Vec3 over_board(Vec2 at, double height_mm) const {
    return recipes::to_machine(recipe, machine, {}, {}, at, height_mm);
  }
  /// By the closed form: the least distance of any body of the head from a zone, over all motions of a block.
  double least_mm(const ProvenBlock& block, const Body& stands) const {
    double least = 1e9;
    for (const motion::Segment& segment : block.segments()) {
      const auto points = motion::chords(std::span(&segment, 1));
      for (std::size_t i = 0; i + 1 < points.size(); ++i)
        for (Body body : machine.head) {
          const auto carried = [&](const AxisVec& q) {
            return Vec3{q[machine.x.value], q[machine.y.value],
                        q[machine.z.value] - (body.on_lift ? q[machine.u->value] : 0)};
          };
          const Vec3 from = carried(points[i]), to = carried(points[i + 1]);
          body.centre = body.centre + from;
          least = std::min(least, test::swept_distance(body, to - from, stands));
        }
    }
    return least;
  }
};

TEST_F(KeepOut, work_in_a_zone_is_refused_with_the_body_the_zone_and_the_line) {
  const Vec3 middle = over_board({10, 10}, 5);
  const auto refused = [&](const char* what) {
    const auto block = BlockPlanner(machine, recipe).dispense(1, park, {0});
    ASSERT_FALSE(block) << what;
    EXPECT_EQ(block.error().fault, Fault::Collision);
    EXPECT_NE(block.error().message.find("needle"), std::string::npos) << block.error().message;
    EXPECT_NE(block.error().message.find("keep-out glue_pot"), std::string::npos) << block.error().message;
    EXPECT_EQ(block.error().where.rfind("dots.yaml:", 0), 0u) << block.error().where;
    EXPECT_TRUE(BlockPlanner(machine, recipe).dispense(1, park, {1})) << what << ": the other dot lies outside";
  };
  machine.keep_out = {zone("glue_pot", middle, {6, 6, 4})};
  refused("of the machine");
  machine.keep_out.clear();
  recipe.keep_out = {
      {.name = "glue_pot", .at = {10, 10}, .size = {6, 6, 4}, .location = {}, .underside = recipe.board.thickness + 3}};
  refused("of the recipe");
}

TEST_F(KeepOut, the_way_to_a_feature_leads_around_a_zone_at_the_clearance) {
  const AxisVec above = at(over_board({10, 10}, 0).x, over_board({10, 10}, 0).y, machine.safe_z_mm);
  const auto free = BlockPlanner(machine, recipe).dispense(1, park, {0});
  ASSERT_TRUE(free);
  // Across the straight way of the needle, from the floor to above the syringe.
  machine.keep_out = {zone("curtain", {(park[0] + above[0]) / 2, (park[1] + above[1]) / 2, -50}, {4, 30, 260})};
  EXPECT_LT(least_mm(*free, machine.keep_out[0]), 0) << "that way leads through it";
  const auto around = BlockPlanner(machine, recipe).dispense(1, park, {0});
  ASSERT_TRUE(around) << to_text(around.error());
  EXPECT_GE(least_mm(*around, machine.keep_out[0]), machine.clearance_mm - 1e-6);
  EXPECT_GT(around->duration_s(), free->duration_s());
}

/// Beside a touch the clearance decides, and the same for a zone of the machine and of the recipe.
TEST_F(KeepOut, a_touch_beside_a_zone_is_free_from_the_clearance_on) {
  const double stylus_radius = 1.5;
  for (const bool of_machine : {true, false})
    for (const double off : {-1e-3, -1e-6, 1e-6, 1e-3}) {
      const Vec2 middle{70 + stylus_radius + 2 + machine.clearance_mm + off, 10};
      machine.keep_out.clear(), recipe.keep_out.clear();
      if (of_machine)
        machine.keep_out = {zone("z", over_board(middle, 0), {4, 4, 1})};
      else
        recipe.keep_out = {{.name = "z", .at = middle, .size = {4, 4, 1}, .location = {}, .underside = 1}};
      EXPECT_EQ(BlockPlanner(machine, recipe).touch(1, park, 1).has_value(), off > 0) << off << ' ' << of_machine;
    }
}

TEST_F(KeepOut, homing_jog_and_park_keep_out_too) {
  const AxisVec low = at(300, 300, -30);
  const auto homes = [&] { return prove_homing(machine, Surroundings(machine), low); };
  const auto jogs = [&](double by_mm) {
    const auto jog = read_jog(machine, {.by = {{"X", std::to_string(by_mm) + " mm"}}, .speed = "50 mm/s"});
    return plan_jog(machine, Surroundings(machine), low, *jog);
  };
  const auto parks = [&] { return plan_park(machine, Surroundings(machine), low); };
  ASSERT_TRUE(homes() && jogs(-100) && parks());
  // Beside the carriage, 70 mm to the left of the head's origin: nothing may go there, at no height.
  machine.keep_out = {zone("door", {200, 300, 0}, {20, 200, 600})};
  for (const auto& [what, error] :
       {std::pair{"home", homes()},
        std::pair{"jog", jogs(-100) ? Result<void>{} : tl::unexpected(jogs(-100).error())}}) {
    ASSERT_FALSE(error) << what;
    EXPECT_EQ(error.error().fault, Fault::Collision);
    EXPECT_NE(error.error().message.find("keep-out door"), std::string::npos) << error.error().message;
  }
  EXPECT_TRUE(jogs(10)) << "away from it";
  const auto parked = parks();
  ASSERT_TRUE(parked) << to_text(parked.error());
  EXPECT_GE(least_mm(*parked, machine.keep_out[0]), machine.clearance_mm - 1e-6) << "round it";
  machine.keep_out = {zone("wall", {200, 200, 0}, {20, 900, 600})};
  const auto shut = parks();
  ASSERT_FALSE(shut);
  EXPECT_NE(shut.error().message.find("keep-out wall"), std::string::npos) << shut.error().message;
}

/// Somebody has pushed the head into a zone by hand, or it was drawn where the head stands: a zone is no matter.
TEST_F(KeepOut, a_head_that_stands_deep_in_a_zone_is_led_out_and_no_deeper) {
  const AxisVec now = at(300, 200, -30);
  const auto jog = [&](const char* axis, double by_mm) {
    const auto read = read_jog(machine, {.by = {{axis, std::to_string(by_mm) + " mm"}}, .speed = "50 mm/s"});
    return plan_jog(machine, Surroundings(machine), now, *read).has_value();
  };
  // Needle, probe and camera are in it; for the needle the nearest way out is up.
  machine.keep_out = {zone("pit", {300, 200, -60}, {200, 200, 120})};
  const Surroundings around(machine);
  const Body needle =
      *std::find_if(machine.head.begin(), machine.head.end(), [](auto& b) { return b.name == "needle"; });
  ASSERT_LT(needle.centre.z + now[machine.z.value] + needle.shape.size.z / 2, 0) << "the needle is wholly in it";
  EXPECT_TRUE(jog("Z", 20)) << "out of it, upwards";
  EXPECT_FALSE(jog("Z", -5)) << "deeper";
  const auto rise = plan_rise(machine, around, 1, now);
  EXPECT_TRUE(rise.has_value()) << to_text(rise.error());
}

TEST_F(KeepOut, what_may_reach_a_zone_where_the_board_may_lie_is_named_ahead) {
  recipe = test::dots(1, 2,
                      "marks:\n  a: {at: [5 mm, 5 mm], diameter: 1.5 mm}\n  b: {at: [75 mm, 50 mm], diameter: 1.5 "
                      "mm}\nmark_rules: {max_shift: 3 mm, max_rotation: 0.1 deg}\n");
  const auto named = [&] {
    const auto job = recipes::compile(recipe, machine);
    EXPECT_TRUE(job) << (job ? "" : to_text(job.error().front()));
    std::vector<std::string> names;
    const auto placed = only_when_placed(machine, recipe, *job);
    for (const OnlyWhenPlaced& each : *placed) names.push_back(each.feature);
    return names;
  };
  EXPECT_TRUE(named().empty());
  // Needle of radius 0.8 mm at x 10, face of the zone at 10 - 0.8 - 2 - 1: nominally 1 mm more than the clearance.
  machine.keep_out = {zone("hose", over_board({10 - 0.8 - 2 - 1 - 2, 10}, 5), {4, 4, 6})};
  EXPECT_EQ(named(), std::vector<std::string>{"d[0][0]"});
  machine.keep_out.clear();
  recipe.keep_out = {{.name = "hose",
                      .at = {10 - 0.8 - 2 - 1 - 2, 10},
                      .size = {4, 4, 6},
                      .location = {},
                      .underside = recipe.board.thickness + 2}};
  EXPECT_EQ(named(), std::vector<std::string>{"d[0][0]"});
}

/// Every motion of random boards, once among bodies of the machine and fixtures that are matter, once with the same as
/// zones: the same verdict, words and distances.
TEST(KeepOutBoards, a_zone_is_kept_out_of_as_the_same_body_of_matter_is) {
  const config::Machine reference = test::reference();
  std::size_t asked = 0, refused = 0, zones = 0;
  for (std::uint64_t number = 0; number < 60; ++number) {
    const test::RandomBoard matter = test::random_board(reference, number);
    test::RandomBoard out = matter;
    for (std::size_t i = reference.scene.size(); i < matter.machine.scene.size(); ++i) {
      Body body = matter.machine.scene[i];
      body.name = config::zone_name(body.name), body.keep_out = true;
      out.machine.keep_out.push_back(body);
    }
    out.machine.scene.resize(reference.scene.size());
    std::erase_if(out.recipe.parts, [](const recipes::Part& p) { return p.fixture; });
    for (const recipes::Part& part : matter.recipe.parts)
      if (part.fixture) out.recipe.keep_out.push_back(part);
    if (out.machine.keep_out.empty() && out.recipe.keep_out.empty()) continue;
    zones += out.machine.keep_out.size() + out.recipe.keep_out.size();
    BlockPlanner among_matter(matter.machine, matter.recipe), among_zones(out.machine, out.recipe);
    const AxisVec park = test::parked(reference);
    const auto same = [&](const Result<ProvenBlock>& a, const Result<ProvenBlock>& b) {
      ++asked;
      ASSERT_EQ(a.has_value(), b.has_value()) << number << ": " << to_text((a ? b : a).error());
      if (a) {
        EXPECT_EQ(a->duration_s(), b->duration_s());
        ASSERT_EQ(a->nearest().others.has_value(), b->nearest().others.has_value());
        if (a->nearest().others) {
          EXPECT_EQ(a->nearest().others->distance_mm, b->nearest().others->distance_mm) << number;
        }
      } else {
        ++refused;
        EXPECT_EQ(a.error().message, std::regex_replace(b.error().message, std::regex("keep-out "), "")) << number;
      }
    };
    for (std::size_t i = 0; i < matter.recipe.marks.size(); ++i)
      same(among_matter.look_at_mark(1, park, i), among_zones.look_at_mark(1, park, i));
    for (std::size_t i = 0; i < matter.recipe.touches.size(); ++i)
      same(among_matter.touch(1, park, i), among_zones.touch(1, park, i));
    Knowledge known;
    known.offset = recipes::WorkOffset{}, known.surface = recipes::Surface{};
    among_matter.know(known), among_zones.know(known);
    for (std::size_t i = 0; i < matter.recipe.features.size(); ++i)
      same(among_matter.dispense(1, park, {i}), among_zones.dispense(1, park, {i}));
  }
  EXPECT_GT(zones, 30u);
  EXPECT_GT(asked - refused, 100u);
  EXPECT_GT(refused, 15u);
}

}  // namespace
}  // namespace gantry::job
