#include "sim/machine/simulated_machine.hpp"

#include <fmt/format.h>

#include "core/new_file.hpp"
#include "sim/machine/scripted_port.hpp"
#include "sim/machine/wiring.hpp"
#include "sim/script/script.hpp"
#include "sim/segment/can_segment.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"
#include "sim/world/script_on_board.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim {

struct SimulatedMachine::Parts {
  Parts(const config::Machine& m, Clock& clock, std::uint64_t seed, std::optional<PlacementText> placement)
      : machine(m),
        segment(m, clock),
        port(segment, clock),
        can(m, clock),
        world(m, clock, seed, placement),
        wiring(m, segment, world),
        bus(port, wiring) {}

  const config::Machine& machine;
  Segment segment;
  SegmentPort port;
  CanSegment can;
  World world;
  Wiring wiring;
  ScriptedPort bus;
};

SimulatedMachine::SimulatedMachine(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
SimulatedMachine::~SimulatedMachine() { parts_->wiring.keep(); }

Result<void> check(const SimulatedMachineOptions& options) {
  if (options.state_dir.empty()) return {};
  const auto usable = try_folder(options.state_dir);
  if (usable) return {};
  return fail(Fault::Usage, fmt::format("{}: {}", usable.error().where, usable.error().message), "--sim-state");
}

Checked<void> check_script(const SimulatedMachineOptions& options, const config::Machine& machine) {
  if (options.script_file.empty()) return {};
  if (const auto read = load_script(options.script_file, machine); !read) return tl::unexpected(read.error());
  return {};
}

Checked<void> check_script(const SimulatedMachineOptions& options, const config::Machine& machine,
                           const recipes::Recipe& recipe) {
  if (options.script_file.empty()) return {};
  const auto read = load_script(options.script_file, machine);
  if (!read) return tl::unexpected(read.error());
  auto misfits = misfits_of(*read, board_plan(recipe), {});
  if (!misfits.empty()) return tl::unexpected(std::move(misfits));
  return {};
}

Result<std::unique_ptr<SimulatedMachine>> SimulatedMachine::open(const config::Machine& machine, Clock& clock,
                                                                 const SimulatedMachineOptions& options) {
  if (auto fits = check(options); !fits) return tl::unexpected(fits.error());
  std::optional<PlacementText> placement;
  if (!options.placement.empty()) {
    const auto parsed = parse_placement(options.placement);
    if (!parsed) return tl::unexpected(parsed.error());
    placement = *parsed;
  }
  std::vector<ScriptEntry> script;
  if (!options.script_file.empty()) {
    auto loaded = load_script(options.script_file, machine);
    if (!loaded) return tl::unexpected(joined(loaded.error()));
    script = std::move(*loaded);
  }
  auto parts = std::make_unique<Parts>(machine, clock, options.seed, placement);
  for (const auto& [station, habits] : options.habits) parts->segment.set_habits(station, habits);
  if (!options.state_dir.empty()) {
    auto log = WorldLog::open(options.state_dir);
    if (!log) return tl::unexpected(log.error());
    parts->world.remember(std::move(*log));
    if (const auto motors = parts->world.remembered_motors()) parts->wiring.recall(*motors);
  }
  if (auto added = parts->world.add_script(std::move(script)); !added) return tl::unexpected(added.error());
  parts->segment.set_world(&parts->wiring);
  return std::unique_ptr<SimulatedMachine>(new SimulatedMachine(std::move(parts)));
}

devices::FramePort& SimulatedMachine::bus() { return parts_->bus; }
devices::CanPort& SimulatedMachine::can() { return parts_->can; }

bool SimulatedMachine::answer(std::span<std::byte> frame) {
  parts_->wiring.do_due();
  return parts_->segment.process(frame);
}
const FrameFate& SimulatedMachine::fate() const { return parts_->segment.fate(); }
void SimulatedMachine::pass_time() {
  parts_->wiring.do_due();
  parts_->segment.advance();
}

Time SimulatedMachine::next_tick() const { return parts_->segment.next_tick(); }

vision::Camera& SimulatedMachine::camera() { return parts_->world.camera(); }

Result<void> SimulatedMachine::load_board(const recipes::Recipe& recipe) { return load_board(board_plan(recipe)); }
Result<void> SimulatedMachine::load_board(BoardPlan plan) { return parts_->world.load_board(std::move(plan)); }
Result<bool> SimulatedMachine::holds_board(const recipes::Recipe& recipe) { return holds_board(board_plan(recipe)); }
Result<bool> SimulatedMachine::holds_board(const BoardPlan& plan) { return parts_->world.holds_board(plan); }
Result<void> SimulatedMachine::begin_job() {
  parts_->world.begin_job();
  return {};
}
Result<std::vector<Deposit>> SimulatedMachine::deposits() { return parts_->world.deposits(); }
Result<std::vector<Collision>> SimulatedMachine::collisions() { return parts_->world.collisions(); }
Result<void> SimulatedMachine::write_deposits(const std::string& path) {
  return write_csv(parts_->world.deposits(), path);
}
Result<std::vector<std::string>> SimulatedMachine::script_left(Machine machine) {
  return parts_->world.script_left(machine);
}
std::optional<AxisVec> SimulatedMachine::axes() { return parts_->world.axes(); }
ScriptedInput SimulatedMachine::scripted_input(unsigned input) { return parts_->world.scripted_input(input); }
Result<std::string> SimulatedMachine::placement() { return parts_->world.placement(); }

Result<void> SimulatedMachine::add_script(std::string_view yaml) {
  auto entries = parse_script(yaml, "script", parts_->machine);
  if (!entries) return tl::unexpected(joined(entries.error()));
  return parts_->world.add_script(std::move(*entries));
}

}  // namespace gantry::sim
