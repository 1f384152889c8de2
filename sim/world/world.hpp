// The world in which the simulated machine stands: it sees only what is physical (where the motors are, which outputs
// are on) and answers only with what is physical (the probe's contact, buttons, pictures, what lies on the board).
//   World world(machine, clock, seed, parse_placement("dx=1 mm"));
//   Senses s = world.step(cycle, now, {axes, outputs});   // at every SYNC0, on the bus thread; about 1 us
// Everything else may be called from other threads. A pure function of seed, script and what step() is told.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/clock.hpp"
#include "sim/script/world_event.hpp"
#include "sim/world/board.hpp"
#include "sim/world/camera.hpp"
#include "sim/world/collisions.hpp"
#include "sim/world/deposits.hpp"
#include "sim/world/head.hpp"
#include "sim/world/priority_mutex.hpp"
#include "sim/world/valve.hpp"
#include "sim/world/world_access.hpp"
#include "sim/world/world_log.hpp"

namespace gantry::sim {

/// What is physically true at a sync.
struct Moment {
  AxisVec axes{};               ///< actual coordinates now; of a gantry axis the mean of its sides
  std::uint32_t outputs = 0;    ///< config::bit(Output), as they take effect at this instant
  bool clamp_commanded = true;  ///< the clamp's station is in OP: its output is the controller's will
};

/// What the world does back to the machine.
struct Senses {
  double probe_contact = 0;        ///< coordinate of the probe's axis at which the probe closes
  std::uint32_t inputs = 0;        ///< config::bit(Input)
  std::span<const BusAction> bus;  ///< script actions that the bus side must do now; valid until the next step
};

class World {
 public:
  World(const config::Machine& machine, Clock& clock, std::uint64_t seed, std::optional<PlacementText> placement);

  /// Remembers into, and from, a log (sim/world/world_log.hpp). Before the first step.
  void remember(std::unique_ptr<WorldLog> log);

  Senses step(std::uint64_t cycle, Time now, const Moment& moment);

  SimCamera& camera() { return camera_; }
  /// Puts a new board in. Later ones come by themselves: when the clamp has been open for `kChange`, as long as hands
  /// need, another one of the same plan lies in the machine before the clamp closes again.
  Result<void> load_board(BoardPlan plan);
  static constexpr Time kChange = milliseconds(200);
  [[nodiscard]] bool holds_board(const BoardPlan& plan);
  void begin_job();
  [[nodiscard]] std::vector<Deposit> deposits();
  [[nodiscard]] std::vector<Collision> collisions();
  [[nodiscard]] std::string placement();
  /// Judged against the board: at once when one is there, else when it comes. Fault::UnknownReference.
  Result<void> add_script(std::vector<ScriptEntry> entries);
  [[nodiscard]] std::vector<std::string> script_left(WorldAccess::Machine machine);
  /// As of the last step; nothing before the first.
  [[nodiscard]] std::optional<AxisVec> axes();
  [[nodiscard]] ScriptedInput scripted_input(unsigned input);
  /// Motor positions of the last life, when the log holds them.
  [[nodiscard]] std::optional<std::vector<double>> remembered_motors() const { return remembered_motors_; }
  void keep_motors(std::span<const double> positions);

 private:
  struct Waiting {
    ScriptEntry entry;
    std::optional<Time> due{};  ///< its trigger has come
    bool told = false;          ///< that a job has ended without it
  };

  void run_valve(Time from, Time to, const AxisVec& a, const AxisVec& b, std::uint64_t cycle);
  void run_collisions(const AxisVec& from, const AxisVec& to, double dt_s, std::uint64_t cycle);
  void run_camera(const Moment& moment, double dt_s, Time now);
  void run_script(std::uint64_t cycle, Time now);
  void opened(Vec3 at_board, Time at, std::uint64_t cycle);
  void closed(Vec3 at_board, Time at, std::uint64_t cycle);
  void fire(Trigger::Kind kind, std::uint64_t count, std::string_view name, Time now);
  void do_action(const ScriptEntry& entry, Time now);
  void happen(const act::AddObstacle& a, Time now);
  void happen(const act::RemoveObstacle& a, Time now);
  void happen(const act::Press& a, Time now);
  void happen(const act::SetInput& a, Time now);
  void happen(const act::BreakWire& a, Time now);
  void happen(const act::SetCamera& a, Time now);
  void happen(const act::RemoveMark& a, Time now);
  void happen(const act::MoveMark& a, Time now);
  void happen(const act::Stain& a, Time now);
  void change_board(const std::function<void(BoardTruth&)>& change);
  void put_board(BoardPlan plan, Vec3 frame_origin);
  void exchange_board();
  void run_clamp(const Moment& moment, Time now);
  void place_solids();
  [[nodiscard]] Result<void> script_fits(std::span<const ScriptEntry> entries, const BoardPlan& plan) const;
  [[nodiscard]] Vec3 needle_on_board(const AxisVec& q) const;
  [[nodiscard]] double probe_contact(const AxisVec& q);
  [[nodiscard]] std::uint32_t inputs(std::uint32_t outputs, Time now) const;
  void keep_board();
  void keep_clamp(WorldLog::Kind what);
  void keep_collision(const Collision& collision);
  void recall_board(std::string_view text);

  const config::Machine& machine_;
  const std::uint64_t seed_;
  const std::optional<PlacementText> placement_text_;
  Head head_;
  SimCamera camera_;
  std::unique_ptr<WorldLog> log_;
  std::optional<std::vector<double>> remembered_motors_;

  PriorityMutex mutex_;  ///< all below; held for microseconds
  CollisionWatch watch_;
  Valve valve_;
  std::shared_ptr<const BoardTruth> board_;
  BoardPlan whole_;  ///< the plan of board_ before scripts changed anything on it
  std::uint64_t boards_ = 0;
  bool clamped_ = false;                 ///< the clamp has closed over board_
  std::optional<Time> opened_clamp_;     ///< since when it is open again
  std::vector<config::Body> obstacles_;  ///< of scripts

  bool stepped_ = false;
  Time last_{};
  Moment before_;
  Vec3 contact_key_;  ///< tip's x, y and reach that contact_ belongs to
  double contact_ = 0;
  bool contact_known_ = false;
  bool touching_ = false;

  std::shared_ptr<Shot> open_;
  std::vector<std::shared_ptr<const Shot>> shots_;
  std::uint64_t valve_shots_ = 0;
  std::vector<Collision> collisions_;
  std::size_t job_shot_ = 0, job_collision_ = 0;
  std::uint64_t job_dots_ = 0, job_beads_ = 0, job_touches_ = 0;
  Time job_began_{};

  std::vector<Waiting> script_;
  std::vector<BusAction> bus_actions_;
  bool emergency_ = false;
  std::uint32_t steady_inputs_ = 0, broken_wires_ = 0;
  std::uint32_t inverted_inputs_ = 0;  ///< whose contact reads 0 where the input is on
  std::array<Time, config::kChannelBits> pressed_until_{};
  std::array<std::string, config::kChannelBits> changed_by_{};  ///< the entry that changed an input last
};

}  // namespace gantry::sim
