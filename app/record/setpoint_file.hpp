// The commanded stream of a job on disk, so that two runs can be compared tick by tick where both sent.
//   SetpointFile file("out/job/setpoints.bin");   file.add(snapshot); ...   file.close();
//   auto c = compare("out/a/setpoints.bin", "out/b/setpoints.bin");   c->first_difference
// Off the RT thread. Head: "GSETP2\0\0", then, little-endian, drives u32 and 0 u32. Then the ticks of blocks, each with
// block, tick, whether it was sent, process outputs and counts of the drives, as setpoint_code.hpp says.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/cycle/channels.hpp"
#include "app/record/file_writer.hpp"
#include "app/record/setpoint_code.hpp"
#include "core/error.hpp"

namespace gantry::record {

class SetpointFile {
 public:
  explicit SetpointFile(const std::string& path, FileWriter::Thread thread = FileWriter::Thread::Callers)
      : out_(std::make_unique<FileWriter>(path, thread)) {}
  /// Takes what belongs to a block, leaves the rest.
  void add(const cycle::Snapshot& snapshot);
  /// Says whether everything reached the file. Fault::FileUnwritable: then there is none, because it could not be made,
  /// or since the disk was full: a stream with a hole compares with nothing, and its room is better used.
  Result<void> close();

 private:
  void begin(std::uint32_t drives);

  std::unique_ptr<FileWriter> out_;
  std::optional<SetpointEncoder> encoder_;
  std::string bytes_;  ///< not handed on yet
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
