#include "sim/world/deposits.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "sim/world/near_line.hpp"
#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

std::shared_ptr<const Shot> shot(std::vector<Vec3> path) {
  auto s = std::make_shared<Shot>();
  s->path = std::move(path);
  s->opened_cycle = 1, s->closed_cycle = 2;
  return s;
}

/// So high over the line.
std::vector<Vec3> along(const std::vector<Vec3>& line, Vec2 by = {}, double over = 0.3, double step = 0.05) {
  std::vector<Vec3> out;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec3 d = line[i] - line[i - 1];
    const int n = static_cast<int>(std::ceil(norm(d) / step));
    for (int k = i == 1 ? 0 : 1; k <= n; ++k)
      out.push_back(line[i - 1] + d * (static_cast<double>(k) / n) + Vec3{by.x, by.y, over});
  }
  return out;
}

/// The judge: both curves sampled densely, largest of the nearest distances, both ways, and the ends.
double brute_force(std::span<const Vec3> path, const std::vector<Vec3>& nominal) {
  const auto line = along(nominal, {}, 0, 0.01);
  double worst = std::max(std::hypot(path.front().x - nominal.front().x, path.front().y - nominal.front().y),
                          std::hypot(path.back().x - nominal.back().x, path.back().y - nominal.back().y));
  for (const Vec3& p : path) {
    double best = 1e9;
    for (const Vec3& l : line) best = std::min(best, std::hypot(p.x - l.x, p.y - l.y));
    worst = std::max(worst, best);
  }
  for (const Vec3& c : nominal) {
    double best = 1e9;
    for (std::size_t i = 1; i < path.size(); ++i)
      for (int k = 0; k <= 50; ++k) {
        const Vec3 p = path[i - 1] + (path[i] - path[i - 1]) * (k / 50.0);
        best = std::min(best, std::hypot(p.x - c.x, p.y - c.y));
      }
    worst = std::max(worst, best);
  }
  return worst;
}

TEST(Deposits, path_error_agrees_with_brute_force_on_random_paths) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(0, 10), wobble(-0.3, 0.3);
  for (int n = 0; n < 40; ++n) {
    std::vector<Vec3> nominal;
    for (int k = 0; k < 4; ++k) nominal.push_back({place(random), place(random), 0});
    auto path = along(nominal, {}, 0.3, 0.5);
    for (Vec3& p : path) p.x += wobble(random), p.y += wobble(random);
    EXPECT_NEAR(path_error(path, nominal), brute_force(path, nominal), 0.01) << "case " << n;
  }
}

/// Out at 0 and back at 0.6 over the same line, and two turns of a screw: each pass has its own height.
TEST(Deposits, a_line_that_leads_over_one_place_at_two_heights_is_measured_where_it_has_come_to) {
  std::vector<Vec3> there_and_back{{10, 10, 0}, {40, 10, 0}, {40, 10, 0.6}, {10, 10, 0.6}}, screw;
  for (int i = 0; i <= 144; ++i) {
    const double angle = i * 5 * 3.14159265358979 / 180;
    screw.push_back({30 + 10 * std::cos(angle), 30 + 10 * std::sin(angle), 0.6 * i / 72});
  }
  const auto needle = [](const std::vector<Vec3>& nominal, auto off_mm) {
    std::vector<Vec3> path;
    for (std::size_t i = 1; i < nominal.size(); ++i)
      for (int k = 0; k < 20; ++k) {
        const double along = (static_cast<double>(i) - 1 + k / 20.0) / static_cast<double>(nominal.size() - 1);
        path.push_back(nominal[i - 1] + (nominal[i] - nominal[i - 1]) * (k / 20.0) + Vec3{0, 0, 0.3 + off_mm(along)});
      }
    return path;
  };
  for (const auto& nominal : {there_and_back, screw}) {
    EXPECT_NEAR(gap_error(needle(nominal, [](double) { return 0.0; }), nominal, 0.3), 0, 1e-9);
    // On the first pass as high as the second is to be.
    const double high =
        gap_error(needle(nominal, [](double a) { return a > 0.1 && a < 0.2 ? 0.6 : 0.0; }), nominal, 0.3);
    EXPECT_NEAR(high, 0.6, 1e-9);
  }
}

/// Up along a line and back down or on up over it, all of it higher or lower than it is to be, and turned a little
/// before the tip.
TEST(Deposits, a_needle_that_goes_back_over_its_line_is_measured_on_the_way_back) {
  for (const double off_mm : {-0.25, -0.08, 0.0, 0.03, 0.08, 0.25})
    for (const double tip_mm : {0.0, 0.02, 0.3, 1.0})
      for (const auto& heights : {std::array{0.0, 0.5, 1.0}, {1.0, 0.5, 0.0}, {0.0, 0.5, 0.0}, {0.0, 0.0, 0.5}}) {
        const std::vector<Vec3> line{{10, 10, heights[0]}, {35, 10, heights[1]}, {10, 10, heights[2]}};
        std::vector<Vec3> path;
        const auto go = [&](std::size_t leg, double from, double to) {
          for (double x = from; std::abs(x - to) > 0.04; x += from < to ? 0.05 : -0.05) {
            const double along = leg == 0 ? (x - 10) / 25 : (35 - x) / 25;
            path.push_back({x, 10, heights[leg] + (heights[leg + 1] - heights[leg]) * along + 0.4 + off_mm});
          }
        };
        go(0, 10, 35 - tip_mm), go(1, 35 - tip_mm, 10);
        // On the way back to where a tip was left out its foot is on the leg before for 0.1 mm.
        EXPECT_NEAR(gap_error(path, line, 0.4), off_mm, 0.005 + 0.04 * (tip_mm + 0.2))
            << off_mm << " " << tip_mm << " " << heights[1] << " " << heights[2];
      }
}

/// A screw that widens by 0.05 mm a turn, and a needle 0.1 mm outside of it: nearer to the pass above than to its own.
TEST(Deposits, a_needle_beside_its_pass_is_measured_on_it_though_another_one_is_nearer) {
  std::vector<Vec3> screw, path;
  for (int i = 0; i <= 144; ++i) {
    const double angle = i * 5 * 3.14159265358979 / 180, radius = 10 + 0.05 * i / 72;
    const Vec3 out{std::cos(angle), std::sin(angle), 0};
    screw.push_back(Vec3{30, 30, 2.0 * i / 72} + out * radius);
    path.push_back(screw.back() + out * 0.1 + Vec3{0, 0, 0.3});
  }
  EXPECT_NEAR(gap_error(path, screw, 0.3), 0, 0.005);
}

TEST(Deposits, each_shot_takes_its_own_feature_and_reports_lateral_and_gap_error) {
  const BoardPlan plan = board_plan(sample::recipe());
  const auto d =
      judge(plan, std::vector{shot({{20.01, 20, 0.31}}), shot(along(plan.features[2].points, {0.02, 0}, 0.28)),
                              shot({{25, 19.98, 0.3}, {25, 19.98, 0.33}})});
  ASSERT_EQ(d.size(), 3u);
  EXPECT_EQ(d[0].id, "d1");
  EXPECT_EQ(d[0].kind, "dot");
  EXPECT_NEAR(d[0].error_mm, 0.01, 1e-12);
  EXPECT_NEAR(d[0].gap_mm, 0.31, 1e-12);
  ASSERT_EQ(d[0].nominal_mm.size(), 1u);
  EXPECT_EQ(d[0].nominal_mm[0], (Vec3{20, 20, 0.3}));
  EXPECT_EQ(d[1].id, "b1");
  EXPECT_EQ(d[1].kind, "bead");
  EXPECT_NEAR(d[1].error_mm, 0.02, 1e-9);
  EXPECT_NEAR(d[1].gap_mm, 0.28, 1e-12);
  EXPECT_EQ(d[2].id, "d2");
  EXPECT_NEAR(d[2].gap_mm, 0.33, 1e-12) << "the needle rose while the valve was open";
  EXPECT_EQ(d[2].board_mm.size(), 1u) << "of a dot the place at opening";
}

TEST(Deposits, of_a_bead_over_a_ramp_the_gap_is_over_the_ramp) {
  BoardPlan plan;
  plan.features.push_back({"ramp", true, {{10, 10, 0}, {20, 10, 4}, {20, 20, 4}}, 0.3});
  const auto d = judge(plan, std::vector{shot(along(plan.features[0].points, {}, 0.31))});
  ASSERT_EQ(d.size(), 1u);
  EXPECT_EQ(d[0].id, "ramp");
  EXPECT_NEAR(d[0].error_mm, 0, 1e-9);
  EXPECT_NEAR(d[0].gap_mm, 0.31, 1e-9);
  EXPECT_EQ(d[0].asked_gap_mm, 0.3);
  EXPECT_EQ(d[0].nominal_mm[1], (Vec3{20, 10, 4.3}));
}

TEST(Deposits, the_nearest_of_ten_thousand_chords_is_the_nearest_of_all) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> step(0, 0.5);
  std::vector<Vec3> line{{0, 0, 0}};
  for (int i = 0; i < 3000; ++i) line.push_back(line.back() + Vec3{step(random), step(random), step(random)});
  const NearLine found(line);
  std::size_t near = 0;
  for (int n = 0; n < 300; ++n) {
    const Vec3 at = line[static_cast<std::size_t>(random() % line.size())];
    const Vec2 p{at.x + 3 * step(random), at.y + 3 * step(random)};
    double best = 1e9;
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Vec2 a = flat(line[i - 1]), leg = flat(line[i]) - a;
      const double t = std::clamp(dot(p - a, leg) / dot(leg, leg), 0.0, 1.0);
      best = std::min(best, norm(p - (a + leg * t)));
    }
    ASSERT_NEAR(found.foot(p, near).distance_mm, best, 1e-12) << "seed 7, case " << n;
  }
}

TEST(Deposits, a_bead_that_was_cut_short_keeps_its_id_and_shows_how_far_its_end_is) {
  const BoardPlan plan = board_plan(sample::recipe());
  const auto d = judge(plan, std::vector{shot(along({{30, 60}, {45, 60}}))});
  ASSERT_EQ(d.size(), 1u);
  EXPECT_EQ(d[0].id, "b1");
  EXPECT_NEAR(d[0].error_mm, std::hypot(15, 10), 1e-9);
}

// b1 goes from (30, 60) over (60, 60) to (60, 70). What is missing is along it; what lies twice is negative.
TEST(Deposits, what_goes_on_where_a_bead_was_cut_is_a_part_of_it) {
  const BoardPlan plan = board_plan(sample::recipe());
  const auto d =
      judge(plan, std::vector{shot(along({{30, 60}, {45, 60}})), shot({{20, 20, 0.3}}),
                              shot(along({{45.1, 60}, {52, 60}})), shot(along({{51.96, 60}, {60, 60}, {60, 70}}))});
  ASSERT_EQ(d.size(), 2u);
  EXPECT_EQ(d[0].id, "b1");
  EXPECT_EQ(d[1].id, "d1");
  ASSERT_EQ(d[0].joins_mm.size(), 2u);
  EXPECT_NEAR(d[0].joins_mm[0], 0.1, 1e-9);
  EXPECT_NEAR(d[0].joins_mm[1], -0.04, 1e-9);
  EXPECT_NEAR(d[0].error_mm, 0, 1e-9);
  EXPECT_TRUE(d[1].joins_mm.empty());
}

// A drop that a stop has let out before b1 begins, and all of b1: nothing is missing of it, and it starts too early.
TEST(Deposits, a_drop_in_front_of_a_bead_is_none_of_it) {
  const BoardPlan plan = board_plan(sample::recipe());
  for (const double begins_mm : {0.0, 0.3, -0.1}) {
    const auto d = judge(plan, std::vector{shot({{29.7, 60, 0.3}, {29.8, 60, 0.3}}),
                                           shot(along({{30 + begins_mm, 60}, {60, 60}, {60, 70}}))});
    ASSERT_EQ(d.size(), 1u);
    EXPECT_EQ(d[0].id, "b1");
    ASSERT_EQ(d[0].joins_mm.size(), 1u);
    EXPECT_NEAR(d[0].joins_mm[0], begins_mm, 1e-9);
    EXPECT_NEAR(d[0].error_mm, 0.3, 1e-9);
  }
}

TEST(Deposits, a_closed_bead_that_was_cut_where_it_begins_goes_on) {
  BoardPlan plan = board_plan(sample::recipe());
  const std::vector<Vec3> square{{60, 60, 0}, {70, 60, 0}, {70, 70, 0}, {60, 70, 0}, {60, 60, 0}};
  plan.features[2].points = square;
  for (const double cut_mm : {0.0, 1e-4, 0.02, 0.2}) {
    SCOPED_TRACE(cut_mm);
    std::vector<Vec3> rest = square;
    rest.front().x += cut_mm;
    const auto d = judge(plan, std::vector{shot({{60, 60, 0.3}, {60 + cut_mm, 60, 0.3}}), shot(along(rest))});
    ASSERT_EQ(d.size(), 1u);
    ASSERT_EQ(d[0].joins_mm.size(), 1u);
    EXPECT_NEAR(d[0].joins_mm[0], 0, 1e-9);
    EXPECT_NEAR(d[0].error_mm, 0, 1e-9);
    const auto alone = judge(plan, std::vector{shot({{60, 60, 0.3}, {60 + cut_mm, 60, 0.3}})});
    EXPECT_GT(alone.at(0).error_mm, 9) << "of what was never dispensed";
  }
}

// b1 ends at (60, 70). What lies within 0.05 mm of its end counts as whole, and may still be finished.
TEST(Deposits, what_little_was_missing_of_a_bead_is_a_part_of_it) {
  const BoardPlan plan = board_plan(sample::recipe());
  const auto almost = shot(along({{30, 60}, {60, 60}, {60, 69.96}}));
  const auto d = judge(plan, std::vector{almost, shot({{60, 69.96, 0.3}, {60, 70, 0.3}})});
  ASSERT_EQ(d.size(), 1u);
  ASSERT_EQ(d[0].joins_mm.size(), 1u);
  EXPECT_NEAR(d[0].error_mm, 0, 1e-9);
  // The same where that is cut again, however soon.
  const auto in_pieces =
      judge(plan, std::vector{almost, shot({{60, 69.96, 0.3}, {60, 69.972, 0.3}}),
                              shot({{60, 69.972, 0.3}, {60, 69.9726, 0.3}}),
                              shot({{60, 69.9726, 0.3}, {60, 69.998, 0.3}}), shot({{60, 69.998, 0.3}, {60, 70, 0.3}})});
  ASSERT_EQ(in_pieces.size(), 1u);
  EXPECT_EQ(in_pieces[0].joins_mm.size(), 4u);
  // What is missing is not a feature's that begins near there.
  BoardPlan near = plan;
  near.features.push_back({"dot", false, {{61, 70}}, 0.3});
  near.features.push_back({"bead", true, {{60, 70}, {70, 70}}, 0.3});
  const auto beside = judge(near, std::vector{almost, shot({{60, 69.96, 0.3}, {60, 70, 0.3}}), shot({{61, 70, 0.3}}),
                                              shot(along({{60, 70}, {70, 70}}))});
  ASSERT_EQ(beside.size(), 3u);
  EXPECT_EQ(beside[1].id, "dot");
  EXPECT_EQ(beside[2].id, "bead");
  for (const auto& each : beside) EXPECT_NEAR(each.error_mm, 0, 1e-9) << each.id;
  // Nothing is missing of this one, and what lies there is a stray dot.
  EXPECT_EQ(judge(plan, std::vector{shot(along({{30, 60}, {60, 60}, {60, 69.9998}})), shot({{60, 70, 0.3}})}).size(),
            2u);
  // A dot there, one that leads back, one that goes beyond and one that is higher are something else.
  for (const std::vector<Vec3>& other :
       {std::vector<Vec3>{{60, 69.96, 0.3}, {60, 69.96, 0.3}}, std::vector<Vec3>{{60, 69.96, 0.3}, {60, 69.9, 0.3}},
        along({{60, 69.96}, {60, 70.4}}), std::vector<Vec3>{{60, 69.96, 5.3}, {60, 70, 5.3}}})
    EXPECT_EQ(judge(plan, std::vector{almost, shot(other)}).size(), 2u);
}

TEST(Deposits, what_does_not_follow_a_cut_bead_is_not_a_part_of_it) {
  const BoardPlan plan = board_plan(sample::recipe());
  for (const std::vector<Vec3>& other : {along({{46.5, 60}, {60, 60}}), along({{45.1, 60}, {45.1, 66}})}) {
    const auto d = judge(plan, std::vector{shot(along({{30, 60}, {45, 60}})), shot(other)});
    ASSERT_EQ(d.size(), 2u);
    EXPECT_EQ(d[1].id, "");
    EXPECT_TRUE(d[0].joins_mm.empty());
  }
  // A whole bead has nothing that could go on.
  const auto twice = judge(plan, std::vector{shot(along(plan.features[2].points)), shot(along({{60, 70}, {60, 69}}))});
  EXPECT_EQ(twice.size(), 2u);
}

TEST(Deposits, a_second_shot_on_a_dot_and_a_stray_shot_have_no_id) {
  const BoardPlan plan = board_plan(sample::recipe());
  const auto d = judge(
      plan, std::vector{shot({{20, 20, 0.3}}), shot({{20, 20, 0.3}}), shot({{90, 30, 0.3}}), shot({{25, 20, 0.3}})});
  ASSERT_EQ(d.size(), 4u);
  EXPECT_EQ(d[0].error_mm, 0);
  EXPECT_TRUE(std::isnan(d[1].error_mm) && std::isnan(d[2].error_mm)) << "there is nothing to compare them with";
  EXPECT_EQ(d[0].id, "d1");
  EXPECT_EQ(d[1].id, "") << "must not steal the neighbour d2";
  EXPECT_EQ(d[2].id, "");
  EXPECT_EQ(d[3].id, "d2");
}

TEST(Deposits, two_features_at_one_place_are_both_found) {
  BoardPlan plan = board_plan(sample::recipe());
  plan.features.push_back({"again", false, {{20, 20}}, 0.3});
  plan.features.push_back({"start", false, {{30, 60}}, 0.3});
  const auto d = judge(plan, std::vector{shot({{20, 20, 0.3}}), shot({{20, 20, 0.3}}), shot({{30, 60, 0.3}}),
                                         shot(along(plan.features[2].points))});
  EXPECT_EQ(d[0].id, "d1");
  EXPECT_EQ(d[1].id, "again");
  EXPECT_EQ(d[2].id, "start") << "a dot on the start of a bead is the dot";
  EXPECT_EQ(d[3].id, "b1");
}

TEST(Deposits, the_feature_that_begins_nearest_is_found_as_by_looking_at_all) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(0, 30);
  BoardPlan plan;
  for (int i = 0; i < 300; ++i)
    plan.features.push_back({std::to_string(i), false, {{place(random), place(random)}}, 0.3});
  const Starts starts = starts_of(plan);
  for (int n = 0; n < 2000; ++n) {
    const Vec2 at{place(random) * 1.5 - 8, place(random) * 1.5 - 8};
    int best = -1;
    double nearest = kMatch_mm;
    for (std::size_t i = 0; i < plan.features.size(); ++i)
      if (const double d = norm(at - flat(plan.features[i].points.front())); d < nearest)
        nearest = d, best = static_cast<int>(i);
    ASSERT_EQ(feature_begun(plan, starts, at), best) << "seed 11, case " << n;
  }
}

TEST(Deposits, of_a_hundred_thousand_dots_are_judged_each_by_its_own) {
  BoardPlan plan;
  std::vector<std::shared_ptr<const Shot>> shots;
  for (int i = 0; i < 100'000; ++i) {
    const Vec2 at{0.1 * (i % 316), 0.05 * (i / 316)};
    plan.features.push_back({std::to_string(i), false, {{at.x, at.y, 0}}, 0.3});
    shots.push_back(shot({{at.x + 0.001, at.y, 0.3}}));
  }
  const auto d = judge(plan, shots);
  for (std::size_t i = 0; i < d.size(); ++i) ASSERT_EQ(d[i].id, plan.features[i].id);
}

TEST(Deposits, csv_has_one_line_each_and_quotes_ids) {
  BoardPlan plan = board_plan(sample::recipe());
  plan.features[0].id = "odd \"id\", with comma";
  const auto d = judge(plan, std::vector{shot({{20, 20, 0.3}}), shot(along(plan.features[2].points))});
  const auto path = std::filesystem::path(sample::temporary("gantry-deposits-test.csv"));
  ASSERT_TRUE(write_csv(d, path.string()));
  std::ifstream in(path);
  std::string line;
  std::vector<std::string> lines;
  while (std::getline(in, line)) lines.push_back(line);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[1].starts_with("\"odd \"\"id\"\", with comma\",dot,1,2,0.000000,0.300000,")) << lines[1];
  std::filesystem::remove(path);
  EXPECT_FALSE(write_csv(d, "/nonexistent/deposits.csv"));
}

}  // namespace
}  // namespace gantry::sim
