// What an owner is made of; see owner.hpp. Order matters: what stands below may use what stands above.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/cycle/crash_stop.hpp"
#include "app/cycle/thread.hpp"
#include "app/cycle/watchdog.hpp"
#include "app/monitor/child.hpp"
#include "app/monitor/snapshot_shm.hpp"
#include "app/run/aside.hpp"
#include "app/run/buttons.hpp"
#include "app/run/feed.hpp"
#include "app/run/owner.hpp"
#include "app/run/recording.hpp"
#include "app/run/recovery.hpp"
#include "app/run/refusal.hpp"
#include "app/run/runner.hpp"
#include "app/stations/active_faults.hpp"
#include "app/stations/culprits.hpp"
#include "app/stations/repeated_notes.hpp"
#include "app/stations/station_news.hpp"
#include "config/held_limits.hpp"
#include "devices/raw_socket_port.hpp"
#include "devices/station_bus.hpp"
#include "sim/machine/world_client.hpp"

namespace gantry::run {

/// What lives while the bus is up.
struct OnBus {
  OnBus(devices::StationBus& bus, const config::Machine& machine)
      : recovery(bus), culprits(bus), news(bus, machine), buttons(machine) {}

  std::unique_ptr<cycle::LoopThread> thread;  ///< in real time only
  std::unique_ptr<Pump> pump;
  std::unique_ptr<Control> control;
  Recovery recovery;
  stations::Culprits culprits;
  stations::StationNews news;
  std::unique_ptr<cycle::Watchdog> watchdog;  ///< these two while the stations are in OP
  std::unique_ptr<cycle::CrashStop> crash_stop;
  Buttons buttons;
  bool compared = false;                ///< what stations were given was read again since they have torque
  bool start_pressed = false;           ///< and nobody has taken it yet
  bool hold_pressed = false;            ///< the same, where nothing is under way that could be held
  std::optional<std::int64_t> stop_ns;  ///< machine time of the last hold or abort that was taken
  devices::CyclicCounts counted;        ///< as last reported
  std::uint64_t of_master = 0;          ///< frames of another one, as last reported
  std::int64_t counted_at_ns = 0;
  std::optional<Error> named;  ///< the last latched fault whose stations were found
  std::optional<Request> reset;
  std::optional<Result<void>> reset_answer;
};

/// What lives while a job runs.
struct RunningJob {
  /// The runner lists its motions where the recording keeps them.
  RunningJob(Recording kept, Site site, const recipes::Recipe& recipe, const recipes::Job& job,
             record::JobResult& result)
      : recording(std::move(kept)),
        runner((site.motions = recording.motions(), std::move(site)), recipe, job, result) {}

  Recording recording;
  Runner runner;
};

/// A fault of the loop, a station's news ..., and its words.
struct FaultInWords {
  cycle::Event event;
  Error words;
};

struct Owner::Parts {
  config::Machine machine;
  OwnerOptions options;
  std::unique_ptr<Clock> clock;
  std::unique_ptr<sim::SimulatedMachine> simulated_machine;
  std::unique_ptr<sim::WorldClient> world_client;
  std::unique_ptr<devices::RawSocketPort> raw_port;
  sim::WorldAccess* world = nullptr;  // null on a machine of steel
  devices::CanPort* can = nullptr;
  std::unique_ptr<devices::StationBus> bus;
  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  std::unique_ptr<cycle::StopFrame> stop;  // on a bus that others than the loop can send on
  Time stuck_after{};
  int frames_lost_max = 0;  // in a row: so many stop the machine
  std::unique_ptr<cycle::Loop> loop;
  std::unique_ptr<Feed> feed;
  std::unique_ptr<cycle::LoopCpu> loop_cpu;       // in real time only
  std::optional<monitor::SnapshotWriter> shared;  // what `gantry publish` reads
  std::int64_t alarms_told_ns = 0;                // there
  std::unique_ptr<monitor::PublishChild> publisher;
  std::function<void()> poll;
  std::uint32_t referenced = 0;  // bit n: AxisId n, in the last snapshot
  using HeldNotes = stations::RepeatedNotes<FaultInWords>;
  HeldNotes notes;
  stations::ActiveFaults active;
  std::unique_ptr<OnBus> on_bus;
  bool hangs = false;  // the loop has not ended: what it uses must outlive this program

  /// Where the last job has found its board and parts; before the first one, the machine's own bodies.
  std::shared_ptr<const job::Surroundings> around;
  Undertaking undertaking = Undertaking::None;
  std::unique_ptr<RunningJob> job;
  std::string order_said;          ///< what the last hold or override leads to, in words; empty: at once
  std::optional<double> raise_to;  ///< override that waits for the valve to be shut
  bool button_holds = false;       ///< since the machine's hold button was pressed, until a resume
  std::optional<Error> ending;     ///< the program was asked to end: nothing is undertaken any more
  Aside aside_thread;

  [[nodiscard]] Control& control() const { return *on_bus->control; }

  /// What may wait for the world or a disk: on a thread of its own, while the machine is served and orders come in. In
  /// virtual time at once, in this thread. It must touch nothing that a step touches. An error when something has come
  /// meanwhile that ends what is under way; then a world that keeps silent is waited for no longer than kSilentWorld,
  /// and so is one whose bus is silent, too, after the end.
  Result<void> aside(const std::function<void()>& work);
  static constexpr Time kSilentWorld = milliseconds(1000);

  /// The bus and what stands behind it: the simulated machine in this process, or a wire. The port is its alone.
  Result<devices::FramePort*> open_bus();
  Result<void> go_on_bus();
  void make_on_bus(Time first);
  void note_restarts();
  [[nodiscard]] std::string only_assumed() const;

  /// Fault::Latched while a fault is. A reset that is under way is waited for: it decides that, and what the drives are
  /// asked for until it is over.
  [[nodiscard]] Result<void> not_latched();
  /// Every station holds what its rows ask for, and on a wire something tells that each drive stands in its place.
  /// Fault::ParameterDiffers, RestartNeeded, IdentityMismatch.
  [[nodiscard]] Result<void> stations_confirmed() const;
  /// Drives to Operation Enabled. Fault::Latched while a fault is; what stations_confirmed() says.
  Result<void> torque();
  Result<void> still_as_given();
  [[nodiscard]] bool all_referenced() const;
  /// What a job homes first (bit n: AxisId n). Where X, Y or Z is among it nothing says where the head is: all axes.
  [[nodiscard]] std::uint32_t unreferenced() const;
  /// Those axes (bit n: AxisId n), lowest order first.
  Result<void> home(std::uint32_t named = ~0u);
  /// `tell`: warns of what is not watched.
  Result<void> see_limits(std::uint32_t named, bool tell = false);
  /// Limits that nothing pins, as the stations hold them, beside what their axes need.
  [[nodiscard]] std::vector<config::HeldDoubt> held_limits() const;
  /// The axes as a job that begins now finds them; those that are homed before stand at their home edges then.
  [[nodiscard]] AxisVec where_a_job_begins() const;
  Result<Jogged> jog(const job::JogWords& words, job::JogFor whom);
  Result<void> park();
  Result<void> walk(const std::string& axis);
  [[nodiscard]] std::vector<Error> not_told_apart() const;

  /// An order that is answered at once.
  Result<void> at_once(const Order& order);
  /// `asked`: by which order, for a refusal.
  [[nodiscard]] Result<void> hold(bool now, OrderKind asked = OrderKind::Hold);
  [[nodiscard]] std::string travel_hold_words() const;
  [[nodiscard]] Result<void> resume();
  [[nodiscard]] Result<void> set_override(double factor);
  /// An override that was raised while the valve was open takes effect when it is shut.
  void raise_when_shut();
  [[nodiscard]] Result<void> reset();
  void abort(Error why);
  void heed_buttons();
  [[nodiscard]] bool in_setup() const;
  /// Opens the clamp: the part may be taken out.
  Result<void> release_part();
  [[nodiscard]] Standing standing() const;
  [[nodiscard]] Error refusal(OrderKind order) const;
  /// What the loop does not take of what is under way says only that it does not.
  [[nodiscard]] Result<void> in_words(Result<void> result) const;

  void on_snapshot(const cycle::Snapshot& s);
  void on_event(const cycle::Event& e);
  void tell(const cycle::Event& e, const Error& words);
  void tell_now(const HeldNotes::Told& told);
  /// What was held back, at once.
  void tell_all();
  /// Somebody has given an order that was taken, or pressed a button.
  void acted(const std::string& what);
  /// Of the job on a part: that it begins, what it came to.
  void tell_part(const std::string& what);
  void watch_references(const cycle::Snapshot& s);
  void watch_alarms(const cycle::Snapshot& s);
  void serve();
  void name_culprits();
  void fetch_mail();
  void serve_objects();
  void report_strays();
  void report_restarts();
  Result<void> command(const cycle::Command& order, double timeout_s) {
    return in_words(with_stations(control().command(order, timeout_s)));
  }
  /// Ends when the stations that an error of the bus is about are known, and names them.
  Result<void> with_stations(Result<void> result);
};

/// What an owner does at a time, from its beginning to its end: an abort holds as long as it lasts, and nothing of it
/// is left for the next one.
//   const Turn turn(parts, Undertaking::Home, begin);   if (!turn.taken()) return turn.refused();
class Owner::Turn {
 public:
  Turn(Parts& parts, Undertaking what, Begin begin = Begin::AtOnce);
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  [[nodiscard]] bool taken() const { return taken_; }
  [[nodiscard]] Result<void> refused() const;

 private:
  Parts& parts_;
  Undertaking what_;
  bool taken_;
};

}  // namespace gantry::run
