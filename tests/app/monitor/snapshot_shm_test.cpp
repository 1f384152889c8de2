#include "app/monitor/snapshot_shm.hpp"

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace gantry::monitor {
namespace {

MachineInfo two_axes() {
  MachineInfo info;
  info.name = "bench";
  info.axes = 2;
  info.axis[0] = {std::string_view("X"), false};
  info.axis[1] = {std::string_view("C"), true};
  return info;
}

/// A snapshot that shows when it is torn: every axis says the cycle.
cycle::Snapshot of_cycle(std::int64_t cycle) {
  cycle::Snapshot s;
  s.cycle = cycle;
  s.target.fill(static_cast<double>(cycle));
  s.actual.fill(static_cast<double>(cycle));
  return s;
}

bool whole(const cycle::Snapshot& s) {
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if (s.target[i] != static_cast<double>(s.cycle) || s.actual[i] != s.target[i]) return false;
  return true;
}

cycle::Event event_of(std::uint32_t id) {
  cycle::Event e;
  e.kind = cycle::EventKind::BlockDone;
  e.id = id;
  return e;
}

TEST(SharedText, is_cut_between_characters_and_always_ended) {
  const Text<6> t("abcdü");  // ü is two bytes and would be cut in half
  EXPECT_EQ(t.view(), "abcd");
  EXPECT_EQ(Text<6>("abc").view(), "abc");
  EXPECT_EQ(Text<4>("€uro").view(), "€");
}

TEST(SnapshotShm, a_reader_sees_what_the_owner_wrote) {
  auto writer = SnapshotWriter::create(two_axes());
  ASSERT_TRUE(writer);
  auto reader = SnapshotReader::open(writer->fd());
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().name.view(), "bench");
  EXPECT_EQ(reader->info().axis[1].name.view(), "C");
  EXPECT_EQ(reader->session(), writer->session());
  SharedSnapshot s;
  EXPECT_FALSE(reader->newest(s));
  for (int c = 1; c <= 5; ++c) writer->push(of_cycle(c));
  ASSERT_TRUE(reader->newest(s));
  EXPECT_EQ(s.snapshot.cycle, 5);
  for (int c = 1; c <= 5; ++c) {
    ASSERT_TRUE(reader->next(s));
    EXPECT_EQ(s.snapshot.cycle, c);
  }
  SharedJob job;
  EXPECT_FALSE(reader->job(job));
  job.job = "demo";
  job.features_done = 7;
  writer->push(job);
  SharedJob heard;
  ASSERT_TRUE(reader->job(heard));
  EXPECT_EQ(heard.job.view(), "demo");
  EXPECT_EQ(heard.features_done, 7u);
  EXPECT_FALSE(reader->writer_gone());
}

TEST(SnapshotShm, a_reader_that_comes_late_gets_the_events_that_are_still_there) {
  auto writer = SnapshotWriter::create(two_axes());
  for (std::uint32_t i = 0; i < 3; ++i) writer->push(event_of(i), "words of event " + std::to_string(i));
  auto reader = SnapshotReader::open(writer->fd());
  SharedEvent e;
  std::uint64_t number = 99;
  for (std::uint32_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(reader->next(e, number));
    EXPECT_EQ(number, i);
    EXPECT_EQ(e.event.id, i);
    EXPECT_EQ(e.text.view(), "words of event " + std::to_string(i));
  }
  EXPECT_FALSE(reader->next(e, number));
  EXPECT_EQ(reader->events_lost(), 0u);
}

TEST(SnapshotShm, alarms_keep_the_time_at_which_each_came_and_repetition_is_no_news) {
  auto writer = SnapshotWriter::create(two_axes());
  auto reader = SnapshotReader::open(writer->fd());
  SharedAlarms seen;
  EXPECT_FALSE(reader->alarms(seen));
  const Error door{Fault::DoorOpen, "the door is open", ""}, drive{Fault::DriveFault, "overvoltage", "axis X"};
  writer->alarms(std::vector{door});
  ASSERT_TRUE(reader->alarms(seen));
  ASSERT_EQ(seen.count, 1u);
  const auto version = seen.version;
  const auto since = seen.alarms[0].since_ns;
  EXPECT_GT(since, 1'600'000'000'000'000'000);
  writer->alarms(std::vector{door});
  reader->alarms(seen);
  EXPECT_EQ(seen.version, version);
  const Error closed{Fault::DoorOpen, "the door is open - not any more", ""};
  writer->alarms(std::vector{drive, closed, drive});
  reader->alarms(seen);
  ASSERT_EQ(seen.count, 2u) << "one fault is one alarm";
  EXPECT_NE(seen.version, version);
  EXPECT_EQ(seen.alarms[0].fault, Fault::DriveFault);
  EXPECT_EQ(seen.alarms[0].where.view(), "axis X");
  EXPECT_GE(seen.alarms[0].since_ns, since);
  EXPECT_EQ(seen.alarms[1].text.view(), "the door is open - not any more");
  EXPECT_EQ(seen.alarms[1].since_ns, since) << "other words, the same alarm";
  writer->alarms({});
  reader->alarms(seen);
  EXPECT_EQ(seen.count, 0u);
  std::vector<Error> many;
  for (const auto& row : catalogue()) many.push_back({row.fault, "x", ""});
  writer->alarms(many);
  reader->alarms(seen);
  EXPECT_EQ(seen.count, SharedAlarms::kMost);
}

TEST(SnapshotShm, events_that_nobody_read_in_time_are_counted) {
  auto writer = SnapshotWriter::create(two_axes());
  auto reader = SnapshotReader::open(writer->fd());
  for (std::uint32_t i = 0; i < 1500; ++i) writer->push(event_of(i));
  SharedEvent e;
  std::uint64_t number = 0, read = 0;
  while (reader->next(e, number)) ++read;
  EXPECT_EQ(number, 1499u);
  EXPECT_EQ(read + reader->events_lost(), 1500u);
  EXPECT_GT(reader->events_lost(), 0u);
}

TEST(SnapshotShm, the_owner_does_not_notice_readers_that_are_killed_at_any_moment) {
  auto writer = SnapshotWriter::create(two_axes());
  std::int64_t cycle = 0;
  for (int round = 0; round < 10; ++round) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {  // reads as fast as it can until it is killed
      auto reader = SnapshotReader::open(writer->fd());
      SharedSnapshot s;
      SharedEvent e;
      std::uint64_t number = 0;
      for (;;) {
        if (!reader) _exit(1);
        while (reader->next(s))
          if (!whole(s.snapshot)) _exit(2);
        while (reader->next(e, number)) {
        }
      }
    }
    for (int i = 0; i < 20'000; ++i) {
      writer->push(of_cycle(++cycle));
      if (i % 100 == 0) writer->push(event_of(static_cast<std::uint32_t>(i)));
      if (i == 15'000) kill(child, SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status)) << "the reader ended by itself with " << WEXITSTATUS(status);
  }
  auto reader = SnapshotReader::open(writer->fd());
  ASSERT_TRUE(reader);
  SharedSnapshot s;
  ASSERT_TRUE(reader->newest(s));
  EXPECT_EQ(s.snapshot.cycle, cycle);
  EXPECT_TRUE(whole(s.snapshot));
}

TEST(SnapshotShm, an_owner_that_is_killed_leaves_readable_memory_and_is_seen_to_be_gone) {
  int channel[2];
  ASSERT_EQ(pipe(channel), 0);
  const pid_t owner = fork();
  ASSERT_GE(owner, 0);
  if (owner == 0) {
    auto writer = SnapshotWriter::create(two_axes());
    if (!writer) _exit(1);
    const auto path = "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(writer->fd());
    if (write(channel[1], path.c_str(), path.size() + 1) < 0) _exit(1);
    for (std::int64_t c = 1;; ++c) writer->push(of_cycle(c));
  }
  char path[64] = {};
  ASSERT_GT(read(channel[0], path, sizeof path - 1), 0);
  close(channel[0]), close(channel[1]);
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  ASSERT_GE(fd, 0);
  auto reader = SnapshotReader::open(fd);
  close(fd);
  ASSERT_TRUE(reader);
  SharedSnapshot s;
  while (!reader->newest(s)) {
  }
  EXPECT_FALSE(reader->writer_gone());
  kill(owner, SIGKILL);
  ASSERT_EQ(waitpid(owner, nullptr, 0), owner);
  EXPECT_TRUE(reader->writer_gone());
  std::uint64_t read = 0;
  while (reader->next(s)) {
    EXPECT_TRUE(whole(s.snapshot));
    ++read;
  }
  EXPECT_GT(read, 0u);
}

TEST(SnapshotShm, an_owner_that_ends_in_order_is_gone_at_once) {
  auto writer = std::make_unique<SnapshotWriter>(std::move(*SnapshotWriter::create(two_axes())));
  auto reader = SnapshotReader::open(writer->fd());
  ASSERT_TRUE(reader);
  EXPECT_LT(reader->silence_s(), 60);
  writer.reset();
  EXPECT_TRUE(reader->writer_gone());
}

TEST(SnapshotShm, nobody_but_the_owner_can_shorten_or_write_the_memory) {
  auto writer = SnapshotWriter::create(two_axes());
  const auto path = "/proc/self/fd/" + std::to_string(writer->fd());
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(fd, 0);
  EXPECT_NE(ftruncate(fd, 0), 0) << "shortening it would kill the owner with SIGBUS";
  EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0), MAP_FAILED);
  EXPECT_LT(pwrite(fd, "x", 1, 0), 0);
  void* view = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, fd, 0);
  ASSERT_NE(view, MAP_FAILED);
  EXPECT_NE(mprotect(view, 4096, PROT_READ | PROT_WRITE), 0);
  munmap(view, 4096);
  close(fd);
  writer->push(of_cycle(1));  // the owner still can
}

TEST(SnapshotShm, other_files_are_refused) {
  EXPECT_EQ(SnapshotReader::open(-1).error().fault, Fault::Inconsistent);
  EXPECT_EQ(SnapshotReader::open(1023).error().fault, Fault::Inconsistent);
  for (const char* other : {"/proc/self/cmdline", "/dev/zero", "/proc/self/exe", "/"}) {
    const int fd = open(other, O_RDONLY | O_CLOEXEC);
    ASSERT_GE(fd, 0) << other;
    EXPECT_EQ(SnapshotReader::open(fd).error().fault, Fault::Inconsistent) << other;
    close(fd);
  }
}

TEST(SnapshotShm, the_machine_file_names_machine_and_axes) {
  config::Machine m;
  m.name = "dispenser";
  config::Axis c;
  c.name = "C", c.rotary = true;
  m.axes = {c};
  const auto info = machine_info(m);
  EXPECT_EQ(info.name.view(), "dispenser");
  ASSERT_EQ(info.axes, 1u);
  EXPECT_TRUE(info.axis[0].rotary);
}

}  // namespace
}  // namespace gantry::monitor
