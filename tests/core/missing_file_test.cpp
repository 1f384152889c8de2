#include "core/missing_file.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

namespace gantry {
namespace {

class MissingFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(top_ / "recipes" / "deep");
    for (const char* file : {"recipes/demo-board.yaml", "recipes/portal.yaml", "README.md"}) std::ofstream(top_ / file);
  }
  void TearDown() override { std::filesystem::remove_all(top_); }
  /// What is told of a path below the folder, without that folder.
  [[nodiscard]] std::string told(const std::string& path) const {
    std::string text = missing_in_words((top_ / path).string());
    const std::string above = top_.string() + "/";
    for (std::size_t at = 0; (at = text.find(above)) != std::string::npos;) text.erase(at, above.size());
    return text;
  }
  std::filesystem::path top_ = std::filesystem::temp_directory_path() / ("gantry-missing-" + std::to_string(getpid()));
};

TEST_F(MissingFile, names_the_file_that_may_be_meant) {
  EXPECT_EQ(told("recipes/demo-bord.yaml"), "there is no such file; did you mean 'recipes/demo-board.yaml'?");
  EXPECT_EQ(told("recipes/Portal.yaml"), "there is no such file; did you mean 'recipes/portal.yaml'?");
  EXPECT_EQ(told("recipes/demo-board"), "there is no such file; did you mean 'recipes/demo-board.yaml'?");
  EXPECT_EQ(told("recipes/demo-bord.yml"), "there is no such file; did you mean 'recipes/demo-board.yaml'?");
  EXPECT_EQ(told("recipes/deeq"), "there is no such file in 'recipes'") << "a folder is no file";
  EXPECT_EQ(told("recipes/nothing-like-it.yaml"), "there is no such file in 'recipes'");
}

TEST_F(MissingFile, names_the_folder_that_is_not_there) {
  EXPECT_EQ(told("recipe/demo-board.yaml"), "there is no folder 'recipe'; did you mean 'recipes'?");
  EXPECT_EQ(told("recipes/deap/x.yaml"), "there is no folder 'recipes/deap'; did you mean 'recipes/deep'?");
  EXPECT_EQ(told("nowhere/at/all.yaml"), "there is no folder 'nowhere'");
  EXPECT_EQ(told("README.md/x.yaml"), "'README.md' is no folder");
}

TEST_F(MissingFile, is_looked_for_in_the_working_folder_where_no_other_is_named) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(top_);
  EXPECT_EQ(missing_in_words("READNE.md"), "there is no such file; did you mean 'README.md'?");
  EXPECT_EQ(missing_in_words("recipes/portl.yaml"), "there is no such file; did you mean 'recipes/portal.yaml'?");
  EXPECT_EQ(missing_in_words("entirely-else"), "there is no such file in this folder");
  std::filesystem::current_path(before);
}

TEST_F(MissingFile, a_link_that_leads_nowhere_is_told_as_one) {
  std::filesystem::create_symlink("gone.yaml", top_ / "link.yaml");
  EXPECT_EQ(told("link.yaml"), "it is a link to 'gone.yaml', which is not there");
}

}  // namespace
}  // namespace gantry
