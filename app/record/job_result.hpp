// What is known of a job when it has ended: filled by the runner and the trace, shown by summary.json and report.html.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/job/job_times.hpp"
#include "app/job/nearest.hpp"
#include "app/job/proofs_ahead.hpp"
#include "app/record/envelope_line.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"
#include "devices/rt/cyclic_counts.hpp"
#include "recipes/job.hpp"
#include "recipes/travel.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::record {

struct MarkResult {
  std::string name;
  bool found = false;
  Vec2 nominal;            ///< board frame, mm
  Vec2 measured;           ///< where it was found, in the frame of the nominal placement, mm
  double residual_mm = 0;  ///< after the fit
  int attempts = 0;
  std::string reason;          ///< why it was not found ...
  Fault fault = Fault::None;   ///< ... MarkNotFound, MarkAmbiguous
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
  double lift_mm = 0;   ///< U, which lowers what rides on it
  double turn_rad = 0;  ///< C, which turns what turns with it
};

/// It grows while the machine is served, and may hold millions of points: none of them is ever copied to make room.
using Path = std::deque<PathPoint>;

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
  std::uint64_t skipped = 0;  ///< slept through
  std::uint64_t stalls =
      0;  ///< wake-ups that came a cycle late or more: each skips cycles, but in a machine simulated in this process
  std::uint64_t deadline_misses = 0;  ///< skipped, or not done when the next cycle was due
  Quantiles wake, compute, bus;
  std::vector<HistogramBucket> wake_histogram, compute_histogram;
  bool real_time_priority = false, memory_locked = false;
  bool virtual_time = false;
  int frames_lost_max = 0;            ///< in a row: so many stop the machine
  devices::CyclicCounts frames;       ///< of the job's frames, each as what it was
  std::uint64_t mailbox_repeats = 0;  ///< answers of stations that were asked for once more, and requests sent again
};

struct AxisResult {
  std::string name;
  bool measured = false;                             ///< false on an open-loop axis: following error is n/a
  double max_following = 0;                          ///< mm or rad, while enabled
  double allowed_there = 0;                          ///< at the speed that the axis had then; 0: none is watched
  bool rotary = false;                               ///< rad instead of mm
  double allowed_at_rest = 0, allowed_at_v_max = 0;  ///< the window, which grows with the speed; 0: none is watched
  std::vector<EnvelopePoint> over_time{};            ///< largest following error, and what is allowed at that speed
};

using Deposit = sim::Deposit;
/// Whether it lies on a feature. A shot of purging has an id as well, and a feature may have the same.
inline bool on_feature(const Deposit& d) { return !d.id.empty() && d.kind != sim::kPurgeKind; }
using Collision = sim::Collision;

struct DrawnPart {
  std::string name;
  Vec2 at;  ///< centre, board frame
  Vec3 size;
  double rotation = 0;   ///< rad
  bool fixture = false;  ///< stands where it stands, however the board lies
};

/// What a deposit may differ by: its material's tolerances, and what its corners may be rounded by.
struct Allowed {
  double beside_mm = recipes::Material{}.tolerance_mm;
  double gap_mm = recipes::Material{}.gap_tolerance_mm;
};

/// A body of the scene; machine frame, but for those of the head, which are in the head's.
struct DrawnBody {
  enum class Role { Machine, Board, Part, Fixture, Head, Zone } role = Role::Machine;
  config::Body body;
};

/// A mark or a point of touch, machine frame.
struct DrawnSpot {
  std::string name;
  Vec3 at;
  bool touch = false;
};

/// What the report draws under the path. Made by drawing_of() and placed_drawing().
struct Drawing {
  Vec2 board_size;
  Vec3 board_origin;  ///< nominal position of the origin of the board's top face, machine frame
  std::vector<DrawnPart> parts;
  std::vector<Vec3> tip_of_block;  ///< by block number: from the head's X Y Z to the tip of the tool that works there
  Vec3 lifted_tip;                 ///< that of the tool which rides on the lift, at the lift where it works
  double lifted_at_mm = 0;
  std::map<std::string, Allowed> allowed;  ///< by feature
  std::vector<DrawnBody> bodies;
  std::vector<DrawnSpot> spots;
  std::vector<std::vector<Vec3>> asked;     ///< features as the recipe asks for them, machine frame: a dot is one point
  std::array<std::size_t, 3> xyz{0, 1, 2};  ///< which of the axes carry the head
  std::optional<std::size_t> lift;          ///< and which one the lift
  std::optional<std::size_t> turn;          ///< and which one the turn
  Vec2 turn_axis;                           ///< about which it turns, in the head's frame
  Vec3 park;                                ///< X Y Z
  double park_turn_rad = 0;
};

/// A bead as the recipe draws it.
struct DrawnBead {
  std::string id, kind;
  double length_mm = 0;
};

struct Fact {
  std::string name, value;
};

/// The board after the job: what a line controller branches on.
enum class Board {
  Untouched,  ///< nothing lies on it
  Begun,      ///< something of it is missing
  Whole,      ///< all of it is within tolerance
  Defects,    ///< all of it is there, and not all of it is good
};

/// Something about the board that is not as the recipe wants it.
struct Defect {
  enum class Kind { Missing, Cut, Beside, Gap, Amount, Speed, Extra, Reference, Late };
  std::string feature;  ///< its id; empty: no feature's
  Kind kind = Kind::Missing;
  std::string message;
};

/// What somebody did to the machine while the job ran, or what latched.
struct Stamped {
  std::string utc;  ///< "2026-11-21T08:30:16.123Z"
  double t_s = 0;   ///< since the job began, by the machine's clock
  std::string what;
  std::string code;  ///< of an alarm: "G704"
};

/// A bead that a hold has cut, and that was joined there.
struct Joined {
  std::string feature;
  double at_mm = 0;    ///< along its motion
  double after_s = 0;  ///< from its valve's shutting to its opening again
};

/// What lies on a board already when a job begins that leaves features out.
struct OnBoard {
  std::vector<bool> whole;      ///< by index in Recipe::features; empty: nothing does
  std::vector<Defect> defects;  ///< of what lies there
  [[nodiscard]] bool is_whole(std::size_t feature) const { return feature < whole.size() && whole[feature]; }
};

/// Options that mean the machine of a job, as a person would write them again: " --machine cell.yaml"; "": none.
struct SameMachine {
  std::string all{};  ///< of every verb
  std::string run{};  ///< of `run` besides: " --bus ethercat:eth0"
};

/// From what a job was made.
struct Origin {
  std::string recipe_sha256, machine_file, machine_sha256;  ///< "": not known
  std::string serial;                                       ///< of the part; "": it has none
  std::vector<recipes::Source> profiles{};                  ///< of the machine's stations, each once
  SameMachine same_machine{};
};

/// A file of the job's folder that could not be written.
struct NotKept {
  std::string file;  ///< "setpoints.bin"
  std::string why;
};

/// The motions of a certificate, which stand in a file beside it.
struct MotionsListed {
  std::size_t count = 0;
  std::string sha256;  ///< of the file's bytes
};

struct JobResult {
  std::string job;  ///< name of the output folder
  std::string recipe_file, recipe_name, machine_name, bus;
  Origin origin;
  std::vector<Stamped> actions;  ///< orders and buttons, in order
  std::vector<Stamped> alarms;   ///< what latched, in order
  bool dry_run = false;
  std::vector<Error> errors;  ///< empty: done
  ExitCode exit_code = ExitCode::Done;
  Board board = Board::Untouched;
  std::string to_finish;        ///< of a begun board that is remembered: what `run` dispenses then, "--only a,b"
  std::string unseen;           ///< of one with a job that was lost: the same of what nobody saw whether it lies there
  std::vector<Defect> defects;  ///< of the features in their order, then of the board; also of a job that failed
  std::size_t blocks_done = 0, blocks_total = 0;
  recipes::Order order = recipes::Order::File;
  recipes::Travel travel;                             ///< between the features that are dispensed
  std::size_t features_done = 0, features_total = 0;  ///< done: the valve has opened and closed for it as planned
  std::size_t marks_total = 0;                        ///< of the recipe, whether they were looked for or not
  std::vector<std::string> interrupted;  ///< features that a stop has cut or kept dry, in the order of the recipe
  std::vector<std::string> once_more;    ///< features of its order that had lain on the board already
  std::map<std::string, std::string> stays_cut;  ///< by feature: why a cut that a hold has made was not joined
  std::vector<Joined> joined;                    ///< in the order in which they were
  std::vector<MarkResult> marks;
  recipes::WorkOffset offset;
  double offset_rms_mm = 0;
  bool has_offset = false;
  bool length_only = false;  ///< two marks: nothing but their distance shows that they are the right ones
  std::vector<TouchResult> touches;
  recipes::Surface surface;
  bool has_surface = false;
  double predicted_s = 0;             ///< of all blocks and images, forecast before the first motion; 0: nobody has
  double actual_s = 0;                ///< what they took, holds on the way included
  double images_s = 0;                ///< of these, for images to be taken
  std::vector<job::StepTaken> steps;  ///< in order
  std::vector<job::FeatureTaken> feature_times;  ///< by index in Recipe::features
  std::vector<std::string> feature_names;        ///< by the same index
  std::vector<std::size_t> feature_order;        ///< of those that the job dispenses: indices, in its order
  std::vector<recipes::Material> materials;      ///< of the recipe
  double wall_s = 0;                             ///< of the whole run on the host
  std::vector<AxisResult> axes;
  CycleStatistics cycles;
  std::uint64_t setpoint_hash = 0;
  std::uint64_t setpoint_ticks = 0;  ///< how many ticks the hash covers
  /// By a hold, an override, a stop, or features that were left out: its hash is not that of another run.
  bool disturbed = false;
  bool setpoint_stream_complete = true;  ///< false: snapshots were lost and the hash says nothing
  job::Clearances minimum_clearance;     ///< of all certified motions
  std::size_t motions_certified = 0;
  job::ProofsAhead proofs;
  std::optional<MotionsListed> motions_listed{};  ///< of a dry run
  std::size_t opinion_poses = 0;  ///< along them, of which a second opinion was asked; 0: nobody was asked
  Path planned, actual;
  bool has_world = false;  ///< deposits and collisions are known (simulated machine)
  std::vector<Deposit> deposits;
  std::vector<Collision> collisions;
  std::string placement;            ///< hidden truth of the virtual board, for the report
  std::vector<NotKept> not_kept;    ///< which says nothing against the board
  std::vector<std::string> events;  ///< "12.345 s  drive fault X ..." in order
  std::string started;              ///< "2026-11-21 08:30:16 UTC"
  std::uint64_t valve_openings = 0;
  std::size_t purge_shots = 0;  ///< of these
  double valve_open_s = 0;
  std::vector<recipes::Source> sources;  ///< the files that the recipe is made of
  std::vector<DrawnBead> beads;          ///< in the order of the recipe
  std::vector<recipes::Fill> fills;
  Drawing drawing;
  std::vector<Fact> environment;  ///< host, kernel ... : environment_facts()
};

/// Not all that it was to do is done, and something other than its end has ended it.
inline bool ended_early(const JobResult& r) {
  return r.exit_code != ExitCode::Done && r.exit_code != ExitCode::DoneWithDefects;
}

}  // namespace gantry::record
