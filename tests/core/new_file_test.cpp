// Files are never written through links that somebody has put in their place.
#include "core/new_file.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <unistd.h>

namespace gantry {
namespace {

namespace fs = std::filesystem;

class NewFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    here_ = fs::temp_directory_path() / ("gantry-files-" + std::to_string(getpid()));
    fs::remove_all(here_);
    fs::create_directories(here_);
    std::ofstream(here_ / "victim") << "precious";
  }
  void TearDown() override { fs::remove_all(here_); }
  [[nodiscard]] std::string text(const char* name) const {
    std::ifstream in(here_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path here_;
};

TEST_F(NewFiles, a_planted_link_is_replaced_and_its_target_untouched) {
  for (const char* name : {"a", "b", "b.part"}) fs::create_symlink(here_ / "victim", here_ / name);
  fs::create_hard_link(here_ / "victim", here_ / "hard");
  for (const char* name : {"a", "hard"}) {
    auto file = NewFile::create(here_ / name);
    ASSERT_TRUE(file) << to_text(file.error());
    file->write("ours");
    ASSERT_TRUE(file->close());
    EXPECT_EQ(text(name), "ours");
    EXPECT_FALSE(fs::is_symlink(here_ / name));
  }
  ASSERT_TRUE(write_new_file(here_ / "b", "whole"));
  EXPECT_EQ(text("b"), "whole");
  EXPECT_FALSE(fs::is_symlink(here_ / "b"));
  EXPECT_FALSE(fs::exists(fs::symlink_status(here_ / "b.part")));
  EXPECT_EQ(text("victim"), "precious");
}

TEST_F(NewFiles, a_durable_file_replaces_the_one_before_and_its_folder_must_be_there) {
  ASSERT_TRUE(write_durable_file(here_ / "kept", "first"));
  ASSERT_TRUE(write_durable_file(here_ / "kept", "second"));
  EXPECT_EQ(text("kept"), "second");
  EXPECT_FALSE(fs::exists(fs::symlink_status(here_ / "kept.part")));
  EXPECT_FALSE(write_durable_file(here_ / "no/such/folder", "x"));
}

TEST_F(NewFiles, a_long_file_is_whole_and_a_full_device_is_told) {
  const std::string much(1'000'000, 'x');
  auto file = NewFile::create(here_ / "long");
  ASSERT_TRUE(file);
  for (int i = 0; i < 3; ++i) file->write(much);
  ASSERT_TRUE(file->close());
  EXPECT_EQ(text("long").size(), 3 * much.size());
  EXPECT_FALSE(NewFile::create("/proc/none"));
  EXPECT_FALSE(NewFile::create(here_ / "no/such/folder"));
}

TEST_F(NewFiles, one_that_has_lost_its_name_while_it_was_written_is_told) {
  for (const bool replaced : {false, true}) {
    auto file = NewFile::create(here_ / "job.bin");
    ASSERT_TRUE(file);
    file->write("a");
    fs::remove(here_ / "job.bin");
    if (replaced) std::ofstream(here_ / "job.bin") << "another job's";
    const auto closed = file->close();
    ASSERT_FALSE(closed);
    EXPECT_NE(closed.error().message.find("removed or replaced"), std::string::npos) << closed.error().message;
    EXPECT_EQ(text("job.bin"), replaced ? "another job's" : "");
  }
}

TEST_F(NewFiles, a_folder_that_is_a_link_of_another_user_is_not_used) {
  fs::create_directory(here_ / "real");
  fs::create_directory_symlink(here_ / "real", here_ / "mine");
  fs::create_symlink(here_ / "victim", here_ / "odd");
  EXPECT_TRUE(make_folder(here_ / "new/and/deeper"));
  EXPECT_TRUE(fs::is_directory(here_ / "new/and/deeper"));
  EXPECT_TRUE(make_folder(here_ / "mine"));
  EXPECT_FALSE(make_folder(here_ / "odd"));
  if (::geteuid() != 0) return;  // only root can give a link away
  fs::create_directory_symlink(here_ / "real", here_ / "theirs");
  ASSERT_EQ(::lchown((here_ / "theirs").c_str(), 65534, 65534), 0);
  for (const char* name : {"theirs", "theirs/"}) {
    const auto refused = make_folder(here_ / name);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("user 65534"), std::string::npos);
  }
  fs::create_directory(here_ / "real/there");
  for (const char* name : {"theirs/there", "theirs/new", "theirs/there/new/deeper"}) {
    const auto refused = make_folder(here_ / name);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().where, (here_ / "theirs").string());
    EXPECT_FALSE(NewFile::create(here_ / name / "file"));
  }
  EXPECT_FALSE(fs::exists(here_ / "real/new"));
  EXPECT_TRUE(make_folder(here_ / "mine/there/new")) << "by a link of one's own";
}

TEST_F(NewFiles, whether_files_can_be_made_in_a_folder_is_tried_and_leaves_nothing) {
  const auto left = [&] {
    return std::distance(fs::recursive_directory_iterator(here_), fs::recursive_directory_iterator());
  };
  fs::create_symlink(here_ / "loop", here_ / "loop");
  fs::create_symlink(here_ / "victim", here_ / "odd");
  std::ofstream(here_ / "file") << "x";
  const auto before = left();
  EXPECT_TRUE(try_folder(here_));
  EXPECT_TRUE(try_folder(here_ / "new/and/deeper"));
  EXPECT_TRUE(try_folder(here_ / "new/"));
  EXPECT_TRUE(try_folder("relative-and-new"));
  EXPECT_FALSE(fs::exists("relative-and-new"));
  for (const fs::path& wrong : {here_ / "loop", here_ / "loop/below", here_ / "odd", here_ / "file",
                                here_ / "file/below", fs::path("/proc"), fs::path("/proc/none/below")})
    EXPECT_FALSE(try_folder(wrong)) << wrong;
  EXPECT_EQ(left(), before);
}

}  // namespace
}  // namespace gantry
