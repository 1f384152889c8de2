// Who touches the disk. This program's own open(2), write(2), unlink(2) and close(2) stand before the library's, note
// their thread and take their time, as a disk may.
#include "app/record/file_writer.hpp"

#include <atomic>
#include <chrono>
#include <cstdarg>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <sys/syscall.h>
#include <thread>
#include <unistd.h>

#include "tests/app/record/snapshots.hpp"

namespace {

constexpr const char* kWatched = "watched.bin";
constexpr std::chrono::milliseconds kSlow{100};
std::atomic<bool> slow{false};
std::atomic<int> watched_fd{-1};
std::mutex guard;
std::set<std::thread::id> touched_by;

void touch() {
  {
    const std::lock_guard lock(guard);
    touched_by.insert(std::this_thread::get_id());
  }
  if (slow) std::this_thread::sleep_for(kSlow);
}

}  // namespace

extern "C" int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const auto mode = va_arg(more, mode_t);
  va_end(more);
  const bool watched = std::strstr(path, kWatched) != nullptr && (flags & O_CREAT) != 0;
  if (watched) touch();
  const int fd = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  if (watched) watched_fd = fd;
  return fd;
}
extern "C" ssize_t write(int fd, const void* bytes, std::size_t size) {
  if (fd == watched_fd) touch();
  return ::syscall(SYS_write, fd, bytes, size);
}
extern "C" int unlink(const char* path) noexcept {
  if (std::strstr(path, kWatched) != nullptr) touch();
  return static_cast<int>(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}
extern "C" int close(int fd) {
  if (fd == watched_fd) touch(), watched_fd = -1;
  return static_cast<int>(::syscall(SYS_close, fd));
}

namespace gantry::record {
namespace {

class FileWriters : public ::testing::Test {
 protected:
  void TearDown() override { slow = false; }
  [[nodiscard]] std::string read() const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  const Folder folder;
  const std::string path = folder.path + "/" + kWatched;
};

TEST_F(FileWriters, a_slow_disk_is_the_writers_alone_from_opening_to_closing) {
  std::ofstream(path) << "of a job before";
  touched_by.clear();
  slow = true;
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  FileWriter writer(path, FileWriter::Thread::Own);
  std::string all;
  for (int i = 0; i < 20; ++i) {
    std::string piece(70'000, static_cast<char>('a' + i));
    all += piece;
    writer.write(std::move(piece));
  }
  const auto fed = Clock::now() - begin;
  ASSERT_TRUE(writer.close());
  EXPECT_GT(Clock::now() - begin, 20 * kSlow) << "the disk was slow";
  EXPECT_LT(fed, kSlow) << "and its feeder did not wait for it once";
  slow = false;
  const std::lock_guard lock(guard);
  EXPECT_EQ(touched_by.size(), 1u);
  EXPECT_EQ(touched_by.count(std::this_thread::get_id()), 0u);
  EXPECT_EQ(read(), all);
}

TEST_F(FileWriters, without_a_thread_of_its_own_the_caller_writes) {
  touched_by.clear();
  FileWriter writer(path, FileWriter::Thread::Callers);
  writer.write("abc");
  ASSERT_TRUE(writer.close());
  const std::lock_guard lock(guard);
  EXPECT_EQ(touched_by, (std::set<std::thread::id>{std::this_thread::get_id()}));
  EXPECT_EQ(read(), "abc");
}

TEST_F(FileWriters, a_writer_that_is_not_closed_ends_its_thread) {
  FileWriter writer(path, FileWriter::Thread::Own);
  writer.write("abc");
}

}  // namespace
}  // namespace gantry::record
