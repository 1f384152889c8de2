// The world's memory: an append-only, memory-mapped file, so that board, deposits, motors and the valve's counter
// outlive both the controller and, in `gantry sim`, the world's own process. Appending is a copy into mapped memory: no
// system call in the bus thread, and nothing is lost when the process is killed (only when the host loses power).
// A bead is written point by point, so that one during which the process dies is remembered as far as it came.
//   auto log = WorldLog::open(dir);   for (const Record& r : log->records()) ...;   log->append(kind, bytes);
// File: records of {magic, kind, size, crc32, payload}, 8-byte aligned; the first that does not check ends the file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace gantry::sim {

class WorldLog {
 public:
  enum class Kind : std::uint32_t {
    Board = 1,    ///< JSON: plan, placement, number of the board
    JobBegin,     ///< empty
    ShotOpened,   ///< ShotRecord
    ShotPoint,    ///< ShotRecord
    ShotClosed,   ///< ShotRecord
    Motors,       ///< doubles, as the bus side gives them
    Collision,    ///< JSON
    ClampOpened,  ///< empty: the controller has let the board go
    ClampClosed,  ///< empty
  };
  struct Record {
    Kind kind{};
    std::span<const std::byte> payload;
  };

  /// Makes the folder when it is missing. A damaged end is cut, kept in world.log.cut and told. Fault::FileUnreadable
  /// (nothing in it can be read), FileUnwritable, SecondOwner when another process has it open.
  static Result<std::unique_ptr<WorldLog>> open(const std::string& dir);
  ~WorldLog();
  WorldLog(const WorldLog&) = delete;
  WorldLog& operator=(const WorldLog&) = delete;

  [[nodiscard]] std::vector<Record> records() const;
  /// False when the room is used up; the record was not taken. Safe on the bus thread.
  bool append(Kind kind, std::span<const std::byte> payload) noexcept;
  /// Makes room for a job's worth of records, on a small disk for less. Fault::FileUnwritable: there is none. Not on
  /// the bus thread. Spans of records() become invalid.
  Result<void> make_room();

 private:
  WorldLog(int file, std::string path) : file_(file), path_(std::move(path)) {}
  void tell_refused() const;
  Result<void> map(std::size_t bytes);
  [[nodiscard]] Result<void> allocate();
  [[nodiscard]] Result<std::vector<std::byte>> read_all() const;
  [[nodiscard]] Result<void> keep_tail(std::span<const std::byte> bytes, std::size_t used) const;

  int file_ = -1;
  std::string path_;
  std::byte* memory_ = nullptr;
  std::size_t mapped_ = 0, used_ = 0, allocated_ = 0;  ///< used <= allocated <= mapped
  std::uint64_t refused_ = 0;                          ///< records since room was last made
};

/// One point of a shot, and the instant for its ends.
struct ShotRecord {
  std::int64_t at_ns = 0;
  std::uint64_t cycle = 0;
  double x = 0, y = 0, z = 0;
};

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t seed = 0) noexcept;

}  // namespace gantry::sim
