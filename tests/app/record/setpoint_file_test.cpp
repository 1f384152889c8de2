#include "app/record/setpoint_file.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <sys/resource.h>
#include <vector>

#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

std::string written(const Folder& folder, const std::string& name, const std::vector<cycle::Snapshot>& stream) {
  const std::string path = folder.path + "/" + name;
  SetpointFile file(path);
  for (const auto& s : stream) file.add(s);
  EXPECT_TRUE(file.close());
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

/// As drives move: at rest, ramps, even speed with a count of noise, wraps; stops, starts again, ticks that were not
/// sent.
std::vector<cycle::Snapshot> a_job(std::uint64_t seed, std::size_t ticks) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return static_cast<std::int64_t>(random() % n); };
  std::vector<cycle::Snapshot> list;
  std::uint32_t block = 1, tick = 0, outputs = 0;
  std::array<double, 2> at{0, 2147483000.0}, v{}, a{};
  for (std::size_t i = 0; i < ticks; ++i) {
    if (below(500) == 0) block += static_cast<std::uint32_t>(below(3)), tick = 0;
    if (below(300) == 0) tick += static_cast<std::uint32_t>(below(9));
    if (below(200) == 0) outputs ^= 1u << below(8);
    for (std::size_t d = 0; d < 2; ++d) {
      if (below(100) == 0) a[d] = static_cast<double>(below(21) - 10) / 10;
      if (below(400) == 0) v[d] = a[d] = 0;
      v[d] += a[d], at[d] += v[d];
    }
    auto s = tick_of(block, ++tick, static_cast<std::int32_t>(static_cast<std::int64_t>(at[0])),
                     static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(at[1]))));
    s.sent = below(50) != 0;
    s.outputs = outputs;
    list.push_back(s);
  }
  return list;
}

TEST(SetpointFile, a_stream_comes_back_as_it_went_in) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto job = a_job(seed, 3000);
    SetpointEncoder encoder(2);
    std::string bytes;
    const auto told = [](const cycle::Snapshot& s) {
      return SetpointTick{s.block, s.tick, s.outputs, s.sent, {s.counts[0], s.counts[1]}};
    };
    for (const auto& s : job) encoder.add(told(s), bytes);
    encoder.end(bytes);
    std::size_t i = 0;
    const auto take = [&](const SetpointTick& t) {
      const SetpointTick wanted = told(job.at(i++));
      EXPECT_TRUE(t.block == wanted.block && t.tick == wanted.tick && t.outputs == wanted.outputs &&
                  t.sent == wanted.sent && t.counts == wanted.counts)
          << "seed " << seed << ", tick " << i;
      return !testing::Test::HasFailure();
    };
    EXPECT_TRUE(decode(bytes, 2, take));
    ASSERT_EQ(i, job.size()) << "seed " << seed;
    EXPECT_LT(bytes.size(), job.size() * 8);
    // Cut anywhere, what is whole comes back and nothing else.
    for (int cut = 0; cut < 50; ++cut) {
      i = 0;
      static_cast<void>(
          decode(std::string_view(bytes).substr(0, bytes.size() * static_cast<std::size_t>(cut) / 50), 2, take));
      EXPECT_LE(i, job.size());
    }
  }
}

TEST(SetpointFile, bytes_of_anybody_are_read_to_an_end) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(random() % 200, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % (round % 2 == 0 ? 256 : 16));
    std::size_t ticks = 0;
    static_cast<void>(decode(bytes, 1 + static_cast<std::uint32_t>(random() % cycle::kMaxDrives),
                             [&](const SetpointTick&) { return ++ticks < 100'000; }));
  }
}

TEST(SetpointFile, standing_still_costs_next_to_nothing) {
  const Folder folder;
  std::vector<cycle::Snapshot> still;
  for (std::uint32_t t = 1; t <= 100'000; ++t) still.push_back(tick_of(1, t, 4711, -3));
  EXPECT_LT(std::filesystem::file_size(written(folder, "a.bin", still)), 100u);
}

TEST(SetpointFile, a_thread_of_its_own_writes_the_same_file) {
  const Folder folder;
  const auto job = a_job(3, 60'000);
  const std::string path = folder.path + "/own.bin";
  SetpointFile file(path, FileWriter::Thread::Own);
  for (const auto& s : job) file.add(s);
  ASSERT_TRUE(file.close());
  const auto bytes = [](const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes(path), bytes(written(folder, "here.bin", job)));
}

TEST(SetpointFile, what_is_no_setpoint_file_is_refused) {
  const Folder folder;
  const auto a = written(folder, "a.bin", two_blocks());
  std::ofstream(folder.path + "/text.bin") << "hello, this is text and no stream";
  EXPECT_EQ(compare(a, folder.path + "/text.bin").error().fault, Fault::Inconsistent);
  EXPECT_EQ(compare(a, folder.path + "/missing.bin").error().fault, Fault::FileUnreadable);
}

TEST(SetpointFile, that_cannot_be_made_says_so_at_its_end) {
  const Folder folder;
  for (const auto thread : {FileWriter::Thread::Callers, FileWriter::Thread::Own}) {
    SetpointFile file(folder.path + "/no/such/folder.bin", thread);
    for (const auto& s : two_blocks()) file.add(s);
    const auto closed = file.close();
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().fault, Fault::FileUnwritable);
    EXPECT_EQ(closed.error().where, folder.path + "/no/such/folder.bin");
  }
}

TEST(SetpointFile, a_disk_that_is_full_is_told_at_the_end) {
  const Folder folder;
  SetpointFile file(folder.path + "/full.bin");
  // As a full disk would, the system takes no more than this.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{.rlim_cur = 4096, .rlim_max = before.rlim_max};
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &little), 0);
  for (std::uint32_t t = 1; t <= 50000; ++t) file.add(tick_of(1, t, static_cast<std::int32_t>(t * t)));
  const auto closed = file.close();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal_before);
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().fault, Fault::FileUnwritable);
  EXPECT_FALSE(std::filesystem::exists(folder.path + "/full.bin")) << "its room is free";
}

TEST(SetpointFile, a_device_of_its_name_is_refused_and_left_alone) {
  const auto refused = SetpointFile("/dev/null").close();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::FileUnwritable);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace gantry::record
