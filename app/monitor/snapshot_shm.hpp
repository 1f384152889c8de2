// The memory between the owner of the machine and `gantry publish`: snapshots, events, active alarms and the job's
// progress. The owner writes and never waits; whoever reads cannot disturb it (its view is read-only, and the memory
// can neither shrink nor grow under the owner, nor be written through another mapping than the owner's).
//   auto shm = SnapshotWriter::create(machine_info(machine));     // the feed, off the RT thread
//   shm->push(snapshot);   shm->push(event, "what the drive says");   shm->push(job);   shm->alarms(active_faults);
//   auto in = SnapshotReader::open(3);     // the publisher, which has inherited the memory
// The memory is anonymous (memfd): it goes with the processes that hold it and leaves no file behind.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "app/monitor/lossy_ring.hpp"
#include "app/monitor/shared_values.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::monitor {

struct SharedMemory;

MachineInfo machine_info(const config::Machine& machine);
/// s since the cycle was written: grows when the loop stands still, whatever else the owner still says.
double age_s(const SharedSnapshot& shared);

class SnapshotWriter {
 public:
  /// Fault::Internal when the system gives no memory.
  static Result<SnapshotWriter> create(const MachineInfo& info);
  SnapshotWriter(SnapshotWriter&& other) noexcept;
  SnapshotWriter& operator=(SnapshotWriter&&) = delete;
  /// Readers see that the owner has gone in order.
  ~SnapshotWriter();

  /// One thread writes. No allocation, no lock, no wait.
  void push(const cycle::Snapshot& snapshot) noexcept;
  /// `count`: so often it came since it was last pushed.
  void push(const cycle::Event& event, std::string_view text = {}, std::uint32_t count = 1) noexcept;
  /// Something that is not the loop's to say, in words.
  void push(Told told, CycleIndex cycle, std::string_view text) noexcept;
  void push(const SharedJob& job) noexcept;
  /// What is wrong with the machine now, all of it. Each counts from when it was first in such a list; one fault is one
  /// alarm.
  void alarms(std::span<const Error> active) noexcept;
  /// A sign of life where no snapshots flow; push() is one too.
  void beat() noexcept;

  [[nodiscard]] int fd() const noexcept { return fd_; }
  [[nodiscard]] std::uint64_t session() const noexcept;

 private:
  SnapshotWriter(int fd, SharedMemory* memory) : fd_(fd), memory_(memory) {}
  int fd_ = -1;
  SharedMemory* memory_ = nullptr;
  SharedAlarms alarms_;  ///< as last stored
};

class SnapshotReader {
 public:
  /// fd stays the caller's and may be closed. Fault::Inconsistent: not this memory, or of another version of the
  /// program.
  static Result<SnapshotReader> open(int fd);
  SnapshotReader(SnapshotReader&& other) noexcept;
  SnapshotReader& operator=(SnapshotReader&&) = delete;
  ~SnapshotReader();

  [[nodiscard]] const MachineInfo& info() const noexcept;
  [[nodiscard]] std::uint64_t session() const noexcept;
  /// The newest cycle; false before the first.
  bool newest(SharedSnapshot& snapshot) const noexcept;
  /// Every cycle that this reader is quick enough for.
  bool next(SharedSnapshot& snapshot) noexcept;
  /// Every event since the owner started, as far as the memory reaches back (1024 of them). `number` counts from 0;
  /// where it jumps, events_lost() has grown.
  bool next(SharedEvent& event, std::uint64_t& number) noexcept;
  /// Number of the event that next() gives next: those below it were given or are lost.
  [[nodiscard]] std::uint64_t events_next() const noexcept { return events_.position; }
  bool job(SharedJob& job) const noexcept;
  /// False before the first list.
  bool alarms(SharedAlarms& alarms) const noexcept;
  [[nodiscard]] std::uint64_t events_lost() const noexcept { return events_.lost; }
  /// True when the owner has closed the memory or its process is gone.
  [[nodiscard]] bool writer_gone() const noexcept;
  /// s since the owner's last sign of life.
  [[nodiscard]] double silence_s() const noexcept;

 private:
  explicit SnapshotReader(const SharedMemory* memory);
  const SharedMemory* memory_ = nullptr;
  RingCursor snapshots_, events_;
};

}  // namespace gantry::monitor
