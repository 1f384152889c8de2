// Writes a file that grows while a job runs. With a thread of its own that thread alone touches the disk, from opening
// the file to closing it, so that a slow disk holds up nobody who feeds motion; in virtual time, where nothing runs
// beside the cycle, the caller does it at once.
//   FileWriter writer("out/job/setpoints.bin", FileWriter::Thread::Own);
//   writer.write(std::move(bytes)); ...   writer.close();
// What cannot be written takes the whole file away: its room is free for what is worth more.
#pragma once
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "core/new_file.hpp"

namespace gantry::record {

class FileWriter {
 public:
  enum class Thread { Callers, Own };
  /// Whether the file could be made says close().
  FileWriter(std::string path, Thread thread);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// Takes some dozen microseconds with a thread of its own. A disk that is kLongestQueue behind counts as full.
  void write(std::string bytes);
  /// Waits until all is written. Fault::FileUnwritable: there is no file.
  Result<void> close();

  static constexpr std::size_t kLongestQueue = 64'000'000;  ///< bytes

 private:
  void open();
  void put(const std::string& bytes);
  void finish();
  void serve();
  void end_thread();

  std::string path_;
  // The thread's, where there is one, until it has ended.
  std::optional<NewFile> file_;
  Result<void> done_;

  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<std::string> queue_;
  std::size_t queued_ = 0;
  bool ends_ = false, too_slow_ = false;
  std::thread thread_;
};

}  // namespace gantry::record
