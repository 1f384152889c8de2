#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <set>
#include <tuple>

#include "core/units.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {
namespace {

Recipe demo() {
  auto r = load("recipes/demo-board.yaml");
  if (!r)
    for (const Error& e : r.error()) ADD_FAILURE() << to_text(e);
  return r ? *r : Recipe{};
}

/// A small recipe; `features` are written under that key.
std::string with(const std::string& features) {
  return "version: 1\nrecipe: r\n"
         "board: {size: [100 mm, 60 mm], thickness: 12 mm, frame: pallet}\n"
         "marks: {a: {at: [5 mm, 5 mm], diameter: 1 mm}, b: {at: [90 mm, 50 mm], diameter: 1 mm}}\n"
         "touches: {t: {at: [10 mm, 10 mm]}}\n"
         "materials:\n"
         "  glue: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 50 ms, "
         "retract: 3 mm}\n"
         "features:\n" +
         features;
}
constexpr int kFeaturesFrom = 9;  // line of the first feature

TEST(Recipe, the_demo_board_is_the_job_that_it_promises) {
  const Recipe r = demo();
  EXPECT_EQ(r.board.size, (Vec2{120, 80}));
  EXPECT_EQ(r.marks.size(), 4u);
  for (const MarkDef& m : r.marks) EXPECT_EQ(m.diameter, 1.5);
  EXPECT_EQ(r.touches.size(), 3u);
  EXPECT_EQ(r.materials.size(), 2u);
  std::size_t dots = 0, beads = 0, closed = 0;
  for (const Feature& f : r.features) {
    dots += std::holds_alternative<Dot>(f);
    if (const auto* b = std::get_if<Bead>(&f)) ++beads, closed += b->closed;
  }
  EXPECT_EQ(dots, 29u);
  EXPECT_EQ(beads, 6u);
  EXPECT_EQ(closed, 2u);
  EXPECT_TRUE(std::any_of(r.parts.begin(), r.parts.end(), [](const Part& p) { return p.fixture; }));
  EXPECT_TRUE(std::any_of(r.parts.begin(), r.parts.end(), [](const Part& p) { return !p.fixture && p.size.z >= 18; }));
}

TEST(Recipe, holds_5000_parts_and_512_KiB_and_no_more) {
  const auto with_parts = [](std::size_t count) {
    std::string text = with("  - dot: {name: d, material: glue, at: [10 mm, 10 mm]}\n") + "parts:\n";
    for (std::size_t i = 0; i < count; ++i)
      text += "  p" + std::to_string(i) + ": {at: [" + std::to_string(20 + i % 60) +
              ".125 mm, 30.125 mm], size: [0.5 mm, " + "0.5 mm, 1 mm], rotation: 12 deg}\n";
    return text;
  };
  const auto fault = [](const std::string& text) {
    const auto r = parse(text, "r.yaml");
    return r ? std::optional<Fault>() : r.error().front().fault;
  };
  std::string text = with_parts(5000);
  EXPECT_EQ(fault(text), std::nullopt);
  EXPECT_EQ(fault(with_parts(5001)), Fault::OutOfRange);
  constexpr std::size_t kBytes = 512 * 1024;
  ASSERT_LT(text.size(), kBytes);
  text += "#" + std::string(kBytes - text.size() - 1, '.');
  EXPECT_EQ(fault(text), std::nullopt);
  EXPECT_EQ(fault(text + "."), Fault::FileTooLarge);
}

TEST(Recipe, three_mistakes_are_three_messages_at_their_places) {
  std::string text = *config::read_text_file("recipes/demo-board.yaml");
  const auto swap = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  const auto place = [&](const std::string& what) {
    const auto at = text.find(what);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
    const auto start = text.rfind('\n', at) + 1;
    return "board.yaml:" + std::to_string(line) + ":" + std::to_string(at - start + 1);
  };
  swap("speed: 15 mm/s", "sped: 15 mm/s");
  swap("gap: 0.4 mm", "gap: 0.44");
  swap("name: capacitor_l\n      material: sealant", "name: capacitor_l\n      material: sealent");
  const auto r = parse(text, "board.yaml");
  ASSERT_FALSE(r);
  ASSERT_EQ(r.error().size(), 3u) << to_text(r.error().back());
  EXPECT_EQ(r.error()[0].fault, Fault::UnknownKey);
  EXPECT_EQ(r.error()[0].where, place("sped:"));
  EXPECT_NE(r.error()[0].message.find("'speed'"), std::string::npos);
  EXPECT_EQ(r.error()[1].fault, Fault::BadUnit);
  EXPECT_EQ(r.error()[1].where, place("0.44"));
  EXPECT_EQ(r.error()[2].fault, Fault::UnknownReference);
  EXPECT_EQ(r.error()[2].where, place("sealent"));
  for (const Error& e : r.error()) EXPECT_EQ(info(e.fault).exit_code, ExitCode::InvalidFile);
}

/// The only message about a small recipe in which `from` was replaced.
std::string only_message(const std::string& from, const std::string& to) {
  std::string text = with("  - dot: {name: a, material: glue, at: [50 mm, 30 mm]}\n");
  const auto at = text.find(from);
  if (at == std::string::npos) return "no '" + from + "'";
  text.replace(at, from.size(), to);
  const auto r = parse(text, "r.yaml");
  if (r) return "";
  return r.error().size() == 1 ? to_text(r.error().front()) : std::to_string(r.error().size()) + " messages";
}

TEST(Recipe, marks_that_cannot_fix_an_offset_are_told) {
  EXPECT_EQ(only_message("at: [90 mm, 50 mm]", "at: [30 mm, 20 mm]"), "");
  const auto r = parse(with("  - dot: {name: a, material: glue, at: [50 mm, 30 mm]}\n")
                           .replace(with("").find("at: [90 mm, 50 mm]"), 18, "at: [5 mm, 5 mm]"),
                       "r.yaml");
  ASSERT_FALSE(r);
  EXPECT_NE(to_text(r.error().front()).find("mark 'b' overlaps mark 'a'"), std::string::npos)
      << to_text(r.error().front());
}

TEST(Recipe, a_feature_may_leave_the_board_when_it_says_so) {
  const auto parsed = [](const std::string& more) {
    return parse(with("  - line: {name: a, material: glue, from: [50 mm, 30 mm], to: [104 mm, 30 mm]" + more + "}\n"),
                 "r.yaml");
  };
  ASSERT_FALSE(parsed(""));
  EXPECT_EQ(parsed("").error().front().fault, Fault::OutOfRange);
  const auto r = parsed(", off_board: true");
  ASSERT_TRUE(r) << to_text(r.error().front());
  EXPECT_TRUE(std::get<Bead>(r->features.front()).off_board);
}

TEST(Recipe, tolerances_have_defaults_and_are_read_with_their_units) {
  const auto glue = parse(with("  - dot: {name: a, material: glue, at: [50 mm, 30 mm]}\n"), "r.yaml")->materials[0];
  EXPECT_EQ(glue.tolerance_mm, 0.1);
  EXPECT_EQ(glue.gap_tolerance_mm, 0.1);
  EXPECT_EQ(glue.speed_tolerance, 0.05);
  EXPECT_FALSE(glue.flow_follows_speed);
  std::string text = with("  - dot: {name: a, material: glue, at: [50 mm, 30 mm]}\n");
  const std::string last = "retract: 3 mm";
  text.replace(
      text.find(last), last.size(),
      "retract: 3 mm, tolerance: 50 um, gap_tolerance: 0.2 mm, speed_tolerance: 8 %, flow_follows_speed: true");
  const auto given = parse(text, "r.yaml");
  ASSERT_TRUE(given) << to_text(given.error().front());
  EXPECT_NEAR(given->materials[0].tolerance_mm, 0.05, 1e-12);
  EXPECT_EQ(given->materials[0].gap_tolerance_mm, 0.2);
  EXPECT_NEAR(given->materials[0].speed_tolerance, 0.08, 1e-12);
  EXPECT_TRUE(given->materials[0].flow_follows_speed);
  EXPECT_EQ(given->placement, Placement::Marks);
  EXPECT_NE(only_message("retract: 3 mm", "retract: 3 mm, speed_tolerance: 0.08").find("'5 %'"), std::string::npos);
  text.erase(text.find("marks:"), text.find("touches:") - text.find("marks:"));
  text.insert(text.find("board:"), "placement: fixture\n");
  EXPECT_EQ(parse(text, "r.yaml")->placement, Placement::Fixture);
  EXPECT_NE(only_message("recipe: r\n", "recipe: r\nplacement: fixtur\n").find("fixture"), std::string::npos);
}

TEST(Recipe, a_mark_under_something_is_told) {
  for (const char* thing : {"parts: {lid: {at: [90 mm, 46 mm], size: [20 mm, 8 mm, 5 mm]}}\n",
                            "fixtures: {lid: {at: [97 mm, 50 mm], size: [14 mm, 6 mm, 5 mm], rotation: 20 deg}}\n"}) {
    const auto r = parse(thing + with("  - dot: {name: d, material: glue, at: [5 mm, 5 mm]}\n"), "f");
    ASSERT_FALSE(r) << thing;
    EXPECT_EQ(r.error().size(), 1u);
    EXPECT_EQ(r.error()[0].where, "f:5:48");
    EXPECT_NE(r.error()[0].message.find("'lid' covers"), std::string::npos);
  }
}

/// What is told of the small recipe with more at its top.
std::string told_with(const std::string& more,
                      std::string text = with("  - dot: {name: d, material: glue, at: [30 mm, 30 mm]}\n")) {
  text.insert(text.find("board:"), more);
  const auto r = parse(text, "r.yaml");
  std::string all;
  if (!r)
    for (const Error& e : r.error()) all += to_text(e) + "\n";
  return all;
}

TEST(Recipe, zones_to_keep_out_of_are_no_parts) {
  const std::string text = *config::read_text_file("recipes/demo-board.yaml");
  const auto with = [&](const std::string& zone) {
    return parse(text + "\nkeep_out: {hose: " + zone + "}\n", "r.yaml");
  };
  const auto r = with("{at: [6 mm, 6 mm], size: [10 mm, 20 mm, 30 mm], rotation: 90 deg, z: 25 mm}");
  ASSERT_TRUE(r) << to_text(r.error().front());
  ASSERT_EQ(r->keep_out.size(), 1u);
  EXPECT_EQ(r->parts.size(), parse(text, "r.yaml")->parts.size());
  EXPECT_EQ(r->keep_out[0].name, "hose");
  EXPECT_EQ(r->keep_out[0].at, (Vec2{6, 6})) << "over a mark, which the camera sees through it";
  EXPECT_EQ(r->keep_out[0].underside, 25);
  EXPECT_FALSE(with("{at: [6 mm, 6 mm], size: [10 mm, 20 mm, 30 mm], underside: 2 mm}"));
  std::string on_zone = text;
  on_zone.replace(on_zone.find("features:\n"), 10,
                  "keep_out: {hose: {at: [6 mm, 6 mm], size: [9 mm, 9 mm, 9 mm]}}\nfeatures:\n  - dot: {name: x, "
                  "material: adhesive, on: hose, at: [6 mm, 6 mm]}\n");
  EXPECT_FALSE(parse(on_zone, "r.yaml")) << "nothing lies on a zone";
}

TEST(Recipe, marks_and_a_fixture_that_says_where_the_board_lies_exclude_one_another) {
  EXPECT_NE(told_with("placement: fixture\n").find("leave out one of them"), std::string::npos);
}

TEST(Recipe, the_same_dot_or_bead_twice_is_told) {
  const auto told = [](const std::string& features) { return told_with("", with(features)); };
  EXPECT_NE(told("  - dot: {name: a, material: glue, at: [20 mm, 20 mm]}\n  - dot: {name: b, material: glue, at: "
                 "[20.05 mm, 20 mm]}\n")
                .find("r.yaml:10:5: dot 'b' lies on dot 'a' of line 9"),
            std::string::npos);
  EXPECT_NE(told("  - line: {name: a, material: glue, from: [20 mm, 20 mm], to: [40 mm, 20 mm]}\n  - line: {name: b, "
                 "material: glue, from: [40 mm, 20 mm], to: [20 mm, 20 mm]}\n")
                .find("bead 'b' lies on bead 'a'"),
            std::string::npos);
}

TEST(Recipe, three_touches_on_one_line_cannot_give_a_plane) {
  const auto with_third = [](const std::string& third) {
    std::string text = with("  - dot: {name: d, material: glue, at: [50 mm, 30 mm]}\n");
    const std::string one = "t: {at: [10 mm, 10 mm]}";
    text.replace(text.find(one), one.size(), "t: {at: [10 mm, 10 mm]}, u: {at: [80 mm, 50 mm]}" + third);
    return parse(text, "f");
  };
  EXPECT_TRUE(with_third(""));
  EXPECT_TRUE(with_third(", v: {at: [10 mm, 50 mm]}"));
  for (const auto& [third, words] : {std::pair{", v: {at: [45 mm, 30 mm]}", "on one line"},
                                     {", v: {at: [45 mm, 33 mm]}", "on one line"},
                                     {", v: {at: [10 mm, 10 mm]}", "at the same place as touch 't'"}}) {
    const auto r = with_third(third);
    ASSERT_FALSE(r) << third;
    EXPECT_EQ(r.error().size(), 1u);
    EXPECT_EQ(r.error()[0].where, "f:5:61");
    EXPECT_NE(r.error()[0].message.find(words), std::string::npos) << r.error()[0].message;
  }
}

TEST(Recipe, the_example_of_the_docs_reads) {
  const std::string page = *config::read_text_file("docs/recipe.md");
  const auto from = page.find("```yaml\n") + 8;
  const auto r = parse(page.substr(from, page.find("```", from) - from), "docs");
  if (!r)
    for (const Error& e : r.error()) ADD_FAILURE() << to_text(e);
}

TEST(Array, runs_to_and_fro_and_leaves_out_what_it_skips) {
  const auto r =
      parse(with("  - array: {name: a, material: glue, at: [10 mm, 20 mm], rows: 2, columns: 3, pitch: [5 mm, 4 mm], "
                 "skip: [[1, 1]]}\n"),
            "f");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  const std::pair<const char*, Vec2> want[] = {{"a[0][0]", {10, 20}},
                                               {"a[0][1]", {15, 20}},
                                               {"a[0][2]", {20, 20}},
                                               {"a[1][2]", {20, 24}},
                                               {"a[1][0]", {10, 24}}};
  ASSERT_EQ(r->features.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const Dot& d = std::get<Dot>(r->features[i]);
    EXPECT_EQ(d.id, want[i].first);
    EXPECT_LT(norm(d.at - want[i].second), 1e-12) << d.id;
    EXPECT_EQ(d.location, (Location{kFeaturesFrom, 5}));
  }
}

TEST(Array, turns_about_its_first_dot) {
  const auto r =
      parse(with("  - array: {name: a, material: glue, at: [50 mm, 20 mm], rows: 2, columns: 2, pitch: [5 mm, 4 mm], "
                 "rotation: 90 deg}\n"),
            "f");
  ASSERT_TRUE(r);
  EXPECT_LT(norm(std::get<Dot>(r->features[1]).at - Vec2{50, 25}), 1e-12) << "its columns run along Y now";
  EXPECT_LT(norm(std::get<Dot>(r->features[3]).at - Vec2{46, 20}), 1e-12) << "its rows along -X";
}

TEST(Bead, rectangles_and_closed_polylines_come_back_to_their_start) {
  const auto r = parse(with("  - rectangle: {name: q, material: glue, at: [10 mm, 10 mm], size: [20 mm, 5 mm], "
                            "corner_tolerance: 0.1 mm}\n"
                            "  - polyline: {name: p, material: glue, closed: true, points: [[50 mm, 5 mm], [60 mm, 5 "
                            "mm], [55 mm, 9 mm]]}\n"
                            "  - line: {name: l, material: glue, from: [5 mm, 30 mm], to: [6 mm, 30 mm]}\n"),
                       "f");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  const Bead& q = std::get<Bead>(r->features[0]);
  EXPECT_EQ(q.points, (std::vector<Vec3>{{10, 10}, {30, 10}, {30, 15}, {10, 15}, {10, 10}}));
  EXPECT_TRUE(q.closed);
  EXPECT_EQ(q.corner_tolerance, 0.1);
  const Bead& p = std::get<Bead>(r->features[1]);
  EXPECT_EQ(p.points.size(), 4u);
  EXPECT_EQ(p.points.front(), p.points.back());
  EXPECT_EQ(p.corner_tolerance, 0);
  EXPECT_FALSE(std::get<Bead>(r->features[2]).closed);
}

// A standing half circle of radius 20: where the needle is lower than the arc by more than half of the gap, 0.2 mm, it
// is in what it dispenses on. What the chords use of that is not left for the rounding of their corners.
TEST(Bead, an_arc_that_stands_or_leans_keeps_to_its_gap_whatever_its_corner_tolerance) {
  for (const auto& [through, centre, radius] :
       {std::tuple{"[30 mm, 20 mm, 20 mm]", Vec3{30, 20, 0}, 20.0},
        std::tuple{"[30 mm, 30 mm, 10 mm]", Vec3{30, 15, -5}, std::hypot(20, 5, 5)}}) {
    const auto r =
        parse(with("  - arc: {name: a, material: glue, from: [10 mm, 20 mm], through: " + std::string(through) +
                   ", to: [50 mm, 20 mm], corner_tolerance: 5 mm}\n"),
              "f");
    ASSERT_TRUE(r) << to_text(r.error()[0]);
    const Bead& bead = std::get<Bead>(r->features[0]);
    EXPECT_EQ(bead.corner_tolerance, 5);
    double sag = 0;
    for (std::size_t k = 1; k < bead.points.size(); ++k) {
      EXPECT_NEAR(norm(bead.points[k] - centre), radius, 1e-9);
      sag = std::max(sag, radius - norm((bead.points[k] + bead.points[k - 1]) * 0.5 - centre));
    }
    EXPECT_LE(sag, 0.1 / 20 + 1e-12) << through;
  }
  // A level one has all of its tolerance: a twentieth of 5 mm is more than chords of 15 degrees sag.
  const auto level =
      parse(with("  - arc: {name: a, material: glue, from: [10 mm, 20 mm, 1 mm], through: [30 mm, 40 mm, "
                 "1 mm], to: [50 mm, 20 mm, 1 mm], corner_tolerance: 5 mm}\n"),
            "f");
  ASSERT_TRUE(level) << to_text(level.error()[0]);
  EXPECT_EQ(std::get<Bead>(level->features[0]).points.size(), 13u);
}

TEST(Bead, curves_are_chords_within_a_twentieth_of_their_corner_tolerance) {
  const auto r = parse(
      with("  - arc: {name: three, material: glue, from: [10 mm, 10 mm], through: [15 mm, 15 mm], to: [20 mm, 10 mm]}\n"
           "  - arc: {name: about, material: glue, from: [40 mm, 10 mm], centre: [30 mm, 10 mm], angle: -90 deg, "
           "corner_tolerance: 0.2 mm}\n"
           "  - circle: {name: c, material: glue, centre: [60 mm, 20 mm, 1 mm], radius: 8 mm, start: 90 deg, "
           "clockwise: true}\n"
           "  - spiral: {name: s, material: glue, centre: [60 mm, 40 mm], from_radius: 0 mm, to_radius: 9 mm, "
           "spacing: 3 mm}\n"),
      "f");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  struct Want {
    Vec3 from, to, centre;
    double radius, length, tolerance;
    bool closed;
  };
  const std::vector<Want> want{{{10, 10, 0}, {20, 10, 0}, {15, 10, 0}, 5, 5 * M_PI, 0.05, false},
                               {{40, 10, 0}, {30, 0, 0}, {30, 10, 0}, 10, 5 * M_PI, 0.2, false},
                               {{60, 28, 1}, {60, 28, 1}, {60, 20, 1}, 8, 16 * M_PI, 0.05, true}};
  for (std::size_t i = 0; i < want.size(); ++i) {
    const Bead& b = std::get<Bead>(r->features[i]);
    EXPECT_LT(norm(b.points.front() - want[i].from), 1e-9) << b.id;
    EXPECT_LT(norm(b.points.back() - want[i].to), 1e-9) << b.id;
    EXPECT_EQ(b.closed, want[i].closed) << b.id;
    EXPECT_EQ(b.points.front() == b.points.back(), want[i].closed) << b.id;
    EXPECT_EQ(b.corner_tolerance, want[i].tolerance);
    EXPECT_NEAR(length_mm(b), want[i].length, 1e-9) << b.id;
    for (std::size_t k = 1; k < b.points.size(); ++k) {
      const Vec3 middle = (b.points[k] + b.points[k - 1]) * 0.5;
      EXPECT_NEAR(norm(b.points[k] - want[i].centre), want[i].radius, 1e-9) << b.id;
      EXPECT_GE(norm(middle - want[i].centre), want[i].radius - want[i].tolerance / 20 - 1e-12) << b.id;
    }
  }
  const Bead& c = std::get<Bead>(r->features[2]);
  EXPECT_GT(c.points[1].x, 60) << "clockwise from the top goes right";
  const Bead& s = std::get<Bead>(r->features[3]);
  EXPECT_LT(norm(s.points.front() - Vec3{60, 40, 0}), 1e-9);
  EXPECT_LT(norm(s.points.back() - Vec3{69, 40, 0}), 1e-9) << "three whole turns";
  EXPECT_STREQ(s.kind, "spiral");
}

TEST(Bead, points_may_have_heights) {
  const auto r = parse(with("  - dot: {name: d, material: glue, at: [5 mm, 5 mm, 2 mm]}\n"
                            "  - line: {name: l, material: glue, from: [5 mm, 10 mm, 1 mm], to: [9 mm, 10 mm]}\n"
                            "  - polyline: {name: p, material: glue, points: [[1 mm, 1 mm], [2 mm, 1 mm, 0.5 mm]]}\n"),
                       "f");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  EXPECT_EQ(std::get<Dot>(r->features[0]).height_mm, 2);
  EXPECT_EQ(std::get<Bead>(r->features[1]).points, (std::vector<Vec3>{{5, 10, 1}, {9, 10, 0}}));
  EXPECT_EQ(std::get<Bead>(r->features[2]).points, (std::vector<Vec3>{{1, 1, 0}, {2, 1, 0.5}}));
}

TEST(OnAPart, features_are_raised_onto_its_top_and_must_lie_on_it) {
  const auto on = [](const std::string& feature) {
    return parse(
        "parts: {relay: {at: [40 mm, 30 mm], size: [20 mm, 10 mm, 7 mm], rotation: 90 deg}}\n"
        "fixtures: {clamp: {at: [5 mm, 30 mm], size: [4 mm, 4 mm, 20 mm]}}\n" +
            with(feature),
        "f");
  };
  const auto r =
      on("  - dot: {name: d, material: glue, on: relay, at: [36 mm, 39 mm]}\n"
         "  - line: {name: l, material: glue, on: relay, from: [38 mm, 22 mm], to: [38 mm, 38 mm, 1 mm]}\n"
         "  - dot: {name: b, material: glue, at: [36 mm, 39 mm]}\n");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  EXPECT_EQ(std::get<Dot>(r->features[0]).height_mm, 7);
  EXPECT_EQ(std::get<Dot>(r->features[0]).on, "relay");
  EXPECT_EQ(std::get<Bead>(r->features[1]).points, (std::vector<Vec3>{{38, 22, 7}, {38, 38, 8}}));
  EXPECT_EQ(std::get<Dot>(r->features[2]).height_mm, 0);
  const auto says = [&](const std::string& feature, Fault fault, const char* words) {
    const auto wrong = on(feature);
    ASSERT_FALSE(wrong) << feature;
    EXPECT_EQ(wrong.error().size(), 1u);
    EXPECT_EQ(wrong.error()[0].fault, fault);
    EXPECT_EQ(wrong.error()[0].where, "f:11:43") << to_text(wrong.error()[0]);
    EXPECT_NE(wrong.error()[0].message.find(words), std::string::npos) << to_text(wrong.error()[0]);
  };
  says("  - dot: {name: d, material: glue, on:    relai, at: [36 mm, 39 mm]}\n", Fault::UnknownReference, "'relay'");
  says("  - dot: {name: d, material: glue, on:    clamp, at: [36 mm, 39 mm]}\n", Fault::UnknownReference, "'clamp'");
  says("  - dot: {name: d, material: glue, on:    relay, at: [46 mm, 30 mm]}\n", Fault::OutOfRange, "20 x 10 mm");
}

TEST(Fill, is_one_bead_where_it_can_be_and_numbered_ones_where_not) {
  const auto r = parse(
      with(
          "  - fill: {name: r, material: glue, at: [10 mm, 10 mm, 1 mm], size: [20 mm, 6 mm], spacing: 2 mm}\n"
          "  - fill: {name: u, material: glue, spacing: 2 mm, points: [[40 mm, 10 mm], [70 mm, 10 mm], [70 mm, 30 mm], "
          "[60 mm, 30 mm], [60 mm, 16 mm], [50 mm, 16 mm], [50 mm, 30 mm], [40 mm, 30 mm]]}\n"
          "  - fill: {name: l, material: glue, at: [10 mm, 30 mm], size: [20 mm, 6 mm], spacing: 3 mm, "
          "serpentine: false}\n"),
      "f");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  std::vector<std::string> ids;
  for (const Feature& f : r->features) ids.push_back(std::get<Bead>(f).id);
  EXPECT_EQ(ids, (std::vector<std::string>{"r", "u[0]", "u[1]", "l[0]", "l[1]"}));
  EXPECT_EQ(std::get<Bead>(r->features[0]).points.size(), 6u);
  EXPECT_EQ(std::get<Bead>(r->features[0]).points[0].z, 1);
  ASSERT_EQ(r->fills.size(), 3u);
  EXPECT_NEAR(r->fills[0].area_mm2, 120, 1e-9);
  EXPECT_NEAR(r->fills[1].area_mm2, 30 * 6 + 2 * 10 * 14, 1e-9);
  EXPECT_EQ(r->fills[1].first, 1u);
  EXPECT_EQ(r->fills[1].beads, 2u);
}

TEST(Purge, needs_a_place_that_can_be) {
  const auto with_purge = [](const std::string& purge) {
    return parse("purge: " + purge + "\n" + with("  - dot: {name: d, material: glue, at: [5 mm, 5 mm]}\n"), "f");
  };
  const auto good = with_purge("{material: glue, at: [5 mm, 6 mm, 1 mm], shots: 3, after: 90 s}");
  ASSERT_TRUE(good) << to_text(good.error()[0]);
  EXPECT_EQ(good->purge->at, (Vec3{5, 6, 1}));
  EXPECT_EQ(good->purge->shots, 3);
  EXPECT_EQ(good->purge->after_s, 90);
  EXPECT_TRUE(with_purge("{material: glue, frame: cup, at: [-5 mm, 6 mm, -1 mm], shots: 3, after: 90 s}"));
  const auto says = [&](const std::string& purge, Fault fault, const char* words) {
    const auto wrong = with_purge(purge);
    ASSERT_FALSE(wrong) << purge;
    EXPECT_EQ(wrong.error().size(), 1u);
    EXPECT_EQ(wrong.error()[0].fault, fault) << to_text(wrong.error()[0]);
    EXPECT_TRUE(wrong.error()[0].where.starts_with("f:1:")) << to_text(wrong.error()[0]);
    EXPECT_NE(wrong.error()[0].message.find(words), std::string::npos) << to_text(wrong.error()[0]);
  };
  says("{material: glew, at: [5 mm, 6 mm, 1 mm], shots: 3, after: 90 s}", Fault::UnknownReference, "'glue'");
  says("{material: glue, at: [500 mm, 6 mm, 1 mm], shots: 3, after: 90 s}", Fault::OutOfRange, "off the board");
  says("{material: glue, at: [5 mm, 6 mm, -1 mm], shots: 3, after: 90 s}", Fault::OutOfRange, "0 mm or more");
  says("{material: glue, at: [5 mm, 6 mm], shots: 3, after: 90 s}", Fault::BadValue, "expected 3");
  says("{material: glue, at: [5 mm, 6 mm, 1 mm], shots: 0, after: 90 s}", Fault::OutOfRange, "1 .. 1000");
  says("{material: glue, at: [5 mm, 6 mm, 1 mm], after: 90 s}", Fault::MissingKey, "'shots'");
}

struct Wrong {
  const char* feature;
  Fault fault;
  const char* at;  ///< where the mistake stands: the last of these in the text
  const char* says;
};
void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.feature; }
class Written : public testing::TestWithParam<Wrong> {};

TEST_P(Written, is_refused_with_its_place) {
  const Wrong& w = GetParam();
  const auto r = parse(with(w.feature), "f.yaml");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().size(), 1u) << to_text(r.error().back());
  EXPECT_EQ(r.error()[0].fault, w.fault) << to_text(r.error()[0]);
  const std::string text = w.feature;
  const auto at = text.rfind(w.at);
  ASSERT_NE(at, std::string::npos);
  const auto line = kFeaturesFrom + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
  const auto column = at - (at == 0 ? 0 : text.rfind('\n', at - 1) + 1) + 1;
  EXPECT_EQ(r.error()[0].where, "f.yaml:" + std::to_string(line) + ":" + std::to_string(column))
      << to_text(r.error()[0]);
  EXPECT_NE(r.error()[0].message.find(w.says), std::string::npos) << to_text(r.error()[0]);
}

INSTANTIATE_TEST_SUITE_P(
    Feature, Written,
    testing::Values(
        Wrong{"  - dot: {name: d, material: glue, at: [101 mm, 5 mm]}\n", Fault::OutOfRange, "[101", "100 x 60"},
        Wrong{"  - dot: {name: d, material: glew, at: [1 mm, 5 mm]}\n", Fault::UnknownReference, "glew", "'glue'"},
        Wrong{"  - dot: {name: d, at: [1 mm, 5 mm]}\n", Fault::MissingKey, "dot", "'material'"},
        Wrong{"  - dto: {name: d, material: glue, at: [1 mm, 5 mm]}\n", Fault::UnknownKey, "dto", "'dot'"},
        Wrong{"  - {}\n", Fault::BadValue, "{}", "no kind is named here"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm, 5 mm]}\n    line: {name: e, material: glue, from: [1 mm, "
              "1 mm], to: [2 mm, 2 mm]}\n",
              Fault::BadValue, "line", "'dot' and 'line' stand here"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm, 5 mm]}\n  - dot: {name: d, material: glue, at: [2 mm, 5 "
              "mm]}\n",
              Fault::DuplicateKey, "d, material: glue, at: [2", "'d'"},
        Wrong{"  - line: {name: d, material: glue, from: [1 mm, 5 mm], to: [1 mm, 5 mm]}\n", Fault::Inconsistent,
              "[1 mm, 5 mm]}", "where it starts"},
        Wrong{"  - polyline: {name: d, material: glue, points: [[1 mm, 5 mm]]}\n", Fault::OutOfRange, "[[",
              "at least 2"},
        Wrong{"  - polyline: {name: d, material: glue, points: [[1 mm, 5 mm], [2 mm, 5 mm], [2 mm, 5 mm]]}\n",
              Fault::Inconsistent, "[2 mm", "twice in a row"},
        Wrong{"  - polyline: {name: d, material: glue, closed: true, points: [[1 mm, 5 mm], [2 mm, 5 mm], [1 mm, 5 "
              "mm]]}\n",
              Fault::Inconsistent, "[1 mm, 5 mm]]", "leave out"},
        Wrong{"  - rectangle: {name: d, material: glue, at: [90 mm, 5 mm], size: [20 mm, 5 mm]}\n", Fault::OutOfRange,
              "[90", "(110, 5)"},
        Wrong{"  - rectangle: {name: d, material: glue, at: [90 mm, 5 mm], size: [0 mm, 5 mm]}\n", Fault::OutOfRange,
              "0 mm, 5 mm]}", "0.01 mm"},
        Wrong{
            "  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 1000, columns: 1000, pitch: [1 mm, 1 mm]}\n",
            Fault::TooManySteps, "array", "100000"},
        Wrong{"  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 2, columns: 2, pitch: [0 mm, 2 mm]}\n",
              Fault::Inconsistent, "[0 mm", "one spot"},
        Wrong{"  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 1, columns: 2, pitch: [3 mm, 0 mm], skip: "
              "[[0, 0], [0, 1]]}\n",
              Fault::Inconsistent, "array", "every dot"},
        Wrong{"  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 2, columns: 30, pitch: [5 mm, 5 mm]}\n",
              Fault::OutOfRange, "[5 mm, 5 mm], rows", "(105, 5)"},
        Wrong{"  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 2, columns: 3, pitch: [5 mm, 5 mm], skip: "
              "[[2, 0]]}\n",
              Fault::OutOfRange, "[2, 0]", "no such row"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm, 5 mm, -1 mm]}\n", Fault::OutOfRange, "-1 mm",
              "0 mm .. 200"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm]}\n", Fault::BadValue, "[1 mm]", "2 or 3"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm, .nan]}\n", Fault::BadValue, ".nan", "not a number"},
        Wrong{"  - polyline: {name: d, material: glue}\n", Fault::MissingKey, "polyline", "'points_file'"},
        Wrong{"  - polyline: {name: d, material: glue, points: [[1 mm, 1 mm], [2 mm, 1 mm]], points_file: p.csv}\n",
              Fault::Inconsistent, "polyline", "not both"},
        Wrong{"  - arc: {name: d, material: glue, from: [1 mm, 5 mm]}\n", Fault::MissingKey, "arc",
              "'through' and 'to'"},
        Wrong{"  - arc: {name: d, material: glue, from: [1 mm, 5 mm], through: [2 mm, 5 mm]}\n", Fault::MissingKey,
              "arc", "'to' is missing"},
        Wrong{"  - arc: {name: d, material: glue, from: [1 mm, 5 mm], to: [2 mm, 5 mm], angle: 30 deg}\n",
              Fault::Inconsistent, "arc", "not both"},
        Wrong{"  - arc: {name: d, material: glue, from: [1 mm, 5 mm], through: [2 mm, 5 mm], to: [3 mm, 5 mm]}\n",
              Fault::Inconsistent, "[2 mm", "on one line"},
        Wrong{"  - arc: {name: d, material: glue, from: [9 mm, 5 mm], centre: [9 mm, 5 mm], angle: 30 deg}\n",
              Fault::Inconsistent, "[9 mm", "no radius"},
        Wrong{"  - arc: {name: d, material: glue, from: [9 mm, 5 mm], centre: [5 mm, 5 mm], angle: 180 deg, "
              "corner_tolerance: 0 mm}\n",
              Fault::OutOfRange, "0 mm}", "0.001 mm"},
        Wrong{"  - arc: {name: d, material: glue, from: [9 mm, 5 mm, 1 mm], centre: [5 mm, 5 mm, 2 mm], angle: 180 "
              "deg}\n",
              Fault::Inconsistent, "[5 mm", "level"},
        Wrong{"  - circle: {name: d, material: glue, centre: [9 mm, 9 mm], radius: 0 mm}\n", Fault::OutOfRange, "0 mm}",
              "0.01 mm"},
        Wrong{"  - circle: {name: d, material: glue, centre: [9 mm, 9 mm], radius: 10 mm}\n", Fault::OutOfRange,
              "[9 mm", "of 'd' at ("},
        Wrong{"  - spiral: {name: d, material: glue, centre: [30 mm, 30 mm], from_radius: 5 mm, to_radius: 5 mm, "
              "spacing: 1 mm}\n",
              Fault::Inconsistent, "5 mm, spacing", "'circle'"},
        Wrong{"  - spiral: {name: d, material: glue, centre: [30 mm, 30 mm], from_radius: 5 mm, to_radius: 9 mm, "
              "spacing: 0 mm}\n",
              Fault::OutOfRange, "0 mm}", "0.01 mm"},
        Wrong{"  - spiral: {name: d, material: glue, centre: [30 mm, 30 mm], from_radius: 0 mm, to_radius: 25 mm, "
              "spacing: 0.01 mm, corner_tolerance: 0.001 mm}\n",
              Fault::TooManySteps, "spiral", "more than 100000 points"},
        Wrong{"  - fill: {name: d, material: glue, at: [9 mm, 9 mm], size: [20 mm, 3 mm], spacing: 4 mm}\n",
              Fault::Inconsistent, "[9 mm", "less than their spacing"},
        Wrong{"  - fill: {name: d, material: glue, at: [9 mm, 9 mm], size: [20 mm, 3 mm], spacing: 0 mm}\n",
              Fault::OutOfRange, "0 mm}", "0.01 mm"},
        Wrong{"  - fill: {name: d, material: glue, at: [9 mm, 9 mm], spacing: 1 mm}\n", Fault::MissingKey, "fill",
              "'size' is missing"},
        Wrong{"  - fill: {name: d, material: glue, spacing: 1 mm, points: [[1 mm, 1 mm], [9 mm, 9 mm], [9 mm, 1 mm], "
              "[1 mm, 9 mm]]}\n",
              Fault::Inconsistent, "[1 mm, 1 mm]", "crosses itself"},
        Wrong{"  - fill: {name: d, material: glue, spacing: 1 mm, points: [[1 mm, 1 mm], [9 mm, 9 mm, 1 mm], [9 mm, 1 "
              "mm]]}\n",
              Fault::Inconsistent, "[9 mm, 9 mm", "one height"},
        Wrong{
            "  - fill: {name: d, material: glue, spacing: 1 mm, rotation: 5 deg, points: [[1 mm, 1 mm], [9 mm, 9 mm], "
            "[9 mm, 1 mm]]}\n",
            Fault::Inconsistent, "fill", "'rotation'"},
        Wrong{"  - array: {name: d, material: glue, at: [5 mm, 5 mm], rows: 0, columns: 3, pitch: [5 mm, 5 mm]}\n",
              Fault::OutOfRange, "0, columns", "1 .. 10000"}));

TEST(Recipe, versions_of_another_day_are_refused) {
  std::string text = with("  - dot: {name: d, material: glue, at: [1 mm, 5 mm]}\n");
  text.replace(0, 10, "version: 2");
  const auto r = parse(text, "f");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error()[0].where, "f:1:10");
}

TEST(Recipe, one_mark_is_too_few) {
  std::string text = with("  - dot: {name: d, material: glue, at: [1 mm, 5 mm]}\n");
  const std::string second = ", b: {at: [90 mm, 50 mm], diameter: 1 mm}";
  text.erase(text.find(second), second.size());
  const auto r = parse(text, "f");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().size(), 1u);
  EXPECT_EQ(r.error()[0].where, "f:4:8");
}

TEST(Recipe, files_that_cannot_be_read_say_so) {
  EXPECT_EQ(load("recipes/no-such.yaml").error()[0].fault, Fault::FileUnreadable);
  EXPECT_EQ(load("/dev/zero").error()[0].fault, Fault::FileUnreadable);
}

}  // namespace
}  // namespace gantry::recipes
