// What the report shows in three dimensions, read back out of the page and compared with figures that are worked out
// here.
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "app/record/drawing.hpp"
#include "app/record/report.hpp"
#include "app/record/summary.hpp"
#include "core/meeting.hpp"
#include "tests/app/record/made_up_job.hpp"
#include "tests/app/record/page_scene.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

constexpr double kRounded = 6e-4;  // the page has three decimals

void expect_near(Vec3 a, Vec3 b, double within = kRounded) {
  EXPECT_LE(norm(a - b), within) << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

/// Corner of a box: +1 or -1 along its edges.
Vec3 corner(const nlohmann::json& body, Vec3 sign) {
  const Vec3 size = vec(body.at("size"));
  const Vec2 flat = rotated({sign.x * size.x / 2, sign.y * size.y / 2}, body.at("yaw"));
  return vec(body.at("centre")) + Vec3{flat.x, flat.y, sign.z * size.z / 2};
}

/// The board lies turned by a quarter and shifted by (1, -2); its corner is at (103, 84), its top at 12 and 0.5 higher.
TEST(Scene, bodies_marks_and_features_stand_where_the_job_has_found_the_board) {
  auto machine = three_axes();
  machine.frames = {{"pallet", {100, 80, 10}}};
  machine.scene = {{"post", {config::Shape::Kind::Cylinder, {8, 8, 30}}, {50, 60, 25}}};
  machine.keep_out = {{"keep-out door", {config::Shape::Kind::Box, {20, 30, 40}}, {300, 60, 25}}};
  machine.head = {{"stylus", {config::Shape::Kind::Capsule, {3, 3, 40}}, {-30, 10, -20}, 0, true}};
  machine.park = {{machine.z, 7}, {machine.x, 5}};
  recipes::Recipe recipe;
  recipe.board.size = {120, 80}, recipe.board.thickness = 2, recipe.board.frame = "pallet", recipe.board.at = {3, 4};
  recipe.parts = {{"U1", {20, 10}, {8, 4, 3}, 0, false, {}}, {"clamp", {-5, 40}, {6, 10, 15}, 0, true, {}, 2}};
  recipe.keep_out = {{"hose", {60, 40}, {6, 6, 50}, 0, false, {}, 22}};
  recipe.marks = {{"corner", {10, 5}, 1, true, {}}};
  recipe.touches = {{"t1", {0, 30}, {}}};
  recipes::Bead bead;
  bead.id = "seam", bead.points = {{10, 10, 0}, {30, 10, 1}};
  recipe.features = {bead};

  JobResult r;
  r.drawing = drawing_of(recipe, machine, {});
  r.offset = {{1, -2}, std::numbers::pi / 2}, r.surface = {0.5, {}};
  r.drawing = placed_drawing(r, recipe, machine);
  r.features_total = 1;
  const auto scene = scene_in(report_page(r));
  ASSERT_EQ(scene.at("bodies").size(), 7u);  // post, board, part, clamp, stylus, door, hose

  const auto& part = named(scene.at("bodies"), "name", "U1");
  EXPECT_EQ(part.at("role"), "part");
  expect_near(corner(part, {1, 1, -1}), {100 + 3 + 1 - 10 - 2, 80 + 4 - 2 + 20 + 4, 12.5});
  expect_near(corner(part, {-1, -1, 1}), {100 + 3 + 1 - 10 + 2, 80 + 4 - 2 + 20 - 4, 15.5});
  const auto& board = named(scene.at("bodies"), "name", "board");
  expect_near(corner(board, {-1, -1, 1}), {104, 82, 12.5});
  expect_near(corner(board, {1, 1, 1}), {104 - 80, 82 + 120, 12.5});
  const auto& clamp = named(scene.at("bodies"), "name", "clamp");
  EXPECT_EQ(clamp.at("role"), "fixture") << "it does not move with the board";
  expect_near(corner(clamp, {-1, -1, -1}), {100 + 3 - 5 - 3, 80 + 4 + 40 - 5, 12});
  const auto& hose = named(scene.at("bodies"), "name", "keep-out hose");
  EXPECT_EQ(hose.at("role"), "zone");
  expect_near(vec(hose.at("centre")), {100 + 3 + 60, 80 + 4 + 40, 10 + 22 + 25});
  const auto& door = named(scene.at("bodies"), "name", "keep-out door");
  EXPECT_EQ(door.at("role"), "zone");
  expect_near(vec(door.at("centre")), {300, 60, 25});
  const std::string markup = markup_of(report_page(r));
  EXPECT_NE(markup.find("data-layer=\"zone\""), std::string::npos) << "it can be hidden";
  const auto& post = named(scene.at("bodies"), "name", "post");
  EXPECT_EQ(post.at("kind"), "cylinder");
  EXPECT_EQ(post.at("role"), "machine");
  const auto& stylus = named(scene.at("bodies"), "name", "stylus");
  EXPECT_EQ(stylus.at("kind"), "capsule");
  EXPECT_EQ(stylus.at("role"), "head");
  EXPECT_EQ(stylus.at("on_lift"), true);
  expect_near(vec(stylus.at("centre")), {-30, 10, -20});

  expect_near(vec(named(scene.at("spots"), "name", "corner").at("at")), {104 - 5, 82 + 10, 12.5});
  expect_near(vec(named(scene.at("spots"), "name", "t1").at("at")), {104 - 30, 82, 12.5});
  expect_near(vec(scene.at("asked").at("beads").at(0)), {104 - 10, 82 + 10, 12.5});
  expect_near(vec(scene.at("asked").at("beads").at(0), 3), {104 - 10, 82 + 30, 13.5});
  ASSERT_EQ(scene.at("poses").size(), 1u) << "nothing has moved";
  expect_near(vec(scene.at("poses").at(0).at("head")), {5, 0, 7});
}

TEST(Scene, the_path_is_that_of_the_tips_from_its_first_point_to_its_last) {
  const auto r = made_up_job();
  const auto scene = scene_in(report_page(r));
  const auto& travel = scene.at("travel");
  // The camera looks first, its focus 45 mm beside and 90 mm below the head's point; the needle is there at the end.
  expect_near(vec(travel.front()), r.actual.front().head + Vec3{45, 0, -90});
  expect_near(vec(travel.back(), travel.back().size() - 3), r.actual.back().head + Vec3{0, 0, -60});
  EXPECT_EQ(travel.size(), 9u) << "a line a block";
  EXPECT_EQ(scene.at("dots").size(), 3u * 24);
  EXPECT_EQ(scene.at("beads").size(), 6u);
  EXPECT_TRUE(scene.at("asked").at("beads").empty()) << "all of it is there";
}

TEST(Scene, the_tightest_place_is_the_summary_s) {
  const auto r = made_up_job();
  const auto scene = scene_in(report_page(r));
  const auto summary = to_json(r);
  for (const auto& [label, key] : {std::pair{"the tightest place", "others"}, {"the nearest by design", "by_design"}}) {
    const auto& pose = named(scene.at("poses"), "label", label);
    const auto& told = summary.at("certificate").at("minimum_clearance").at(key);
    EXPECT_EQ(pose.at("at"), told.at("machine_mm")) << told;
    EXPECT_EQ(pose.at("moving"), told.at("pair").at(0));
    EXPECT_EQ(pose.at("standing"), told.at("pair").at(1));
    EXPECT_EQ(pose.at("meets"), false);
  }
  EXPECT_EQ(scene.at("poses").at(0).at("label"), "the tightest place") << "shown first";
  expect_near(vec(scene.at("poses").at(0).at("head")), {192, 171, -45});
  expect_near(vec(named(scene.at("poses"), "label", "where the job ended").at("head")), r.actual.back().head);
}

TEST(Scene, of_a_job_that_is_refused_shows_first_the_pair_the_point_and_the_motion) {
  auto r = made_up_failure();
  r.actual.clear(), r.planned.clear(), r.collisions.clear(), r.minimum_clearance = {};
  Error refused{Fault::Collision, "mark 'a': camera comes within 2 mm of relay", "recipes/made-up.yaml:4:5"};
  refused.meeting = std::make_shared<Meeting>(
      Meeting{"camera", "relay", AxisVec{10, 20, 90}, AxisVec{110, 20, 90}, AxisVec{60, 20, 90}, {160, 122, 21}, 2});
  r.errors = {refused};
  const auto scene = scene_in(report_page(r));
  const auto& pose = scene.at("poses").at(0);
  EXPECT_EQ(pose.at("meets"), true);
  EXPECT_EQ(pose.at("moving"), "camera");
  EXPECT_EQ(pose.at("standing"), "relay");
  expect_near(vec(pose.at("at")), {160, 122, 21});
  expect_near(vec(pose.at("head")), {60, 20, 90});
  // Of the camera's lower end: 45 mm beside the head's point, 20 + 30 mm below it.
  expect_near(vec(pose.at("motion")), {55, 20, 40});
  expect_near(vec(pose.at("motion"), 3), {155, 20, 40});
  EXPECT_EQ(scene.at("asked").at("dots").size(), 3u);
}

TEST(Scene, a_collision_that_the_world_saw_has_the_head_where_it_was) {
  const auto r = made_up_failure();
  const auto scene = scene_in(report_page(r));
  const auto& pose = scene.at("poses").at(0);
  EXPECT_EQ(pose.at("label"), "collision at 21.400 s");
  EXPECT_EQ(pose.at("meets"), true);
  double least = 1e9;
  for (const auto& p : r.actual)
    if (std::abs(p.t_s - 21.4) < 0.05) least = std::min(least, norm(p.head - vec(pose.at("head"))));
  EXPECT_LT(least, 1e-3);
}

/// libxml2's parser is the judge of where elements begin and end.
std::string asked(const std::string& file, const std::string& xpath) {
  const std::string command = "xmllint --html --xpath '" + xpath + "' " + file + " 2>/dev/null";
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string out;
  for (int c; pipe != nullptr && (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
  if (pipe != nullptr) pclose(pipe);
  while (!out.empty() && out.back() == '\n') out.pop_back();
  return out;
}

TEST(Scene, names_from_outside_stay_names) {
  const Folder folder;
  for (const std::string evil :
       {"</script><script>alert(1)</script>", "<!--<script>", "]]>\"'><img src=x onerror=alert(1)>",
        "\\u003c/script\\u003e", "a\xff\xc3(b", "U+2028 \xE2\x80\xA8 &lt;/script&gt;"}) {
    auto r = made_up_job();
    for (auto& b : r.drawing.bodies) b.body.name = evil;
    for (auto& s : r.drawing.spots) s.name = evil;
    r.minimum_clearance.others->head = r.minimum_clearance.others->motion = evil;
    r.errors = {{Fault::Collision, evil, evil}};
    r.errors[0].meeting = std::make_shared<Meeting>(Meeting{evil, evil});
    ASSERT_TRUE(write_report(folder.path, r));
    const auto page = report_page(r);
    const auto file = folder.path + "/report.html";
    EXPECT_EQ(asked(file, "count(//script)"), "3") << evil;
    EXPECT_EQ(asked(file, "count(//body/main)"), "1") << evil;
    EXPECT_EQ(asked(file, "count(//@onerror)"), "0") << evil;
    EXPECT_EQ(script_with(page, "scene-data").find_first_of("<>&"), std::string::npos) << evil;
    if (evil.find('\xff') == std::string::npos) {
      EXPECT_EQ(scene_in(page).at("bodies").at(0).at("name"), evil);
    }
  }
}

TEST(Scene, the_page_needs_nothing_else_and_runs_nothing_else) {
  const Folder folder;
  ASSERT_TRUE(write_report(folder.path, made_up_job()));
  const auto file = folder.path + "/report.html";
  EXPECT_EQ(asked(file, "count(//@src[not(starts-with(., \"data:\"))] | //@href | //link | //iframe)"), "0");
  const auto policy = asked(file, "string(//meta[@http-equiv=\"Content-Security-Policy\"]/@content)");
  EXPECT_TRUE(policy.starts_with("default-src 'none';")) << policy;
  EXPECT_EQ(policy.find("unsafe-inline", policy.find("script-src")), std::string::npos) << policy;
  // The two scripts that may run, hashed by others' programs: the page's own, and the library unpacked.
  const auto hash = [&](const std::string& what) {
    const auto out = folder.path + "/hash";
    EXPECT_EQ(std::system((what + " | openssl dgst -sha256 -binary | base64 -w0 > " + out).c_str()), 0);
    std::ifstream in(out);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string of = "xmllint --html --xpath 'string(//script[@id=\"scene-library\"])' " + file + " 2>/dev/null";
  EXPECT_NE(policy.find("'sha256-" + hash(of + " | base64 -d | gunzip") + "'"), std::string::npos) << policy;
  const auto page = report_page(made_up_job());
  const auto own = page.find("<script>") + 8;
  std::ofstream(folder.path + "/own.js", std::ios::binary) << page.substr(own, page.find("</script>", own) - own);
  EXPECT_NE(policy.find("'sha256-" + hash("cat " + folder.path + "/own.js") + "'"), std::string::npos) << policy;
  EXPECT_LT(page.size(), 700'000u) << "a quarter of a megabyte of it is the library";
}

TEST(Scene, the_library_s_licence_goes_with_it) {
  std::ifstream in(GANTRY_SOURCE_DIR "/app/record/scene/three_licence.txt");
  const std::string licence{std::istreambuf_iterator<char>(in), {}};
  ASSERT_NE(licence.find("Permission is hereby granted"), std::string::npos);
  EXPECT_NE(report_page(made_up_job()).find(licence), std::string::npos);
}

TEST(Scene, where_there_is_nothing_to_draw_there_is_none) {
  const auto page = report_page(JobResult{});
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("scene"), std::string::npos);
}

}  // namespace
}  // namespace gantry::record
