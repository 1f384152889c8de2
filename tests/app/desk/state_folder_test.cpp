// Where state lives, and whom its folder is closed to.
#include "app/desk/state_folder.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

namespace gantry::desk {
namespace {

namespace fs = std::filesystem;

class StateFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    here_ = fs::temp_directory_path() / ("gantry-state-" + std::to_string(getpid()));
    fs::remove_all(here_);
    fs::create_directories(here_);
  }
  void TearDown() override { fs::remove_all(here_); }
  static unsigned mode(const fs::path& path) {
    struct stat found {};
    return ::lstat(path.c_str(), &found) == 0 ? found.st_mode & 0777u : 0;
  }
  fs::path here_;
};

TEST_F(StateFolder, where_none_is_named_the_owner_of_the_service_is_looked_for_too) {
  std::map<std::string, std::string> set;
  const auto env = [&](const char* name) { return set.count(name) != 0 ? set[name] : std::string(); };
  EXPECT_EQ(shared_socket("", env), "/run/gantry/owner.sock");
  EXPECT_EQ(shared_socket("/x/y", env), "");
  set["GANTRY_SOCKET"] = "/a.sock";
  EXPECT_EQ(shared_socket("", env), "/a.sock");
  set["GANTRY_STATE"] = "/a/b";
  EXPECT_EQ(shared_socket("", env), "");
}

TEST_F(StateFolder, is_the_option_else_the_variable_else_that_of_xdg_by_machine_name) {
  std::map<std::string, std::string> set{
      {"GANTRY_STATE", "/a/b/"}, {"XDG_STATE_HOME", "/users/anna/xdg"}, {"HOME", "/users/anna"}};
  const auto env = [&](const char* name) { return set.count(name) != 0 ? set[name] : std::string(); };
  EXPECT_EQ(*state_folder("/x/y", "dispenser", env), "/x/y");
  EXPECT_EQ(*state_folder("y/", "dispenser", env), (fs::current_path() / "y").string());
  EXPECT_EQ(*state_folder("", "dispenser", env), "/a/b");
  set.erase("GANTRY_STATE");
  EXPECT_EQ(*state_folder("", "dispenser", env), "/users/anna/xdg/gantry/dispenser");
  set["XDG_STATE_HOME"] = "relative";  // the specification: to be ignored
  EXPECT_EQ(*state_folder("", "dispenser", env), "/users/anna/.local/state/gantry/dispenser");
  EXPECT_EQ(*state_folder("", "../../etc", env), "/users/anna/.local/state/gantry/..-..-etc");
  EXPECT_EQ(*state_folder("", "..", env), "/users/anna/.local/state/gantry/machine");
  set.clear();
  ASSERT_FALSE(state_folder("", "dispenser", env));
  EXPECT_EQ(state_folder("", "dispenser", env).error().fault, Fault::Usage);
}

TEST_F(StateFolder, is_made_for_this_user_alone) {
  const fs::path path = here_ / "new/deeper/state";
  ASSERT_TRUE(open_state_folder(path));
  EXPECT_EQ(mode(path), 0700u);
  EXPECT_EQ(mode(here_ / "new"), 0700u);
  EXPECT_TRUE(open_state_folder(path));
}

TEST_F(StateFolder, an_empty_one_is_closed_and_one_with_other_things_is_left_alone) {
  fs::create_directory(here_ / "empty");
  fs::create_directories(here_ / "used/things");
  for (const char* name : {"empty", "used"}) ASSERT_EQ(::chmod((here_ / name).c_str(), 0755), 0);
  EXPECT_TRUE(open_state_folder(here_ / "empty"));
  EXPECT_EQ(mode(here_ / "empty"), 0700u);
  const auto used = open_state_folder(here_ / "used");
  ASSERT_FALSE(used);
  EXPECT_NE(used.error().message.find("chmod 700"), std::string::npos);
  EXPECT_EQ(mode(here_ / "used"), 0755u);
}

TEST_F(StateFolder, others_may_not_write_to_it) {
  fs::create_directory(here_ / "open");
  ASSERT_EQ(::chmod((here_ / "open").c_str(), 01777), 0);
  const auto refused = open_state_folder(here_ / "open");
  ASSERT_FALSE(refused);
  EXPECT_EQ(info(refused.error().fault).exit_code, ExitCode::Refused);
}

TEST_F(StateFolder, is_no_link_and_no_file) {
  fs::create_directory(here_ / "real");
  fs::create_symlink(here_ / "real", here_ / "link");
  std::ofstream(here_ / "file") << "x";
  for (const char* name : {"link", "file"}) {
    const auto refused = open_state_folder(here_ / name);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().fault, Fault::Refused) << name;
  }
}

TEST_F(StateFolder, belongs_to_its_user) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  fs::create_directory(here_ / "theirs");
  ASSERT_EQ(::chmod((here_ / "theirs").c_str(), 0700), 0);
  ASSERT_EQ(::chown((here_ / "theirs").c_str(), 65534, 65534), 0);
  const auto refused = open_state_folder(here_ / "theirs");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("user 65534"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace gantry::desk
