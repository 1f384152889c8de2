#include "app/record/setpoint_file.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <vector>

#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

std::string written(const Folder& folder, const std::string& name, const std::vector<cycle::Snapshot>& stream) {
  const std::string path = folder.path + "/" + name;
  auto file = SetpointFile::create(path);
  EXPECT_TRUE(file);
  for (const auto& s : stream) file->add(s);
  EXPECT_TRUE(file->close());
  return path;
}

std::vector<cycle::Snapshot> two_blocks() {
  std::vector<cycle::Snapshot> list;
  for (std::uint32_t t = 1; t <= 50; ++t) list.push_back(tick_of(1, t, static_cast<std::int32_t>(t), -7));
  list.push_back({});  // idle
  for (std::uint32_t t = 1; t <= 30; ++t) list.push_back(tick_of(2, t, 50, static_cast<std::int32_t>(t)));
  return list;
}

TEST(SetpointFile, equal_streams_have_no_difference) {
  const Folder folder;
  const auto a = written(folder, "a.bin", two_blocks()), b = written(folder, "b.bin", two_blocks());
  const auto c = compare(a, b);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->common, 80u);
  EXPECT_EQ(c->only_a + c->only_b, 0u);
  EXPECT_FALSE(c->first_difference);
}

TEST(SetpointFile, names_the_first_tick_that_differs) {
  const Folder folder;
  auto other = two_blocks();
  other[61].counts[1] += 1;  // block 2, tick 11
  other[70].counts[0] += 9;
  const auto c = compare(written(folder, "a.bin", two_blocks()), written(folder, "b.bin", other));
  ASSERT_TRUE(c && c->first_difference);
  EXPECT_EQ(c->first_difference->block, 2u);
  EXPECT_EQ(c->first_difference->tick, 11u);
  EXPECT_EQ(c->first_difference->what, "counts of drive 1: 11 and 12");
}

TEST(SetpointFile, only_ticks_that_both_sent_are_compared) {
  const Folder folder;
  auto stalled = two_blocks();
  for (std::size_t i = 20; i < 25; ++i) stalled[i].sent = false, stalled[i].counts[0] = 12345;
  const auto c = compare(written(folder, "a.bin", two_blocks()), written(folder, "b.bin", stalled));
  ASSERT_TRUE(c);
  EXPECT_EQ(c->common, 75u);
  EXPECT_EQ(c->only_a, 5u);
  EXPECT_FALSE(c->first_difference);
}

TEST(SetpointFile, a_run_that_ended_early_is_compared_as_far_as_it_went) {
  const Folder folder;
  auto cut = two_blocks();
  cut.resize(60);
  const auto c = compare(written(folder, "a.bin", cut), written(folder, "b.bin", two_blocks()));
  ASSERT_TRUE(c);
  EXPECT_EQ(c->common, 59u);
  EXPECT_EQ(c->only_b, 21u);
  EXPECT_FALSE(c->first_difference);
}

TEST(SetpointFile, a_block_that_was_started_again_is_kept_apart) {
  const Folder folder;
  std::vector<cycle::Snapshot> again;
  for (std::uint32_t t = 1; t <= 10; ++t) again.push_back(tick_of(1, t, 1));
  for (std::uint32_t t = 1; t <= 10; ++t) again.push_back(tick_of(1, t, 2));
  auto other = again;
  other[15].counts[0] = 3;
  const auto c = compare(written(folder, "a.bin", again), written(folder, "b.bin", other));
  ASSERT_TRUE(c && c->first_difference);
  EXPECT_EQ(c->common, 20u);
  EXPECT_EQ(c->first_difference->tick, 6u);
}

TEST(SetpointFile, what_is_no_setpoint_file_is_refused) {
  const Folder folder;
  const auto a = written(folder, "a.bin", two_blocks());
  std::ofstream(folder.path + "/text.bin") << "hello, this is text and no stream";
  EXPECT_EQ(compare(a, folder.path + "/text.bin").error().fault, Fault::Inconsistent);
  EXPECT_EQ(compare(a, folder.path + "/missing.bin").error().fault, Fault::FileUnreadable);
  EXPECT_EQ(SetpointFile::create(folder.path + "/no/such/folder.bin").error().fault, Fault::FileUnwritable);
}

TEST(SetpointFile, a_disk_that_is_full_is_told_at_the_end) {
  const Folder folder;
  auto file = SetpointFile::create(folder.path + "/full.bin");
  ASSERT_TRUE(file);
  // As a full disk would, the system takes no more than this.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{.rlim_cur = 4096, .rlim_max = before.rlim_max};
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &little), 0);
  for (std::uint32_t t = 1; t <= 5000; ++t) file->add(tick_of(1, t));
  const auto closed = file->close();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal_before);
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().fault, Fault::FileUnwritable);
}

TEST(SetpointFile, a_device_of_its_name_is_refused_and_left_alone) {
  const auto refused = SetpointFile::create("/dev/null");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::FileUnwritable);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace gantry::record
