// Every row of recipes.txt and machines.txt: one message, at its place, that says what to write, with its exit code. A
// recipe goes as far as `check` and a start take it: read, compiled, and proved at the nominal place.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/job/marks_apart.hpp"
#include "app/job/prove.hpp"
#include "app/job/turned_board.hpp"
#include "config/yaml.hpp"
#include "table.hpp"

namespace gantry::wrong {
namespace {

namespace fs = std::filesystem;

/// A folder with the shipped profiles, in which changed files are written.
class Bench {
 public:
  Bench() : folder_(fs::path(testing::TempDir()) / ("gantry_wrong_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "machines");
    for (const char* kind : {"drives", "devices"})
      fs::create_directory_symlink(fs::absolute(fs::path("config") / kind), folder_ / kind);
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  ~Bench() { fs::remove_all(folder_); }

  [[nodiscard]] std::string recipe() const { return (folder_ / "recipe.yaml").string(); }
  [[nodiscard]] std::string machine() const { return (folder_ / "machines" / "machine.yaml").string(); }
  static void write(const std::string& path, const std::string& text) {
    std::ofstream(path) << text;
    std::ofstream(fs::path(path).parent_path() / "one-point.csv") << "x_mm,y_mm\n10,10\n";
    std::ofstream(fs::path(path).parent_path() / "off.csv") << "x_mm,y_mm\n10,10\n500,10\n";
    std::ofstream(fs::path(path).parent_path() / "words.csv") << "x_mm,y_mm\n10,10\n20,here\n";
  }

 private:
  fs::path folder_;
};

/// As app/desk/prepare.cpp prepares a job, and `check` looks at one.
std::vector<Error> mistakes_of(const config::Machine& machine, const std::string& recipe) {
  const auto compiled = recipes::load_for(recipe, machine);
  if (!compiled) return compiled.error();
  if (auto apart = job::marks_apart(compiled->recipe, machine); !apart) return {apart.error()};
  if (auto one_way = job::fits_one_way(compiled->recipe, machine); !one_way) return {one_way.error()};
  if (auto proof = job::prove_nominal(machine, compiled->recipe, compiled->job); !proof) return {proof.error()};
  return {};
}

void expect_one(const std::vector<Error>& errors, const Mistake& wanted, const std::string& where,
                const std::string& table) {
  std::string all;
  for (const Error& e : errors) all += "\n  " + to_text(e);
  const std::string row = table + ":" + std::to_string(wanted.line) + ": " + wanted.name + ": ";
  if (errors.size() != 1) {
    ADD_FAILURE() << row << errors.size() << " messages" << all;
    return;
  }
  EXPECT_TRUE(errors[0].where == where) << row << "not at " << where << all;
  for (const std::string& words : wanted.says)
    EXPECT_TRUE(errors[0].message.find(words) != std::string::npos) << row << "not '" << words << "'" << all;
  const int exit_code = static_cast<int>(info(errors[0].fault).exit_code);
  EXPECT_TRUE(exit_code == wanted.exit_code) << row << "exit " << exit_code << all;
}

std::string shipped(const char* file) { return *config::read_text_file(file); }

TEST(Wrong, recipes_bring_one_message_each) {
  const std::string table = GANTRY_SOURCE_DIR "/tests/wrong/recipes.txt";
  const std::string recipe = shipped("recipes/demo-board.yaml"), machine = shipped("config/machines/dispenser.yaml");
  const Bench bench;
  const auto reference = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(reference);
  for (const Mistake& wanted : read_table(table)) try {
      const Changed text = changed(recipe, wanted.in_recipe, wanted.at);
      Bench::write(bench.recipe(), text.text);
      auto on = reference;
      if (!wanted.in_machine.empty()) {
        Bench::write(bench.machine(), changed(machine, wanted.in_machine, "").text);
        on = config::load_machine(bench.machine());
      }
      ASSERT_TRUE(on) << wanted.name << ": " << to_text(on.error().front());
      expect_one(mistakes_of(*on, bench.recipe()), wanted, bench.recipe() + ":" + text.at, table);
    } catch (const std::runtime_error& e) {
      ADD_FAILURE() << table << ":" << wanted.line << ": " << wanted.name << ": " << e.what();
    }
}

TEST(Wrong, machine_files_bring_one_message_each) {
  const std::string table = GANTRY_SOURCE_DIR "/tests/wrong/machines.txt";
  const std::string machine = shipped("config/machines/dispenser.yaml");
  const Bench bench;
  for (const Mistake& wanted : read_table(table)) try {
      const Changed text = changed(machine, wanted.in_machine, wanted.at);
      Bench::write(bench.machine(), text.text);
      const auto read = config::load_machine(bench.machine());
      expect_one(read ? std::vector<Error>{} : read.error(), wanted, bench.machine() + ":" + text.at, table);
    } catch (const std::runtime_error& e) {
      ADD_FAILURE() << table << ":" << wanted.line << ": " << wanted.name << ": " << e.what();
    }
}

/// The tables prove nothing if the files that they change are wrong themselves.
TEST(Wrong, unchanged_the_files_are_right) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  EXPECT_TRUE(mistakes_of(*machine, "recipes/demo-board.yaml").empty());
}

}  // namespace
}  // namespace gantry::wrong
