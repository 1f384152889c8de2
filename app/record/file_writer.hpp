// Writes a file that grows while a job runs: in a thread of its own, so that a slow disk holds up nobody who feeds
// motion; in virtual time, where nothing runs beside the cycle, at once.
//   auto writer = FileWriter::create("out/job/setpoints.bin", FileWriter::Thread::Own);
//   (*writer)->write(std::move(bytes)); ...   (*writer)->close();
// What cannot be written takes the whole file away: its room is free for what is worth more.
#pragma once
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "core/new_file.hpp"

namespace gantry::record {

class FileWriter {
 public:
  enum class Thread { Callers, Own };
  /// Fault::FileUnwritable.
  static Result<std::unique_ptr<FileWriter>> create(const std::string& path, Thread thread);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// Takes some dozen microseconds with a thread of its own. A disk that is kLongestQueue behind counts as full.
  void write(std::string bytes);
  /// Waits until all is written. Fault::FileUnwritable: there is no file.
  Result<void> close();

  static constexpr std::size_t kLongestQueue = 64'000'000;  ///< bytes

 private:
  explicit FileWriter(NewFile file) : file_(std::move(file)) {}
  void put(const std::string& bytes);
  void serve();
  void end_thread();

  NewFile file_;  ///< the thread's, where there is one, until it has ended
  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<std::string> queue_;
  std::size_t queued_ = 0;
  bool ends_ = false, too_slow_ = false;
  std::thread thread_;
};

}  // namespace gantry::record
