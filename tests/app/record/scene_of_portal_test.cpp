// Where the report puts the head, of jobs that come with the program: the pair that it names is as near there as it
// says, by a formula that knows neither sweeps nor proofs.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "app/job/prove.hpp"
#include "app/record/outcome.hpp"
#include "app/record/report.hpp"
#include "tests/app/job/reference.hpp"
#include "tests/app/record/page_scene.hpp"

namespace gantry::record {
namespace {

JobResult proved(const std::string& recipe_file) {
  const config::Machine machine = test::reference();
  const auto loaded = recipes::load_for(recipe_file, machine);
  JobResult r = begin_result(machine, loaded->recipe, loaded->job, "", true);
  const auto proof = job::prove_nominal(machine, loaded->recipe, loaded->job);
  if (proof)
    r.minimum_clearance = proof->nearest;
  else
    add_error(r, proof.error());
  return r;
}

/// Where a body of the head is in a pose; others stand.
Vec3 centre_in(const nlohmann::json& body, const nlohmann::json& pose) {
  const Vec3 own = vec(body.at("centre"));
  if (body.at("role") != "head") return own;
  return own + vec(pose.at("head")) - Vec3{0, 0, body.at("on_lift").get<bool>() ? pose.at("lift").get<double>() : 0.0};
}

/// Distance of two upright boxes, or of an upright capsule from one: its axis is a box of no width.
double gap_of(const nlohmann::json& scene, const nlohmann::json& pose) {
  Vec3 off{};
  double rounding = 0;
  const auto& a = named(scene.at("bodies"), "name", pose.at("moving"));
  const auto& b = named(scene.at("bodies"), "name", pose.at("standing"));
  Vec3 half = (vec(a.at("size")) + vec(b.at("size"))) * 0.5;
  if (a.at("kind") == "capsule") rounding = vec(a.at("size")).x / 2, half = half - Vec3{rounding, rounding, rounding};
  EXPECT_EQ(b.at("kind"), "box");
  EXPECT_EQ(b.at("yaw"), 0);
  off = centre_in(a, pose) - centre_in(b, pose);
  const Vec3 apart{std::max(0.0, std::abs(off.x) - half.x), std::max(0.0, std::abs(off.y) - half.y),
                   std::max(0.0, std::abs(off.z) - half.z)};
  return norm(apart) - rounding;
}

TEST(SceneOfPortal, the_head_stands_where_the_pair_is_as_near_as_it_is_told) {
  const auto r = proved("recipes/portal.yaml");
  ASSERT_TRUE(r.errors.empty());
  const auto scene = scene_in(report_page(r));
  const auto& pose = named(scene.at("poses"), "label", "the tightest place");
  EXPECT_NEAR(gap_of(scene, pose), r.minimum_clearance.others->distance_mm, 2e-3);
}

TEST(SceneOfPortal, of_the_closed_one_the_head_stands_where_the_refused_motion_comes_too_near) {
  const auto r = proved("recipes/portal-closed.yaml");
  ASSERT_EQ(r.errors.size(), 1u);
  const auto scene = scene_in(report_page(r));
  const auto& pose = scene.at("poses").at(0);
  EXPECT_EQ(pose.at("moving"), "camera_body");
  EXPECT_EQ(pose.at("standing"), "bridge");
  EXPECT_NEAR(gap_of(scene, pose), 2, 2e-3) << "the machine's clearance";
  EXPECT_EQ(pose.at("motion").size(), 6u);
  EXPECT_NE(r.errors[0].message.find("[machine 207.00, 105.93, -34.35]"), std::string::npos);
  EXPECT_LE(norm(vec(pose.at("at")) - Vec3{207.00, 105.93, -34.35}), 0.01);
}

}  // namespace
}  // namespace gantry::record
