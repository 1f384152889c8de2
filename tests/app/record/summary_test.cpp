#include "app/record/summary.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "app/record/report.hpp"
#include "tests/app/record/made_up_job.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

using nlohmann::json;

json parsed(const std::string& path) {
  std::ifstream in(path);
  return json::parse(in);
}

TEST(Summary, carries_every_key_that_a_judge_of_the_job_reads) {
  const Folder folder;
  ASSERT_TRUE(write_summary(folder.path, made_up_job()));
  const auto j = parsed(folder.path + "/summary.json");
  EXPECT_EQ(j.at("job"), "demo-board-0001");
  EXPECT_EQ(j.at("result"), "done");
  EXPECT_EQ(j.at("exit_code"), 0);
  EXPECT_TRUE(j.at("errors").empty());
  EXPECT_EQ(j.at("counts").at("features_done"), 30);
  EXPECT_EQ(j.at("counts").at("dots"), 24);
  EXPECT_EQ(j.at("counts").at("beads"), 6);
  EXPECT_EQ(j.at("marks").size(), 4u);
  for (const char* key : {"name", "found", "nominal_mm", "measured_mm", "residual_mm", "attempts"})
    EXPECT_TRUE(j.at("marks")[0].contains(key)) << key;
  EXPECT_DOUBLE_EQ(j.at("work_offset").at("dx_mm"), 1.3);
  EXPECT_DOUBLE_EQ(j.at("work_offset").at("dy_mm"), -0.7);
  EXPECT_NEAR(j.at("work_offset").at("rot_deg").get<double>(), 0.8, 1e-12);
  for (const char* key : {"name", "at_mm", "height_mm", "residual_mm"})
    EXPECT_TRUE(j.at("heights")[0].contains(key)) << key;
  EXPECT_GT(j.at("predicted_s").get<double>(), 0);
  EXPECT_GT(j.at("actual_s").get<double>(), 0);
  EXPECT_DOUBLE_EQ(j.at("max_following_error").at("X"), 0.0123);
  EXPECT_EQ(j.at("max_following_error").at("C"), "n/a");
  EXPECT_DOUBLE_EQ(j.at("max_following_error_allowed").at("X"), 2.5);
  EXPECT_TRUE(j.at("max_following_error_allowed").at("C").is_null());
  EXPECT_EQ(j.at("cycle").at("cycles"), 61234);
  EXPECT_EQ(j.at("cycle").at("deadline_misses"), 0);
  for (const char* key : {"p50", "p99", "p99_9", "max"}) EXPECT_TRUE(j.at("cycle").at("wake_us").contains(key)) << key;
  EXPECT_DOUBLE_EQ(j.at("cycle").at("wake_us").at("max"), 133.0);
  EXPECT_EQ(j.at("collisions"), 0);
  EXPECT_TRUE(j.at("collision_list").empty());
  EXPECT_EQ(j.at("setpoint_hash"), "0x3f9ac27780be1d05");
  EXPECT_EQ(j.at("certificate").at("motions_certified"), 148);
  EXPECT_EQ(j.at("files"), json::array({"summary.json"}));
}

TEST(Summary, a_job_that_ended_between_its_touches_tells_no_surface) {
  JobResult r = made_up_job();
  r.has_surface = false, r.surface = {};
  const Folder folder;
  ASSERT_TRUE(write_summary(folder.path, r));
  const auto j = parsed(folder.path + "/summary.json");
  EXPECT_FALSE(j.at("heights").empty());
  EXPECT_TRUE(j.at("surface").is_null()) << j.at("surface");
}

TEST(Summary, deposits_have_exactly_the_agreed_members) {
  const json j = to_json(made_up_job());
  ASSERT_EQ(j.at("deposits").size(), 30u);
  const std::set<std::string> agreed{"id", "kind", "nominal_mm", "board_mm", "error_mm", "gap_mm", "open_ms"};
  for (const auto& d : j.at("deposits")) {
    std::set<std::string> keys;
    for (const auto& [key, value] : d.items()) keys.insert(key);
    EXPECT_EQ(keys, agreed);
    EXPECT_EQ(d.at("nominal_mm")[0].size(), 3u);
  }
}

TEST(Summary, tells_times_as_forecast_and_as_taken_and_how_steady_a_bead_was) {
  auto r = made_up_job();
  r.steps = {{.what = "park", .predicted_s = 1.25, .actual_s = 1.26, .done = true},
             {.what = "purge", .predicted_s = {}}};
  r.feature_names = {"left_out", "seam"};
  r.feature_times.resize(2);
  r.feature_times[1].predicted = {.travel_s = 0.3, .on_it_s = 5};
  r.deposits.back().speed = {
      .asked_mm_s = 20, .least_mm_s = 8, .most_mm_s = 21, .within_5_percent = 0.8, .volume_per_length = 1.25};
  const json j = to_json(r);
  EXPECT_EQ(j.at("steps")[0],
            json({{"what", "park"}, {"predicted_s", 1.25}, {"actual_s", 1.26}, {"done", true}, {"disturbed", false}}));
  EXPECT_TRUE(j.at("steps")[1].at("predicted_s").is_null());
  ASSERT_EQ(j.at("feature_times").size(), 1u);
  EXPECT_EQ(j.at("feature_times")[0].at("id"), "seam");
  EXPECT_EQ(j.at("feature_times")[0].at("travel_predicted_s"), 0.3);
  const json& told = j.at("deposits").back();
  EXPECT_EQ(told.at("speed_mm_s"), json({{"asked", 20}, {"min", 8}, {"max", 21}}));
  EXPECT_EQ(told.at("within_5_percent"), 0.8);
  EXPECT_EQ(told.at("volume_per_length"), 1.25);
}

/// A bead of twenty minutes has 1.2 million points; the summary stays small, and deposits.csv has them all.
TEST(Summary, tells_no_more_points_of_beads_than_can_be_read_at_once) {
  JobResult r = made_up_job();
  const auto bead = [](std::size_t count) {
    Deposit d{.id = "long", .kind = "bead", .nominal_mm = {}, .board_mm = {}};
    for (std::size_t i = 0; i < count; ++i) d.board_mm.push_back({0.002 * static_cast<double>(i), 5, 0.3});
    return d;
  };
  r.deposits = {bead(2), bead(90'000)};
  json j = to_json(r);
  EXPECT_EQ(j.at("deposits")[1].at("board_mm").size(), 90'000u) << "all of them";
  r.deposits.push_back(bead(1'200'000));
  j = to_json(r);
  EXPECT_EQ(j.at("deposits")[0].at("board_mm").size(), 2u) << "its ends";
  const json& told = j.at("deposits")[2].at("board_mm");
  EXPECT_LE(told.size(), 100'000u);
  EXPECT_GE(told.size(), 80'000u);
  EXPECT_EQ(told.front(), json::array({0.0, 5.0, 0.3}));
  EXPECT_NEAR(told.back()[0].get<double>(), 0.002 * 1'199'999, 1e-6);
  EXPECT_LT(j.dump().size(), 6'000'000u);
}

TEST(Summary, tells_the_lengths_of_beads_the_areas_of_fills_and_the_files_of_the_recipe) {
  JobResult r = made_up_job();
  r.beads = {{"L", "polyline", 38}, {"f[0]", "fill", 10}, {"f[1]", "fill", 5}, {"g", "fill", 7}, {"dry", "arc", 3}};
  r.fills = {{"f", 120, 2, 1, 2, 0, 0, {}}, {"g", 30, 1, 3, 1, 0, 0, {}}};
  r.sources = {{"r.yaml", 100, "ab"}, {"p.csv", 7, "01"}};
  r.deposits.push_back({.id = "f[0]", .kind = "bead", .nominal_mm = {}, .board_mm = {{0, 0, 0}, {6, 0, 0}, {6, 3, 0}}});
  r.deposits.push_back({.id = "f[1]", .kind = "bead", .nominal_mm = {}, .board_mm = {{0, 0, 0}, {0, 3, 4}}});
  const json j = to_json(r);
  const auto& rows = j.at("lengths");
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].at("name"), "L");
  EXPECT_NEAR(rows[0].at("dispensed_mm").get<double>(), 38, 0.2);
  EXPECT_FALSE(rows[0].contains("area_mm2"));
  EXPECT_EQ(rows[1], (json{{"name", "f"},
                           {"kind", "fill"},
                           {"length_mm", 15.0},
                           {"dispensed_mm", 14.0},
                           {"area_mm2", 120.0},
                           {"spacing_mm", 2.0},
                           {"beads", 2}}));
  EXPECT_EQ(rows[2].at("name"), "g");
  EXPECT_EQ(rows[2].at("area_mm2"), 30.0);
  EXPECT_EQ(rows[3].at("name"), "dry");
  EXPECT_TRUE(rows[3].at("dispensed_mm").is_null());
  EXPECT_EQ(j.at("sources")[1], (json{{"file", "p.csv"}, {"bytes", 7}, {"sha256", "01"}}));
  const std::string page = report_page(r);
  for (const char* words : {"120.0", "f (2 beads)", "p.csv, SHA-256 01"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
}

TEST(Summary, a_failure_names_code_place_and_remedy) {
  const json j = to_json(made_up_failure());
  EXPECT_EQ(j.at("result"), "failed");
  EXPECT_EQ(j.at("exit_code"), 5);
  const auto& e = j.at("errors")[0];
  EXPECT_EQ(e.at("code"), "G200");
  EXPECT_EQ(e.at("name"), "DriveFault");
  EXPECT_EQ(e.at("where"), "station 2 'y1'");
  EXPECT_FALSE(e.at("remedy").get<std::string>().empty());
  EXPECT_EQ(j.at("collisions"), 1);
  EXPECT_EQ(j.at("collision_list")[0].at("moving"), "needle");
}

TEST(Summary, stays_valid_json_whatever_the_numbers_and_names_are) {
  const Folder folder;
  auto r = made_up_job();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  r.predicted_s = nan;
  r.minimum_clearance.others->distance_mm = std::numeric_limits<double>::infinity();
  r.deposits[0].error_mm = nan;
  r.axes[0].max_following = nan;
  r.marks[0].name = "bad \xff utf-8 \"quoted\"\n";
  r.job = std::string("nul \0 inside", 12);
  ASSERT_TRUE(write_summary(folder.path, r));
  const auto j = parsed(folder.path + "/summary.json");
  EXPECT_TRUE(j.at("predicted_s").is_null());
  EXPECT_TRUE(j.at("deposits")[0].at("error_mm").is_null());
  EXPECT_EQ(j.at("max_following_error").at("X"), "n/a");
  EXPECT_NO_THROW(static_cast<void>(to_json(r).dump()));
}

TEST(Summary, an_empty_result_is_a_summary_too) {
  const json j = to_json(JobResult{});
  EXPECT_EQ(j.at("result"), "done");
  EXPECT_TRUE(j.at("work_offset").is_null());
  EXPECT_TRUE(j.at("deposits").is_null());
  EXPECT_TRUE(j.at("setpoint_hash").is_null());
  EXPECT_TRUE(j.at("certificate").at("minimum_clearance").at("by_design").is_null());
  EXPECT_TRUE(j.at("certificate").at("minimum_clearance").at("others").is_null());
}

TEST(Summary, the_nearest_pairs_are_two_each_with_pair_motion_line_and_both_frames) {
  const json both = to_json(made_up_job()).at("certificate").at("minimum_clearance");
  const json& design = both.at("by_design");
  EXPECT_EQ(design.at("distance_mm"), 0.25);
  EXPECT_EQ(design.at("pair"), json::array({"needle", "board"}));
  const json& others = both.at("others");
  EXPECT_EQ(others.at("distance_mm"), 2.31);
  EXPECT_EQ(others.at("pair"), json::array({"needle", "relay"}));
  EXPECT_EQ(others.at("motion"), "along bead 'seam'");
  EXPECT_EQ(others.at("where"), "recipes/made-up.yaml:40:5");
  EXPECT_EQ(others.at("at_mm"), json::array({10.0, 20.0, 3.0}));
  EXPECT_EQ(others.at("machine_mm"), json::array({190.0, 170.0, -107.0}));
}

TEST(Summary, interrupted_and_aborted_jobs_are_told_apart) {
  JobResult r;
  r.exit_code = ExitCode::Interrupted;
  EXPECT_EQ(result_word(r), "interrupted");
  r.exit_code = ExitCode::Refused;
  r.errors = {{Fault::Aborted, "", ""}};
  EXPECT_EQ(result_word(r), "aborted");
  r.errors.push_back({Fault::DriveFault, "", ""});
  EXPECT_EQ(result_word(r), "aborted") << "what came of it";
  std::swap(r.errors[0], r.errors[1]);
  EXPECT_EQ(result_word(r), "failed") << "a drive's fault ended it, whatever somebody pressed then";
}

TEST(Summary, a_folder_that_cannot_be_written_is_told) {
  const auto w = write_summary("/proc/no/such", JobResult{});
  ASSERT_FALSE(w);
  EXPECT_EQ(w.error().fault, Fault::FileUnwritable);
}

}  // namespace
}  // namespace gantry::record
