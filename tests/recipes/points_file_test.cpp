#include "recipes/points_file.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/sha256.hpp"
#include "recipes/recipe.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::recipes {
namespace {

namespace fs = std::filesystem;

std::vector<Vec3> good(std::string_view csv) {
  config::Mistakes mistakes("p.csv");
  std::vector<Vec3> out;
  for (const auto& p : read_points(csv, mistakes)) out.push_back(p.value);
  for (const Error& e : mistakes.errors()) ADD_FAILURE() << to_text(e);
  return out;
}

TEST(PointsFile, reads_plane_and_spatial_points_however_the_editor_saved_them) {
  const std::vector<Vec3> plane{{1, 2, 0}, {3.5, -4e-1, 0}};
  EXPECT_EQ(good("x_mm,y_mm\n1,2\n3.5,-0.4\n"), plane);
  EXPECT_EQ(good("x,y\n1,2\n3.5,-4e-1"), plane) << "no line end after the last";
  EXPECT_EQ(good("\xEF\xBB\xBFx_mm,y_mm\r\n1,2\r\n3.5,-0.4\r\n"), plane) << "byte-order mark and CRLF";
  EXPECT_EQ(good("\n x_mm , y_mm \n\n 1 ,\t2\n\n3.5,-0.4\n\n"), plane) << "blanks and empty lines";
  EXPECT_EQ(good("x_mm,y_mm,z_mm\n1,2,3\n"), (std::vector<Vec3>{{1, 2, 3}}));
}

TEST(PointsFile, tells_every_mistake_with_line_and_column) {
  const auto says = [](std::string_view csv, Fault fault, const char* where, const char* words) {
    config::Mistakes mistakes("p.csv");
    read_points(csv, mistakes);
    const auto errors = mistakes.errors();
    ASSERT_EQ(errors.size(), 1u) << csv;
    EXPECT_EQ(errors[0].fault, fault) << to_text(errors[0]);
    EXPECT_EQ(errors[0].where, where) << to_text(errors[0]);
    EXPECT_NE(errors[0].message.find(words), std::string::npos) << to_text(errors[0]);
  };
  says("", Fault::MissingKey, "p.csv:1:1", "empty");
  says("\n\n", Fault::MissingKey, "p.csv:1:1", "empty");
  says("1,2\n3,4\n", Fault::BadValue, "p.csv:1:1", "x_mm,y_mm");
  says("x;y\n1;2\n", Fault::BadValue, "p.csv:1:1", "x_mm,y_mm");
  says("y,x\n1,2\n", Fault::BadValue, "p.csv:1:1", "x_mm,y_mm");
  says("x,y\n1;2\n3;4\n5;6\n", Fault::BadValue, "p.csv:2:2", "commas");
  says("x,y\n1,2\n3.0;4.0,5\n", Fault::BadValue, "p.csv:3:4", "commas");
  says("x,y\n1,two\n", Fault::BadValue, "p.csv:2:3", "'two'");
  says("x,y\n1, two\n", Fault::BadValue, "p.csv:2:4", "'two'");
  says("x,y\n1,2 mm\n", Fault::BadValue, "p.csv:2:3", "'2 mm'");
  says("x,y\n1,nan\n", Fault::BadValue, "p.csv:2:3", "'nan'");
  says("x,y\ninf,1\n", Fault::BadValue, "p.csv:2:1", "'inf'");
  says("x,y\n1e999,1\n", Fault::BadValue, "p.csv:2:1", "'1e999'");
  says("x,y\n1,\n", Fault::BadValue, "p.csv:2:3", "missing");
  says("x,y\n1\n", Fault::BadValue, "p.csv:2:1", "1 values");
  says("x,y\n1,2,3\n", Fault::BadValue, "p.csv:2:1", "3 values");
  says("x,y\n1,2,3,4,5,6,7,8,9\n", Fault::BadValue, "p.csv:2:1", "more than 4");
  says("x,y,z\n1,2,-1\n", Fault::OutOfRange, "p.csv:2:5", "0 mm .. 200 mm");
  says("x,y\n1,2001\n", Fault::OutOfRange, "p.csv:2:3", "2000");
  const std::string zero("x,y\n1,2\0\n", 9);
  says(zero, Fault::BadValue, "p.csv:2:3", "no number");
}

TEST(PointsFile, of_ten_million_points_ends_after_a_hundred_thousand) {
  std::string csv = "x,y\n";
  for (int i = 0; i < 100001; ++i) csv += "1,2\n";
  config::Mistakes mistakes("p.csv");
  EXPECT_EQ(read_points(csv, mistakes).size(), kMostPoints);
  ASSERT_EQ(mistakes.errors().size(), 1u);
  EXPECT_EQ(mistakes.errors()[0].where, "p.csv:100002:1");
}

/// A folder with a recipe in it, beside a file that is none of its business.
class BesideRecipe : public testing::Test {
 protected:
  BesideRecipe() : root_(fs::temp_directory_path() / ("gantry-points-" + std::to_string(::getpid()))) {
    fs::create_directories(root_ / "job" / "paths");
    write("secret.csv", "x,y\n1,2\n3,4\n");
    write("job/paths/p.csv", "x_mm,y_mm\n10,10\n20,10\n20,20.5\n");
  }
  ~BesideRecipe() override { fs::remove_all(root_); }

  void write(const std::string& name, const std::string& text) { std::ofstream(root_ / name) << text; }
  Checked<Recipe> with(const std::string& points_file, const std::string& more = "") {
    write("job/r.yaml",
          "version: 1\nrecipe: r\nboard: {size: [100 mm, 60 mm], thickness: 12 mm, frame: pallet}\n"
          "materials:\n  glue: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
          "dot_time: 50 ms, retract: 3 mm}\n"
          "features:\n  - polyline: {name: p, material: glue" +
              more + ", points_file: " + points_file + "}\n");
    return load((root_ / "job" / "r.yaml").string());
  }
  void refused(const std::string& name, const std::string& where, const std::string& words) {
    const auto r = with(name);
    ASSERT_FALSE(r) << name;
    ASSERT_EQ(r.error().size(), 1u) << to_text(r.error()[1]);
    EXPECT_EQ(r.error()[0].where, (root_ / "job" / where).string()) << to_text(r.error()[0]);
    EXPECT_NE(r.error()[0].message.find(words), std::string::npos) << to_text(r.error()[0]);
  }

  fs::path root_;
};
constexpr const char* kNameAt = "r.yaml:7:54";

TEST_F(BesideRecipe, points_are_read_and_recorded_with_the_hash_of_their_bytes) {
  const auto r = with("paths/p.csv");
  ASSERT_TRUE(r) << to_text(r.error()[0]);
  const Bead& bead = std::get<Bead>(r->features.at(0));
  EXPECT_EQ(bead.points, (std::vector<Vec3>{{10, 10, 0}, {20, 10, 0}, {20, 20.5, 0}}));
  ASSERT_EQ(r->sources.size(), 2u);
  EXPECT_EQ(r->sources[0].file, (root_ / "job/r.yaml").string());
  EXPECT_EQ(r->sources[1].file, (root_ / "job/paths/p.csv").string());
  EXPECT_EQ(r->sources[1].bytes, 30u);
  EXPECT_EQ(r->sources[1].sha256, sha256_hex("x_mm,y_mm\n10,10\n20,10\n20,20.5\n"));
  write("job/paths/p.csv", "x_mm,y_mm\n10,10\n20,10\n20,20.6\n");
  EXPECT_NE(with("paths/p.csv")->sources[1].sha256, r->sources[1].sha256);
  EXPECT_EQ(with("paths/p.csv", ", closed: true")->sources.size(), 2u);
}

TEST_F(BesideRecipe, files_elsewhere_are_refused) {
  refused("../secret.csv", kNameAt, "leads out");
  refused("paths/../../secret.csv", kNameAt, "leads out");
  refused((root_ / "secret.csv").string(), kNameAt, "leads out");
  refused("/etc/passwd", kNameAt, "leads out");
  fs::create_symlink(root_ / "secret.csv", root_ / "job/link.csv");
  refused("link.csv", kNameAt, "link that leads out");
  fs::create_directory_symlink(root_, root_ / "job/up");
  refused("up/secret.csv", kNameAt, "link that leads out");
  fs::create_symlink("paths/p.csv", root_ / "job/inner.csv");
  EXPECT_TRUE(with("inner.csv")) << "a link within the folder is as good as the file";
  refused("no.csv", kNameAt, "cannot be read");
  refused("paths", kNameAt, "is a folder");
  ASSERT_EQ(::mkfifo((root_ / "job/pipe.csv").c_str(), 0600), 0);
  refused("pipe.csv", kNameAt, "no regular file");
  write("job/large.csv", std::string(kMostBytesOfPoints + 1, ' '));
  refused("large.csv", kNameAt, "larger than");
}

TEST_F(BesideRecipe, mistakes_are_told_in_the_file_of_points) {
  write("job/bad.csv", "x,y\n10,10\n10,10\n20,x\n");
  const auto r = with("bad.csv");
  ASSERT_FALSE(r);
  ASSERT_EQ(r.error().size(), 2u);
  EXPECT_EQ(r.error()[0].where, (root_ / "job/bad.csv").string() + ":3:1");
  EXPECT_NE(r.error()[0].message.find("twice in a row"), std::string::npos);
  EXPECT_EQ(r.error()[1].where, (root_ / "job/bad.csv").string() + ":4:4");
  write("job/bad.csv", "x,y\n10,10\n101,10\n");
  refused("bad.csv", "bad.csv:3:1", "'off_board: true'");
  write("job/bad.csv", "x,y\n10,10\n");
  refused("bad.csv", "bad.csv:1:1", "at least 2");
}

/// A recipe of so many polylines on the same board, `feature(i)` the keys of number i beside its name.
std::string recipe_of(int count, const std::function<std::string(int)>& feature) {
  std::string yaml =
      "version: 1\nrecipe: r\nboard: {size: [100 mm, 60 mm], thickness: 12 mm, frame: pallet}\n"
      "materials:\n  glue: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
      "dot_time: 50 ms, retract: 3 mm}\nfeatures:\n";
  for (int i = 0; i < count; ++i) yaml += "  - polyline: {name: p" + std::to_string(i) + ", " + feature(i) + "}\n";
  EXPECT_LT(yaml.size(), config::YamlBudget{}.bytes);
  return yaml;
}

/// Files that are made up as they are asked for, and how often they are.
struct Shelf {
  std::function<std::string(const std::string&)> text;
  std::size_t asked = 0, bytes = 0;
  ReadText read() {
    return [this](const std::string& name) -> Result<std::string> {
      std::string out = text(name);
      ++asked, bytes += out.size();
      return out;
    };
  }
};

// The work that a recipe can ask for is bounded, whatever it names: bytes that are read, and mistakes that are told.
TEST(PointsFile, is_read_once_however_many_features_name_it) {
  constexpr int kFeatures = 3000;
  const auto one = [](int) { return std::string("material: glue, points_file: p.csv"); };
  Shelf good{[](const std::string&) { return std::string("x,y\n1,1\n2,2\n"); }};
  const auto r = written::draft(recipe_of(kFeatures, one), "r.yaml", good.read());
  EXPECT_EQ(r.recipe.features.size(), std::size_t{kFeatures});
  EXPECT_EQ(good.asked, 1u);
  ASSERT_FALSE(r.mistakes.empty());
  EXPECT_NE(r.mistakes[0].message.find("lies on bead"), std::string::npos) << "and nothing else is wrong with it";

  Shelf bad{[](const std::string&) { return "x,y\n1,1\n200,2\n200,2\nno,number\n1,1\n"; }};
  const auto twice = recipe_of(kFeatures / 2, [](int i) {
    return "material: glue, points_file: p.csv, off_board: " + std::string(i % 2 == 0 ? "true" : "false") +
           ", closed: " + (i % 3 == 0 ? "true" : "false");
  });
  const auto wrong = parse(twice, "r.yaml", bad.read());
  ASSERT_FALSE(wrong);
  EXPECT_EQ(bad.asked, 1u);
  std::string all;
  for (const Error& e : wrong.error()) all += to_text(e) + "\n";
  EXPECT_EQ(wrong.error().size(), 5u) << all;  // off the board twice, twice in a row, no number, the superfluous end
}

TEST(PointsFile, many_of_them_are_read_up_to_the_budget_of_one) {
  Shelf large{[](const std::string&) { return "x,y\n1,1\n2,2\n" + std::string(1u << 20, '\n'); }};
  const auto r = parse(recipe_of(2000, [](int i) { return "material: glue, points_file: p" + std::to_string(i); }),
                       "r.yaml", large.read());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error()[0].fault, Fault::FileTooLarge) << to_text(r.error()[0]);
  EXPECT_EQ(r.error().size(), 2u);
  EXPECT_LE(large.bytes, 2 * kMostBytesOfPoints);
}

TEST(PointsFile, mistakes_of_many_of_them_end_the_reading) {
  Shelf bad{[](const std::string&) { return std::string("x,y\n1,1\nno,number\n"); }};
  const auto r = parse(recipe_of(3000, [](int i) { return "material: glue, points_file: p" + std::to_string(i); }),
                       "r.yaml", bad.read());
  ASSERT_FALSE(r);
  EXPECT_LE(bad.asked, config::Mistakes::kMost);
  EXPECT_LE(r.error().size(), config::Mistakes::kMost + 1);
  EXPECT_NE(r.error().back().message.find("2900 of its features were not looked at"), std::string::npos)
      << to_text(r.error().back());
}

TEST(PointsFile, is_not_read_for_a_recipe_that_is_full_of_mistakes) {
  Shelf shelf{[](const std::string&) { return std::string("x,y\n1,1\n2,2\n"); }};
  const auto r = parse(recipe_of(2000,
                                 [](int i) {
                                   return i < 100
                                              ? std::string("material: glue, points: [[500 mm, 1 mm], [2 mm, 2 mm]]")
                                              : "material: glue, points_file: p" + std::to_string(i);
                                 }),
                       "r.yaml", shelf.read());
  ASSERT_FALSE(r);
  EXPECT_EQ(shelf.asked, 0u);
}

TEST(PointsFile, a_recipe_that_is_no_file_has_none) {
  const auto r = parse(
      "version: 1\nrecipe: r\nboard: {size: [100 mm, 60 mm], thickness: 12 mm, frame: pallet}\n"
      "materials:\n  glue: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
      "dot_time: 50 ms, retract: 3 mm}\n"
      "features:\n  - polyline: {name: p, material: glue, points_file: p.csv}\n",
      "text");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error()[0].fault, Fault::FileUnreadable);
}

}  // namespace
}  // namespace gantry::recipes
