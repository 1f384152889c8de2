#include <algorithm>
#include <gtest/gtest.h>
#include <set>

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

TEST(Recipe, three_touches_on_one_line_cannot_give_a_plane) {
  const auto with_third = [](const std::string& third) {
    std::string text = with("  - dot: {name: d, material: glue, at: [50 mm, 30 mm]}\n");
    const std::string one = "t: {at: [10 mm, 10 mm]}";
    text.replace(text.find(one), one.size(), "t: {at: [10 mm, 10 mm]}, u: {at: [80 mm, 50 mm]}" + third);
    return parse(text, "f");
  };
  EXPECT_TRUE(with_third(""));
  EXPECT_TRUE(with_third(", v: {at: [10 mm, 50 mm]}"));
  for (const char* third : {", v: {at: [45 mm, 30 mm]}", ", v: {at: [45 mm, 33 mm]}", ", v: {at: [10 mm, 10 mm]}"}) {
    const auto r = with_third(third);
    ASSERT_FALSE(r) << third;
    EXPECT_EQ(r.error().size(), 1u);
    EXPECT_EQ(r.error()[0].where, "f:5:61");
    EXPECT_NE(r.error()[0].message.find("on one line"), std::string::npos);
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
    EXPECT_EQ(d.place, (Place{kFeaturesFrom, 5}));
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
  EXPECT_EQ(q.points, (std::vector<Vec2>{{10, 10}, {30, 10}, {30, 15}, {10, 15}, {10, 10}}));
  EXPECT_TRUE(q.closed);
  EXPECT_EQ(q.corner_tolerance, 0.1);
  const Bead& p = std::get<Bead>(r->features[1]);
  EXPECT_EQ(p.points.size(), 4u);
  EXPECT_EQ(p.points.front(), p.points.back());
  EXPECT_EQ(p.corner_tolerance, 0);
  EXPECT_FALSE(std::get<Bead>(r->features[2]).closed);
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
        Wrong{"  - {}\n", Fault::BadValue, "{}", "one key"},
        Wrong{"  - dot: {name: d, material: glue, at: [1 mm, 5 mm]}\n    line: {name: e, material: glue, from: [1 mm, "
              "1 mm], to: [2 mm, 2 mm]}\n",
              Fault::BadValue, "line", "one key"},
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
