// Every #include against the tables of docs/architecture.md.
#include "tests/architecture/floors.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>

namespace gantry::architecture {
namespace {

std::string page() { return read(std::filesystem::path(GANTRY_SOURCE_DIR) / "docs/architecture.md"); }

TEST(Floors, every_include_goes_down) {
  const Floors floors(page());
  ASSERT_FALSE(floors.empty()) << "docs/architecture.md lost its tables";
  const auto tree = source_tree();
  std::set<std::string> paths;
  for (const SourceFile& file : tree) paths.insert(file.path);
  for (const SourceFile& file : tree) {
    if (!is_code(file) || floors.room(file.path).empty()) continue;
    for (const Include& include : includes(file.text)) {
      if (include.angled) continue;
      if (!paths.contains(include.path)) {
        EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(GANTRY_SOURCE_DIR) /
                                             std::filesystem::path(file.path).parent_path() / include.path))
            << file.path << ":" << include.line << ": include from the root: \"" << include.path << "\"";
        continue;  // a header that is generated while building
      }
      const std::string why = floors.verdict(file.path, include.path);
      EXPECT_TRUE(why.empty()) << file.path << ":" << include.line << ": includes " << include.path << ", but " << why;
    }
  }
}

TEST(Floors, every_source_of_the_program_has_a_room) {
  const Floors floors(page());
  for (const SourceFile& file : source_tree())
    for (const char* top : {"core", "config", "motion", "devices", "vision", "recipes", "sim", "app"})
      if (is_code(file) && within(file.path, top)) {
        EXPECT_FALSE(floors.room(file.path).empty()) << file.path;
      }
}

// The judge judged: what each rule must say about includes that nobody has written.
TEST(Floors, rules_catch_what_they_are_there_for) {
  const Floors floors(page());
  struct {
    const char *file, *header;
    bool allowed;
  } const cases[] = {
      {"app/run/owner.cpp", "app/cycle/loop.hpp", true},
      {"app/run/owner.cpp", "app/record/journal.hpp", true},
      {"app/record/journal.cpp", "app/run/owner.hpp", false},
      {"app/record/journal.cpp", "app/monitor/publish.hpp", false},
      {"app/run/owner.cpp", "app/cli/main.hpp", false},
      {"core/clock.cpp", "config/machine.hpp", false},
      {"config/load.cpp", "core/units.hpp", true},
      {"motion/plan/sweep.cpp", "devices/frame_port.hpp", false},
      {"motion/rt/guard.cpp", "motion/types.hpp", true},
      {"motion/rt/guard.cpp", "motion/profile/planner.hpp", true},
      {"motion/profile/planner.cpp", "motion/rt/guard.hpp", false},
      {"motion/rt/guard.cpp", "devices/wire/cia402.hpp", false},
      {"motion/rt/guard.cpp", "devices/rt/drive.hpp", false},
      {"motion/path/corners.cpp", "motion/profile/planner.hpp", true},
      {"devices/rt/drive.cpp", "devices/wire/cia402.hpp", true},
      {"devices/rt/drive.cpp", "devices/ethercat/master.hpp", false},
      {"devices/ethercat/sdo.cpp", "motion/types.hpp", false},
      {"devices/ethercat/sdo.cpp", "devices/rt/frame.hpp", true},
      {"sim/esc/esc.cpp", "devices/wire/ethercat.hpp", true},
      {"sim/esc/esc.cpp", "devices/ethercat/master.hpp", false},
      {"sim/world/world.cpp", "motion/plan/scene.hpp", false},
      {"sim/world/camera.cpp", "vision/camera.hpp", true},
      {"vision/find.cpp", "recipes/recipe.hpp", false},
      {"recipes/parse.cpp", "sim/world/world.hpp", false},
      {"app/cycle/loop.cpp", "sim/world/world.hpp", false},
      {"app/cycle/loop.cpp", "devices/rt/drive.hpp", true},
      {"app/loose.cpp", "core/clock.hpp", false},
  };
  for (const auto& row : cases)
    EXPECT_EQ(floors.verdict(row.file, row.header).empty(), row.allowed)
        << row.file << " -> " << row.header << ": " << floors.verdict(row.file, row.header);
}

TEST(Headers, large_libraries_stay_in_few_files) {
  const auto rows = table(page(), "headers");
  ASSERT_FALSE(rows.empty());
  std::map<std::string, std::set<std::string>> users;
  for (const SourceFile& file : source_tree()) {
    if (!is_code(file) || within(file.path, "tests") || within(file.path, "bench")) continue;
    for (const Include& include : includes(file.text))
      for (const auto& row : rows)
        if (include.path.starts_with(row[0])) {
          bool allowed = false;
          for (std::size_t i = 1; i + 1 < row.size(); ++i) allowed = allowed || within(file.path, row[i]);
          EXPECT_TRUE(allowed) << file.path << ":" << include.line << ": " << row[0] << " is not for this room";
          users[row[0]].insert(file.path);
        }
  }
  for (const auto& row : rows) {
    std::string list;
    for (const std::string& path : users[row[0]]) list += " " + path;
    EXPECT_LE(users[row[0]].size(), std::stoul(row.back())) << row[0] << " is included by" << list;
  }
}

/// What a file includes of the rooms that a bus is made of, and of those that are to know none in particular; by whom.
std::map<std::string, std::string> reached(const std::map<std::string, std::string>& tree, const std::string& from) {
  std::map<std::string, std::string> by{{from, ""}};
  for (std::vector<std::string> next{from}; !next.empty();) {
    const std::string file = next.back();
    next.pop_back();
    const auto text = tree.find(file);
    if (text == tree.end()) continue;
    for (const Include& include : includes(text->second)) {
      const bool follow = within(include.path, "devices") || within(include.path, "app");
      if (!include.angled && follow && by.emplace(include.path, file).second) next.push_back(include.path);
    }
  }
  return by;
}

TEST(Buses, loop_recovery_and_diagnosis_include_nothing_of_ethercat_but_in_named_files) {
  const auto rooms = table(page(), "ethercat"), lists = table(page(), "ethercat-headers");
  ASSERT_EQ(rooms.size(), 3u);
  ASSERT_FALSE(lists.empty());
  std::vector<std::string> headers;
  for (const auto& row : lists) headers.insert(headers.end(), row.begin(), row.end());
  const auto ethercats = [&](const std::string& path) {
    return std::ranges::any_of(headers, [&](const std::string& h) { return within(path, h); });
  };
  std::map<std::string, std::string> tree;
  for (const SourceFile& file : source_tree())
    if (is_code(file)) tree.emplace(file.path, file.text);
  std::set<std::string> unused;
  for (const auto& row : rooms) unused.insert(row.begin() + 1, row.end());
  int looked_at = 0;
  for (const auto& [path, text] : tree) {
    const auto row = std::ranges::find_if(rooms, [&](const auto& r) { return within(path, r.front()); });
    const bool second_bus = path.starts_with("tests/app/run/second_bus");
    if (row == rooms.end() && !second_bus) continue;
    const bool named = !second_bus && std::find(row->begin() + 1, row->end(), path) != row->end();
    ++looked_at;
    for (const auto& [header, by] : reached(tree, path)) {
      if (!ethercats(header)) continue;
      if (named) unused.erase(path);
      EXPECT_TRUE(named) << path << " knows EtherCAT: " << by << " includes " << header;
    }
  }
  EXPECT_GT(looked_at, 60);
  EXPECT_TRUE(unused.empty()) << *unused.begin() << " needs no exception";
  for (const std::string& h : headers)
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(GANTRY_SOURCE_DIR) / h)) << h;
  EXPECT_TRUE(ethercats("devices/ethercat/master.hpp"));  // the judge can see
  EXPECT_TRUE(reached(tree, "app/run/owner_open.cpp").contains("devices/wire/ethercat.hpp"));
}

TEST(Headers, imgcodecs_is_not_used) {
  for (const SourceFile& file : source_tree())
    for (const Include& include : includes(is_code(file) ? file.text : "")) {
      EXPECT_FALSE(include.path.starts_with("opencv2/imgcodecs") || include.path == "opencv2/opencv.hpp")
          << file.path << ": loads a library under the GPL, see docs/decisions/005-images-without-imgcodecs.md";
    }
}

TEST(RtRooms, every_source_is_built_as_part_of_an_rt_library) {
  // Written by CMake: the sources of all gantry_rt_library targets.
  std::istringstream list(read(std::filesystem::path(GANTRY_BINARY_DIR) / "rt_sources.txt"));
  std::set<std::string> built;
  for (std::string line; std::getline(list, line);)
    built.insert(std::filesystem::path(line).lexically_relative(GANTRY_SOURCE_DIR).generic_string());
  ASSERT_TRUE(built.contains("core/rt/trap.cpp"));
  const Floors floors(page());
  const std::set<std::string> around{
      // not in the loop: hooks of the tests, and what starts and watches the loop's thread
      "core/rt/trap_hooks.cpp", "app/cycle/crash_stop.cpp", "app/cycle/loop_cpu.cpp", "app/cycle/thread.cpp",
      "app/cycle/watchdog.cpp"};
  for (const SourceFile& file : source_tree())
    for (const std::string& folder : floors.rt_folders())
      if (file.path.ends_with(".cpp") && within(file.path, folder) && !around.contains(file.path)) {
        EXPECT_TRUE(built.contains(file.path)) << file.path << " is not in a gantry_rt_library";
      }
}

}  // namespace
}  // namespace gantry::architecture
