// The whole simulated machine: bus segment with its stations and drives, the plant they move, and the world it stands
// in. Nothing above the two ports and the camera can tell it from a real one.
//   auto simulated = sim::SimulatedMachine::open(machine, clock, {.seed = 7, .placement = "dx=1.3 mm, rot=0.8 deg"});
//   master over simulated->bus(), loop over simulated->can(), vision over simulated->camera()
// The bus side runs on the thread that sends frames; everything of WorldAccess may be called from any other thread.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/can_port.hpp"
#include "devices/frame_port.hpp"
#include "sim/station/habits.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::sim {

struct BoardPlan;
struct FrameFate;

struct SimulatedMachineOptions {
  std::uint64_t seed = 1;
  std::string placement;    ///< --sim-board; empty: the seed places the board
  std::string script_file;  ///< --sim-script; empty: none
  std::string state_dir;    ///< --sim-state; empty: the world is new and forgets
  /// The machine as it is really wired, where that is another than its file tells; null: as the file tells.
  std::shared_ptr<const config::Machine> wired{};
  std::vector<std::pair<StationId, StationHabits>> habits{};
};

/// Asked before long work, and by SimulatedMachine::open(). Fault::Usage: a state folder in which no file can be made.
Result<void> check(const SimulatedMachineOptions& options);
/// The script, read for nothing but its mistakes: Fault 4xx with file:line:col.
Checked<void> check_script(const SimulatedMachineOptions& options, const config::Machine& machine);
/// The same on the board of a recipe: Fault::UnknownReference where it names what that board lacks.
Checked<void> check_script(const SimulatedMachineOptions& options, const config::Machine& machine,
                           const recipes::Recipe& recipe);

class SimulatedMachine final : public WorldAccess {
 public:
  /// `machine` and `clock` must outlive it. Fault 4xx with file:line:col for a bad placement or script, FileUnreadable,
  /// FileUnwritable for the state.
  static Result<std::unique_ptr<SimulatedMachine>> open(const config::Machine& machine, Clock& clock,
                                                        const SimulatedMachineOptions& options);
  ~SimulatedMachine() override;

  devices::FramePort& bus();
  devices::CanPort& can();
  // For a host that answers frames itself (`gantry sim --interface`) instead of bus().
  /// The frame becomes in place what comes back; false: nothing does.
  bool answer(std::span<std::byte> frame);
  /// What is to happen to that answer on its way back.
  [[nodiscard]] const FrameFate& fate() const;
  /// No frame came: time passes for the stations all the same.
  void pass_time();
  /// When it should be called next, so that the frame which comes then finds the stations' cycle done.
  [[nodiscard]] Time next_tick() const;

  vision::Camera& camera() override;
  Result<void> load_board(const recipes::Recipe& recipe) override;
  /// The same for a board that came over the socket.
  Result<void> load_board(BoardPlan plan);
  Result<bool> holds_board(const recipes::Recipe& recipe) override;
  Result<bool> holds_board(const BoardPlan& plan);
  Result<void> begin_job() override;
  Result<std::vector<Deposit>> deposits() override;
  Result<std::vector<Collision>> collisions() override;
  Result<void> write_deposits(const std::string& path) override;
  Result<std::string> placement() override;
  Result<void> add_script(std::string_view yaml) override;
  Result<std::vector<std::string>> script_left(Machine machine) override;
  std::optional<AxisVec> axes() override;
  ScriptedInput scripted_input(unsigned input) override;

 private:
  struct Parts;
  explicit SimulatedMachine(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace gantry::sim
