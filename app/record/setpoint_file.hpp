// The commanded stream of a job on disk, so that two runs can be compared tick by tick where both sent.
//   auto file = SetpointFile::create("out/job/setpoints.bin");   file->add(snapshot); ...   file->close();
//   auto c = compare("out/a/setpoints.bin", "out/b/setpoints.bin");   c->first_difference
// Off the RT thread, through a buffered stream. All numbers little-endian. Head: "GSETP1\0\0", drives u32, 0 u32. Then
// a record a tick of a block: block u32, tick u32, flags u32 (bit 0: sent), process outputs u32, counts i32 a drive.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "app/cycle/channels.hpp"
#include "core/error.hpp"
#include "core/new_file.hpp"

namespace gantry::record {

class SetpointFile {
 public:
  /// Fault::FileUnwritable.
  static Result<SetpointFile> create(const std::string& path);
  /// Takes what belongs to a block, leaves the rest.
  void add(const cycle::Snapshot& snapshot);
  /// Says whether everything reached the file. Fault::FileUnwritable.
  Result<void> close();

 private:
  explicit SetpointFile(NewFile out) : out_(std::move(out)) {}

  NewFile out_;
  bool has_head_ = false;
  std::uint32_t drives_ = 0;
};

struct SetpointDifference {
  std::uint32_t block = 0, tick = 0;
  std::string what;  ///< "counts of drive 2: 1200 and 1201"
};

struct SetpointComparison {
  std::uint64_t ticks_a = 0, ticks_b = 0;  ///< in the files, sent or not
  std::uint64_t common = 0;                ///< ticks that both sent
  std::uint64_t only_a = 0, only_b = 0;    ///< ticks that the other has not, or did not send
  std::optional<SetpointDifference> first_difference;
};

/// Fault::FileUnreadable, Fault::Inconsistent (no setpoint file, or another number of drives).
Result<SetpointComparison> compare(const std::string& path_a, const std::string& path_b);

}  // namespace gantry::record
