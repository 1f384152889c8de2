#include "app/record/bead_speed_file.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <vector>

#include "config/inputs.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

recipes::Recipe dot_and_bead() {
  recipes::Recipe recipe;
  recipes::Material glue;
  glue.name = "glue";
  glue.speed = 20;
  recipe.materials = {glue};
  recipes::Dot dot;
  dot.id = "d", dot.material = "glue";
  recipes::Bead bead;
  bead.id = "b", bead.material = "glue";
  recipe.features = {dot, bead};
  return recipe;
}

struct Row {
  std::string feature;
  double t_s = 0, speed = 0;
  bool valve = false;
};

std::vector<Row> rows_of(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "feature,t_s,speed_mm_s,valve");
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    Row row;
    std::istringstream text(line);
    std::string t, v, open;
    std::getline(text, row.feature, ','), std::getline(text, t, ','), std::getline(text, v, ','),
        std::getline(text, open);
    row.t_s = std::stod(t), row.speed = std::stod(v), row.valve = open == "1";
    rows.push_back(row);
  }
  return rows;
}

TEST(BeadSpeedFile, gives_back_the_speed_of_every_cycle_of_a_bead_from_few_rows) {
  const Folder folder;
  const std::string path = folder.path + "/bead_speeds.csv";
  const recipes::Recipe recipe = dot_and_bead();
  const std::int64_t start_ns = 5'000'000'000;
  std::vector<cycle::Snapshot> stream;
  const auto add = [&](std::uint32_t block, std::uint32_t feature, double speed, bool open) {
    cycle::Snapshot s = tick_of(block, 1);
    s.time_ns = start_ns + static_cast<std::int64_t>(stream.size()) * 1'000'000;
    s.feature = feature, s.path_speed = speed;
    s.outputs = open ? config::bit(config::Output::Valve) : 0;
    stream.push_back(s);
  };
  for (int i = 0; i < 10; ++i) add(1, motion::kTravel, 300, false);
  for (int i = 0; i < 30; ++i) add(1, 0, 0, i > 5);
  // Speeds up, is steady with a slow ripple of 0.2 %, slows in a corner, and is steady again.
  for (int i = 0; i < 2000; ++i) {
    double v = i < 50 ? 0.4 * i : 20 + 0.04 * std::sin(0.01 * i);
    if (i >= 1000 && i < 1100) v = 20 - 10 * std::sin(M_PI * (i - 1000) / 100);
    add(1, 1, v, i >= 50 && i < 1990);
  }
  for (int i = 0; i < 10; ++i) add(1, motion::kTravel, 300, false);
  BeadSpeedFile file(path, recipe, start_ns);
  for (const cycle::Snapshot& s : stream) file.add(s);
  ASSERT_TRUE(file.close());

  const std::vector<Row> rows = rows_of(path);
  ASSERT_GT(rows.size(), 50u);
  EXPECT_LT(rows.size(), 300u);
  for (const Row& row : rows) EXPECT_EQ(row.feature, "b");
  EXPECT_NEAR(rows.front().t_s, 0.040, 1e-9);
  EXPECT_NEAR(rows.back().t_s, 2.039, 1e-9);
  std::size_t at = 0;
  for (const cycle::Snapshot& s : stream) {
    if (s.feature != 1) continue;
    const double t_s = static_cast<double>(s.time_ns - start_ns) * 1e-9;
    while (at + 1 < rows.size() && rows[at + 1].t_s <= t_s + 1e-9) ++at;
    EXPECT_NEAR(rows[at].speed, s.path_speed, BeadSpeedFile::kChange * 20 + 1e-4) << t_s;
    EXPECT_EQ(rows[at].valve, s.outputs != 0) << t_s;
  }
}

TEST(BeadSpeedFile, of_a_job_that_ends_on_a_bead_has_its_last_cycle) {
  const Folder folder;
  const std::string path = folder.path + "/bead_speeds.csv";
  const recipes::Recipe recipe = dot_and_bead();
  BeadSpeedFile file(path, recipe, 0);
  for (int i = 0; i <= 100; ++i) {
    cycle::Snapshot s = tick_of(1, 1);
    s.time_ns = i * 1'000'000, s.feature = 1, s.path_speed = 20;
    file.add(s);
  }
  ASSERT_TRUE(file.close());
  const std::vector<Row> rows = rows_of(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].t_s, 0);
  EXPECT_NEAR(rows[1].t_s, 0.1, 1e-9);
}

}  // namespace
}  // namespace gantry::record
