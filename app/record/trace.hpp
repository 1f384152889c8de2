// What the snapshots of a job add up to: the actual path, thinned for drawing, the largest following error of each
// axis, and the statistics of the cycle.
//   Trace trace(machine);   trace.add(snapshot); ...   trace.fill(result);
// Lives with the one reader of snapshots, off the RT thread. Memory grows with the path, not with the cycles.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/cycle/channels.hpp"
#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "core/rt/histogram.hpp"

namespace gantry::record {

/// Keeps a point about every 10 ms while the head moves, and every point where it turned, the valve switched or a block
/// began; standing still costs two points however long it lasts.
class ThinPath {
 public:
  void add(const PathPoint& point);
  /// What was kept; nothing of it stays.
  [[nodiscard]] Path take();

 private:
  Path kept_;
  std::optional<PathPoint> last_;  // newest point that is not kept yet
};

class Trace {
 public:
  /// `start_ns`: when the job began, from which the path's time counts; without it, its first block.
  explicit Trace(const config::Machine& machine, std::optional<std::int64_t> start_ns = std::nullopt);
  void add(const cycle::Snapshot& snapshot);

  /// Sets actual, actual_s, axes, the valve's figures and the counted part of cycles.
  void fill(JobResult& result);

 private:
  void add_cycle(const cycle::Snapshot& snapshot);
  void add_valve(const cycle::Snapshot& snapshot);
  void add_following(const cycle::Snapshot& snapshot);

  struct Axis {
    std::string name;
    bool rotary = false, measured = false;
    double max_following = 0, allowed_there = 0, allowed_at_rest = 0, allowed_at_v_max = 0, per_speed_s = 0;
    double target = 0;  ///< of the cycle before
    EnvelopeLine over_time{};
  };
  std::vector<Axis> axes_;
  CycleIndex target_cycle_ = 0;  ///< of the axes' targets
  std::array<std::size_t, 3> xyz_;
  std::optional<std::size_t> lift_, turn_;
  std::int64_t cycle_ns_;

  ThinPath path_;
  std::optional<std::int64_t> start_ns_;
  std::uint64_t block_ticks_ = 0;
  bool valve_ = false;
  std::uint64_t valve_openings_ = 0, valve_ticks_ = 0;

  rt::Histogram wake_, compute_, bus_;
  std::int64_t asleep_ = 0;  ///< cycles skipped since the last one that was sent
  CycleStatistics cycles_;
};

}  // namespace gantry::record
