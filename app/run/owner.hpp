// The owner of a machine: bus, loop, planner, eyes and world as one object with orders in and events out. `gantry up`
// keeps one until it is stopped; `run` and `dry-run` make their own for one job.
//   Result<std::unique_ptr<Owner>> opened = Owner::open(machine, options);
//   Owner& owner = **opened;   owner.bring_up();
//   JobResult r = owner.run(recipe, job, {.out = "out/x"});   owner.shut_down();
// One thread calls it (the run thread). In virtual time that thread also steps the loop; otherwise the loop has its
// own.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/job/slow_beads.hpp"
#include "app/monitor/network.hpp"
#include "app/record/job_result.hpp"
#include "app/run/control.hpp"
#include "app/run/order.hpp"
#include "app/run/undertaking.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "motion/plan/second_opinion.hpp"
#include "recipes/job.hpp"
#include "sim/machine/simulated_machine.hpp"

namespace gantry::run {

struct OwnerOptions {
  std::string bus = "sim";            ///< "sim", or "ethercat:IFACE"
  bool virtual_time = false;          ///< with "sim" only
  std::string state{};                ///< folder with what was accepted of the stations; "": nothing was
  std::string world_socket;           ///< camera and world of a `gantry sim` elsewhere
  sim::SimulatedMachineOptions sim;   ///< of the simulated machine in this process, and of the board it is given
  bool publish = false;               ///< start `gantry publish` and keep it alive
  monitor::NetworkOptions network{};  ///< of the publisher
  std::string name{};                 ///< of the machine on DDS; "": as in the machine file
  bool (*interrupted)() = nullptr;    ///< whether the program was asked to end, while the bus is brought up
  std::optional<int> loop_cpu;  ///< for the loop alone; default: the last one that may be used, if there are several
};

/// Fault::Usage: what is wrong with options by themselves, whichever machine they are for. Asked before long work, and
/// by Owner::open().
Result<void> check(const OwnerOptions& options);

/// Of what moves axes: on hold it waits before its first motion for a resume.
enum class Begin { AtOnce, OnHold };

struct RunOptions {
  std::string out{};                        ///< folder for the results; "" keeps nothing
  bool dry_run = false;                     ///< as the result says it
  const job::Forecast* forecast = nullptr;  ///< of the job, from the park position; null: there is none
  std::string serial{};                     ///< of the part
  record::SameMachine same_machine{};       ///< for the result's words, which the desk adds
  bool another_board = false;               ///< the one in a simulated machine was taken out since
  record::OnBoard before{};                 ///< what jobs before it have left there; not empty: the clamp stays shut
  Begin begin = Begin::AtOnce;
  std::span<const job::SlowBead> slow_beads{};  ///< of the job's proof
  /// A path stop by door, air, stop button or timing (Clear::Resume) leaves the job on hold until somebody resets and
  /// resumes; else it ends it.
  bool outlives_stops = false;
  motion::Opinion opinion{};  ///< asked of each motion before it is played; empty: nobody is
  bool goes_on = false;       ///< the owner lives on: what a world script has for a later cycle may still happen
};

/// What a jog came to: where the axes were sent, mm or rad, and the machine time from the order until they stood.
struct Jogged {
  std::uint32_t axes = 0;  ///< bit n: AxisId n was named
  AxisVec start{}, end{};
  double duration_s = 0;
  std::string slowed{};  ///< why it went slower than was asked for; empty where it did not
};

/// Where a job is, for a progress bar.
struct Progress {
  std::size_t features_done = 0, features_total = 0;
  std::string doing;      ///< "mark M2", "touch T1", "dots[3][2]"
  std::string feature{};  ///< that is dispensed, or on the way to which the head is; "": none
  double elapsed_s = 0;
  std::optional<double> remaining_s{};    ///< about; Recording::remaining_s()
  std::optional<double> override_next{};  ///< that waits for the valve to be shut; a factor
};

/// What became of the bus's frames, and what stations had to be asked for once more.
struct WireCounts {
  devices::CyclicCounts frames;  ///< of the cycles
  std::uint64_t mailbox_repeats = 0;
  std::string other_master;  ///< source address of its frames, in words; empty: there was none
};

struct Standing;

class Owner {
 public:
  static Result<std::unique_ptr<Owner>> open(const config::Machine& machine, const OwnerOptions& options);
  ~Owner();
  Owner(const Owner&) = delete;
  Owner& operator=(const Owner&) = delete;

  /// Scan, configuration, OP; the loop runs, drives are without torque.
  Result<void> bring_up();
  /// Drives to Operation Enabled. No axis moves.
  Result<void> enable();
  /// The same, and every axis is homed, lowest order first, when what is on hold is released; or those that are named
  /// alone, which needs X, Y and Z to be referenced. Where they are, what may be swept is proved first
  /// (app/job/prove_homing.hpp). Fault::Collision, NotReferenced, UnknownReference, Latched ...
  Result<void> home(const std::vector<std::string>& axes = {}, Begin begin = Begin::AtOnce);
  Result<void> disable();
  /// Some axes by a displacement, straight; app/job/jog.hpp. Enables the drives, and homes nothing. Nothing moves
  /// unless the whole path is proved free, of the machine's own bodies and of the board and parts of the last job,
  /// where that job has found them. Fault::NotReferenced, OutOfReach, Collision, Latched ...; Aborted, Interrupted when
  /// it was stopped. One for a client is no faster than what stands in time when that falls silent, which is whoever
  /// asks to see to (app/job/hold_to_run.hpp).
  Result<Jogged> jog(const job::JogWords& words, Begin begin = Begin::AtOnce, job::JogFor whom = job::JogFor::Program);
  /// From where the head stands to the machine's park position: straight up to the safe height first, then a free path;
  /// app/job/park.hpp. It enables, homes nothing, and is proved like a jog; the clamp may be open.
  /// Fault::SetupMode, NotReferenced, Collision, Latched ...; Aborted, Interrupted when it was stopped.
  Result<void> park(Begin begin = Begin::AtOnce);
  /// One axis goes a short distance and back, to be watched (app/job/walk.hpp). It need not be
  /// referenced; it is done in setup only, where the machine has such a mode. Fault::LimitSwitch when an axis stands on
  /// one.
  Result<void> walk(const std::string& axis);
  /// A person has seen every axis move as the machine file says: kept with what stands on the bus now, in the state
  /// folder. Fault::FileUnwritable.
  Result<void> keep_walk(const std::string& date);
  /// A person has seen otherwise: what earlier walks and accepted serial numbers said of where drives stand is void.
  /// False: there was nothing. Fault::FileUnwritable.
  Result<bool> forget_walk();
  /// One job from its first block to its end. Never throws away what happened: the result tells it, also of a job that
  /// failed.
  record::JobResult run(const recipes::Recipe& recipe, const recipes::Job& job, const RunOptions& options);
  /// The part is taken out by hand: the clamp opens.
  Result<void> part_removed();
  /// Torque off, bus down in order. Also done by the destructor.
  void shut_down();

  /// Hold, resume, abort, override, reset: at once. Fault::Refused when the order does not fit; the message names what
  /// lifts the refusal. An abort is never refused and never undone: it holds until what it has ended is over. What a
  /// reset came to is told by reset_answer().
  Result<void> order(const Order& order);
  /// How far along its path the tool goes on at most when a hold, an abort or a stop comes now; nothing: it stands.
  [[nodiscard]] std::optional<double> stop_mm() const;
  /// What the last hold or override that was taken leads to: "holds after 'bead 7', in 1.20 s", "80 % when the valve
  /// has shut"; "" where it takes effect at once, on no feature.
  [[nodiscard]] std::string order_said() const;
  /// Of the last reset that was taken: nothing as long as it is under way, or when it was told already. Fault of what
  /// stays latched.
  std::optional<Result<void>> reset_answer();
  /// Whoever serves this owner has taken a stop of what is still to begin: a start button that is pressed before its
  /// answer can be heard counts for nothing.
  void stop_was_taken();
  /// What is under way ends with `why` as soon as the machine stands; what comes after it is not concerned.
  void abort(Error why);
  /// The same; with Fault::Interrupted (Ctrl-C of the program itself) nothing is undertaken any more.
  void interrupt(Error why);
  /// Called in every waiting step of the run thread: where orders are polled and progress is shown.
  void on_step(std::function<void()> poll);
  /// Runs `work`, which may wait for a disk, to its end on a thread of its own while the machine is served and orders
  /// come in; at once in this thread in virtual time, and where no bus is up. It must touch nothing that a step
  /// touches.
  void aside(const std::function<void()>& work);
  /// One step of waiting (an owner that has nothing to do). Fault::LoopDied when the loop hangs: shut_down() is what is
  /// left.
  Result<void> idle();

  /// Its bus as results name it: OwnerOptions::bus.
  [[nodiscard]] const std::string& bus() const;
  [[nodiscard]] const cycle::Snapshot& latest() const;
  /// What is wrong with the machine: the latched fault first, in words; empty while none is.
  [[nodiscard]] std::vector<Error> active_faults() const;
  [[nodiscard]] Progress progress() const;
  /// What the bus has counted since it came up.
  [[nodiscard]] WireCounts wire() const;
  [[nodiscard]] Undertaking undertaking() const;
  /// As refusals tell it (refusal.hpp).
  [[nodiscard]] Standing standing() const;
  /// On hold, or on the way there: a resume goes on, behind a reset where a fault has stopped the job.
  [[nodiscard]] bool held() const;
  /// The same, because of the machine's own hold button.
  [[nodiscard]] bool held_by_button() const;
  /// The fault that has stopped the job and that it outlives; nothing once a reset has cleared it.
  [[nodiscard]] std::optional<Error> stopped() const;
  /// As people are told it: a job that waits between two motions is held.
  [[nodiscard]] cycle::State state() const;
  /// The mode switch says setup: only a jog may move the machine.
  [[nodiscard]] bool in_setup() const;
  /// The start button was pressed on an idle machine, and this is the first to ask.
  [[nodiscard]] bool take_start();
  /// The same of the hold button: a job may be about to begin.
  [[nodiscard]] bool take_hold();
  /// What a person beside a simulated machine would see; null on a machine of steel.
  [[nodiscard]] sim::WorldAccess* world() const;

 private:
  struct Parts;
  class Turn;
  explicit Owner(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace gantry::run
