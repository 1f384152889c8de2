#include "sim/machine/virtual_machine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/rt/trap.hpp"
#include "devices/passing_port.hpp"
#include "sim/script/script.hpp"
#include "sim/segment/can_segment.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim {

namespace {

/// Between the segment's terminals and the world: motors and outputs there, contact and inputs back.
class Wiring final : public WorldHook {
 public:
  Wiring(const config::Machine& machine, Segment& segment, World& world)
      : machine_(machine),
        segment_(segment),
        world_(world),
        output_bits_(config::output_bits(machine)),
        input_bits_(config::input_bits(machine)) {
    for (const config::Axis& axis : machine.axes)
      for (std::size_t i = 0; i < axis.drives.size(); ++i)
        if (segment.has_motor(axis.id, static_cast<int>(i))) drives_.push_back({axis.id, static_cast<int>(i)});
    kept_.resize(2 * drives_.size());
    for (const config::WordBit& input : input_bits_)
      if (find(input.channel.station) == input_stations_.end()) input_stations_.push_back({input.channel.station, 0});
  }

  void recall(const std::vector<double>& values) {
    if (values.size() != kept_.size()) return;  // another machine file: its motors start anew
    for (std::size_t i = 0; i < drives_.size(); ++i)
      segment_.restore(drives_[i].axis, drives_[i].drive, {values[2 * i], values[2 * i + 1]});
    kept_ = values;
  }

  void on_sync(std::uint64_t cycle, Time now) noexcept override {
    Moment moment;
    std::array<int, kMaxAxes> sides{};
    for (const Drive& d : drives_) {
      moment.axes[d.axis.value] += segment_.motor(d.axis, d.drive).position();
      ++sides[d.axis.value];
    }
    for (std::size_t i = 0; i < kMaxAxes; ++i)
      if (sides[i] > 1) moment.axes[i] /= sides[i];
    moment.outputs = outputs();

    const Senses senses = world_.step(cycle, now, moment);
    for (const Drive& d : drives_)
      if (d.axis == machine_.probe.axis) segment_.motor(d.axis, d.drive).set_contact(senses.probe_contact);
    set_inputs(senses.inputs);
    due_.insert(due_.end(), senses.bus.begin(), senses.bus.end());
    if (cycle % kKeepEvery == 0) keep();
  }

  /// What scripts do to the bus, between frames: the segment is not touched while it calls the world.
  void do_due() {
    for (const Action& action : due_) act(action);
    due_.clear();
  }

  void keep() {
    std::vector<double> now;
    now.reserve(kept_.size());
    for (const Drive& d : drives_) {
      const DriveMemory m = segment_.memory(d.axis, d.drive);
      now.push_back(m.position);
      now.push_back(m.count_zero);
    }
    if (now == kept_) return;
    kept_ = std::move(now);
    world_.keep_motors(kept_);
  }

 private:
  struct Drive {
    AxisId axis;
    int drive;
  };
  struct InputStation {
    StationId station;
    std::uint16_t bits = 0;
  };
  static constexpr std::uint64_t kKeepEvery = 64;  ///< cycles between two records of where the motors are

  std::vector<InputStation>::iterator find(StationId station) {
    return std::find_if(input_stations_.begin(), input_stations_.end(),
                        [&](const InputStation& s) { return s.station == station; });
  }

  [[nodiscard]] std::uint32_t outputs() const {
    std::uint32_t out = 0;
    for (const auto& [bit, name, channel] : output_bits_) {
      const bool level = (segment_.io_outputs(channel.station) >> channel.bit & 1) != 0;
      if (level != channel.invert) out |= 1u << bit;
    }
    return out;
  }

  void set_inputs(std::uint32_t inputs) {
    for (InputStation& s : input_stations_) s.bits = 0;
    for (const auto& [bit, name, channel] : input_bits_) {
      const bool level = ((inputs >> bit & 1) != 0) != channel.invert;
      if (level) find(channel.station)->bits |= static_cast<std::uint16_t>(1u << channel.bit);
    }
    for (const InputStation& s : input_stations_) segment_.set_io_inputs(s.station, s.bits);
  }

  void act(const Action& a) {
    switch (a.kind) {
      case ActionKind::CutLink: segment_.cut_link(position(a.station)); break;
      case ActionKind::HealLink: segment_.heal_link(position(a.station)); break;
      case ActionKind::LoseFrames: segment_.lose_frames(static_cast<int>(a.count)); break;
      case ActionKind::CorruptFrames: segment_.faults().corrupt(static_cast<int>(a.count)); break;
      case ActionKind::CorruptHeaders: segment_.faults().corrupt_headers(static_cast<int>(a.count)); break;
      case ActionKind::DuplicateFrames: segment_.faults().duplicate(static_cast<int>(a.count)); break;
      case ActionKind::ReorderFrames: segment_.faults().reorder(static_cast<int>(a.count)); break;
      case ActionKind::DelayFrames: segment_.faults().delay(static_cast<int>(a.count), a.hold); break;
      case ActionKind::Noise: segment_.faults().set_noise(a.noise); break;
      case ActionKind::Drift: segment_.set_clock_drift(a.station, a.amount); break;
      case ActionKind::Jitter: segment_.set_clock_jitter(a.station, static_cast<std::uint32_t>(a.hold.count())); break;
      case ActionKind::CountErrors:
        segment_.count_errors(a.station, static_cast<int>(a.code), static_cast<int>(a.count));
        break;
      case ActionKind::StickStatusword:
      case ActionKind::FreeStatusword:
        segment_.stick_statusword(a.axis, static_cast<int>(a.count), a.kind == ActionKind::StickStatusword);
        break;
      case ActionKind::IgnoreWrites: segment_.ignore_writes(a.station, a.object); break;
      case ActionKind::HeedWrites: segment_.ignore_writes(a.station, std::nullopt); break;
      case ActionKind::SetObject: segment_.set_object(a.station, a.object, std::llround(a.amount)); break;
      case ActionKind::DriveFault: segment_.drive_fault(a.axis, static_cast<int>(a.count), a.code); break;
      case ActionKind::PowerOff: segment_.power_off(a.station); break;
      case ActionKind::PowerOn: segment_.power_on(a.station); break;
      case ActionKind::PowerCycle: segment_.power_cycle(a.station, a.hold); break;
      case ActionKind::Stall:
      case ActionKind::Release:
        for (const Drive& d : drives_)
          if (d.axis == a.axis) segment_.motor(d.axis, d.drive).set_stalled(a.kind == ActionKind::Stall);
        break;
      default: break;  // the world's own
    }
  }

  [[nodiscard]] int position(StationId station) const {
    const auto at = std::find_if(machine_.stations.begin(), machine_.stations.end(),
                                 [&](const config::Station& s) { return s.id == station; });
    return at == machine_.stations.end() ? 0 : at->position;
  }

  const config::Machine& machine_;
  Segment& segment_;
  World& world_;
  std::vector<Drive> drives_;
  std::vector<double> kept_;  ///< position and count zero of each drive
  std::vector<config::WordBit> output_bits_, input_bits_;
  std::vector<InputStation> input_stations_;
  std::vector<Action> due_;
};

/// The segment's port, with scripts between its frames.
class ScriptedPort final : public devices::PassingPort {
 public:
  ScriptedPort(SegmentPort& port, Wiring& wiring) : PassingPort(port), wiring_(wiring) {}
  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override {
    const rt::Outside world;  // scripts and the world are not held to the loop's rules
    wiring_.do_due();
    return port_.send(port, frame);
  }

 private:
  Wiring& wiring_;
};

}  // namespace

struct VirtualMachine::Parts {
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

VirtualMachine::VirtualMachine(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
VirtualMachine::~VirtualMachine() { parts_->wiring.keep(); }

Result<std::unique_ptr<VirtualMachine>> VirtualMachine::open(const config::Machine& machine, Clock& clock,
                                                             const VirtualMachineOptions& options) {
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
  if (!options.state_dir.empty()) {
    auto log = WorldLog::open(options.state_dir);
    if (!log) return tl::unexpected(log.error());
    parts->world.remember(std::move(*log));
    if (const auto motors = parts->world.remembered_motors()) parts->wiring.recall(*motors);
  }
  if (auto added = parts->world.add_script(std::move(script)); !added) return tl::unexpected(added.error());
  parts->segment.set_world(&parts->wiring);
  return std::unique_ptr<VirtualMachine>(new VirtualMachine(std::move(parts)));
}

devices::FramePort& VirtualMachine::bus() { return parts_->bus; }
devices::CanPort& VirtualMachine::can() { return parts_->can; }

bool VirtualMachine::answer(std::span<std::byte> frame) {
  parts_->wiring.do_due();
  return parts_->segment.process(frame);
}
const FrameFate& VirtualMachine::fate() const { return parts_->segment.fate(); }
void VirtualMachine::pass_time() {
  parts_->wiring.do_due();
  parts_->segment.advance();
}

Time VirtualMachine::next_tick() const { return parts_->segment.next_tick(); }

vision::Camera& VirtualMachine::camera() { return parts_->world.camera(); }

Result<void> VirtualMachine::load_board(const recipes::Recipe& recipe) { return load_board(board_plan(recipe)); }
Result<void> VirtualMachine::load_board(BoardPlan plan) { return parts_->world.load_board(std::move(plan)); }
Result<bool> VirtualMachine::holds_board(const recipes::Recipe& recipe) { return holds_board(board_plan(recipe)); }
Result<bool> VirtualMachine::holds_board(const BoardPlan& plan) { return parts_->world.holds_board(plan); }
Result<void> VirtualMachine::begin_job() {
  parts_->world.begin_job();
  return {};
}
Result<std::vector<Deposit>> VirtualMachine::deposits() { return parts_->world.deposits(); }
Result<std::vector<Collision>> VirtualMachine::collisions() { return parts_->world.collisions(); }
Result<void> VirtualMachine::write_deposits(const std::string& path) {
  return write_csv(parts_->world.deposits(), path);
}
Result<std::vector<std::string>> VirtualMachine::script_left() { return parts_->world.script_left(); }
Result<std::string> VirtualMachine::placement() { return parts_->world.placement(); }

Result<void> VirtualMachine::add_script(std::string_view yaml) {
  auto entries = parse_script(yaml, "script", parts_->machine);
  if (!entries) return tl::unexpected(joined(entries.error()));
  return parts_->world.add_script(std::move(*entries));
}

}  // namespace gantry::sim
