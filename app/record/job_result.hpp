// What is known of a job when it has ended: filled by the runner and the trace, shown by summary.json and report.html.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "app/job/nearest.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"
#include "devices/rt/cyclic_counts.hpp"
#include "recipes/job.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::record {

struct MarkResult {
  std::string name;
  bool found = false;
  Vec2 nominal;            ///< board frame, mm
  Vec2 measured;           ///< where it was found, in the frame of the nominal placement, mm
  double residual_mm = 0;  ///< after the fit
  int attempts = 0;
  std::string reason;          ///< why it was not found
  std::vector<std::byte> png;  ///< what the camera saw, with the found outline
};

struct TouchResult {
  std::string name;
  Vec2 at;               ///< board frame
  double height_mm = 0;  ///< surface over its nominal height
  double residual_mm = 0;
};

/// Where the needle, camera or probe was to go, and where it went; machine frame, thinned for drawing.
struct PathPoint {
  double t_s = 0;  ///< since the job began, as events and collisions count; homing comes before the first block
  Vec3 head;       ///< X Y Z of the axes
  std::uint32_t block = 0;
  bool valve = false;
  double lift_mm = 0;  ///< U, which lowers what rides on it
};

struct Quantiles {  ///< ns
  std::int64_t p50 = 0, p99 = 0, p999 = 0, max = 0;
};

/// `count` values at or below `upper_ns` and above the bucket before.
struct HistogramBucket {
  std::int64_t upper_ns = 0;
  std::uint64_t count = 0;
};

struct CycleStatistics {
  std::uint64_t cycles = 0, sent = 0, frames_lost = 0, working_counter_errors = 0;
  std::uint64_t skipped = 0;          ///< slept through
  std::uint64_t stalls = 0;           ///< wake-ups that came more than a cycle late; each skips one cycle or more
  std::uint64_t deadline_misses = 0;  ///< skipped, or not done when the next cycle was due
  Quantiles wake, compute, bus;
  std::vector<HistogramBucket> wake_histogram, compute_histogram, bus_histogram;
  bool real_time_priority = false, memory_locked = false;
  bool virtual_time = false;
  int frames_lost_max = 0;       ///< in a row, that are forgiven
  devices::CyclicCounts frames;  ///< of the job's frames, each as what it was
};

struct AxisResult {
  std::string name;
  bool measured = false;                             ///< false on an open-loop axis: following error is n/a
  double max_following = 0;                          ///< mm or rad, while enabled
  bool rotary = false;                               ///< rad instead of mm
  double allowed_at_rest = 0, allowed_at_v_max = 0;  ///< the window, which grows with the speed; 0: none is watched
};

using Deposit = sim::Deposit;
using Collision = sim::Collision;

struct DrawnPart {
  std::string name;
  Vec2 at;  ///< centre, board frame
  Vec3 size;
  double rotation = 0;   ///< rad
  bool fixture = false;  ///< stands where it stands, however the board lies
};

/// What the report draws under the path. Filled by drawing_of().
struct Drawing {
  Vec2 board_size;
  Vec3 board_origin;  ///< nominal position of the origin of the board's top face, machine frame
  std::vector<DrawnPart> parts;
  std::vector<Vec3> tip_of_block;  ///< by block number: from the head's X Y Z to the tip of the tool that works there
  Vec3 lifted_tip;                 ///< that of the tool which rides on the lift, at the lift where it works
  double lifted_at_mm = 0;
  std::map<std::string, double> corner_tolerance_mm;  ///< by feature; a bead may round its corners by so much
};

struct Fact {
  std::string name, value;
};

struct JobResult {
  std::string job;  ///< name of the output folder
  std::string recipe_file, recipe_name, machine_name, bus;
  bool dry_run = false;
  std::vector<Error> errors;  ///< empty: done
  ExitCode exit_code = ExitCode::Done;
  std::size_t blocks_done = 0, blocks_total = 0;
  std::size_t features_done = 0, features_total = 0;  ///< done: the valve has opened and closed for it as planned
  std::vector<std::string> interrupted;  ///< features that a stop has cut or kept dry, in the order of the recipe
  std::vector<MarkResult> marks;
  recipes::WorkOffset offset;
  double offset_rms_mm = 0;
  bool has_offset = false;
  std::vector<TouchResult> touches;
  recipes::Surface surface;
  double predicted_s = 0, actual_s = 0;  ///< motion time of the blocks, planned and played
  double wall_s = 0;                     ///< of the whole run on the host
  std::vector<AxisResult> axes;
  CycleStatistics cycles;
  std::uint64_t setpoint_hash = 0;
  std::uint64_t setpoint_ticks = 0;      ///< how many ticks the hash covers
  bool setpoint_stream_complete = true;  ///< false: snapshots were lost and the hash says nothing
  job::Clearances minimum_clearance;     ///< of all certified motions
  std::size_t motions_certified = 0;
  std::vector<PathPoint> planned, actual;
  bool has_world = false;  ///< deposits and collisions are known (simulated machine)
  std::vector<Deposit> deposits;
  std::vector<Collision> collisions;
  std::string placement;            ///< hidden truth of the virtual board, for the report
  std::vector<std::string> events;  ///< "12.345 s  drive fault X ..." in order
  std::string started;              ///< "2026-11-21 08:30:16 UTC"
  std::uint64_t valve_openings = 0;
  double valve_open_s = 0;
  Drawing drawing;
  std::vector<Fact> environment;  ///< host, kernel ... : environment_facts()
};

}  // namespace gantry::record
