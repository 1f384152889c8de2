#include "app/run/compose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "app/job/limits.hpp"
#include "app/job/walk.hpp"
#include "config/homing_method.hpp"
#include "config/quick_stop.hpp"
#include "devices/profiles/homing_objects.hpp"
#include "devices/profiles/map_pdos.hpp"

namespace gantry::run {
namespace {

using cycle::LoopSetup;

// What a brake may give way, the play of its coupling with it (assumed).
constexpr double kBrakeGive_mm = 0.5, kBrakeGive_rad = 0.02;
// From where an axis stands behind its reference switch to the edge of that: a tenth of its travel within these bounds,
// more than a machine has between the switch and its stop (assumed; docs/commissioning.md). What a switch is closed for
// beyond its place, it may stand elsewhere unseen.
constexpr double kLeaveShare = 0.1;
constexpr double kLeaveLeast_mm = 5, kLeaveMost_mm = 20, kLeaveLeast_rad = 0.09, kLeaveMost_rad = 0.35;
constexpr double kLeaveSlower = 2, kLeaveStart_s = 1;  // than the slow speed, and what starting takes
// From the edge on, besides braking: what the drive takes to see it, and to come to rest (assumed).
constexpr double kComesToRest_s = 0.02;
// From that edge until 60FDh shows it (assumed: its input filter); a drive that sets its counter hides two cycles'
// travel.
constexpr double kShowsSwitch_s = 0.05, kCyclesHidden = 2, kSlackCounts = 20;
constexpr double kHeedsBit_s = 0.02;  // a drive that homes looks at its controlword when it likes
constexpr double kDelaysToBrake = 3, kLateToBrake_s = 0.01;  // a filter, and frames that are lost, before a ramp begins
constexpr double kFlickers_s = 0.003;                        // a contact that bounces
constexpr double kHomingTravel = 1.2;  // of the axis' travel between the switches: more than any search needs

const config::Station* station_of(const config::Machine& machine, StationId id) {
  for (const config::Station& s : machine.stations)
    if (s.id == id) return &s;
  return nullptr;
}

/// The home switch stands beyond the end of the travel that the search goes to, and its cam farther out.
bool is_cam_outside(const config::Axis& axis) {
  const int toward = config::homing_method(axis.homing->method).toward * (axis.drives.front().invert ? -1 : 1);
  const double at = axis.homing->position;
  return (toward < 0 && at < axis.p_min) || (toward > 0 && at > axis.p_max);
}

/// What homing of an axis may meet, by the switches that its drives show.
devices::HomingRules rules_of(const config::Machine& machine, const config::Axis& axis) {
  devices::HomingRules rules = devices::homing_rules(axis.homing->method);
  rules.known = devices::kSwitchNeg | devices::kSwitchPos | devices::kSwitchHome;
  for (const config::DriveRef& ref : axis.drives) {
    const config::Station* station = station_of(machine, ref.station);
    if (station == nullptr || !station->profile.drive) continue;
    const config::DriveFacts& facts = *station->profile.drive;
    if (facts.input_neg_limit < 0) rules.known &= static_cast<std::uint8_t>(~devices::kSwitchNeg);
    if (facts.input_pos_limit < 0) rules.known &= static_cast<std::uint8_t>(~devices::kSwitchPos);
    if (facts.input_home < 0) rules.known &= static_cast<std::uint8_t>(~devices::kSwitchHome);
  }
  rules.unseen_accepted = axis.homing->limits_unseen;
  rules.flickers_cycles = std::max(rules.flickers_cycles, static_cast<int>(cycles_in(kFlickers_s, machine.bus.cycle)));
  rules.counts_per_cycle =
      std::max(axis.homing->fast, axis.homing->slow) * std::abs(axis.counts_per_unit) * seconds(machine.bus.cycle);
  const double leave =
      std::clamp(kLeaveShare * (axis.p_max - axis.p_min), axis.rotary ? kLeaveLeast_rad : kLeaveLeast_mm,
                 axis.rotary ? kLeaveMost_rad : kLeaveMost_mm);
  if (is_cam_outside(axis)) rules.leaves |= devices::kSwitchHome;
  rules.leave_counts = std::llround(leave * std::abs(axis.counts_per_unit));
  rules.leave_cycles = cycles_in(kLeaveStart_s + kLeaveSlower * leave / axis.homing->slow, machine.bus.cycle);
  return rules;
}

Result<void> add_drives(const config::Machine& machine, const config::Axis& axis, cycle::AxisSetup& setup,
                        LoopSetup& loop) {
  for (const config::DriveRef& ref : axis.drives) {
    const config::Station* station = station_of(machine, ref.station);
    if (station == nullptr || !station->cyclic()) continue;
    auto layout = devices::map_drive(station->profile, ref.slot);
    if (!layout) return tl::unexpected(layout.error());
    const auto index = static_cast<std::uint8_t>(loop.drives.size());
    const bool brakes = config::quick_stop_of(station->profile, ref.slot) == config::QuickStop::Brakes;
    const double ramp = config::quick_stop_ramp(machine, axis, ref).value_or(axis.a_max);
    const cycle::BrakingReach reach{
        .deceleration = std::min(ramp, axis.a_max),
        .late_s = axis.a_max / axis.j_max + kDelaysToBrake * axis.response_delay_s + kLateToBrake_s,
        .slack = axis.following_base + kSlackCounts / std::abs(axis.counts_per_unit),
        .gains = axis.a_max * axis.a_max / (2 * axis.j_max) + axis.a_max * axis.response_delay_s};
    cycle::BrakingReach homing_reach = reach;
    if (axis.homing) homing_reach.deceleration = std::min(axis.homing->acceleration, axis.a_max);
    homing_reach.late_s += kHeedsBit_s;
    const double give = axis.rotary ? kBrakeGive_rad : kBrakeGive_mm;
    const bool braked = config::is_braked(machine, axis, ref);
    if (!loop.drives.push_back({ref.station, axis.id, *layout, devices::AxisScale(axis.counts_per_unit, ref.invert),
                                brakes, braked && layout->closed_loop ? give : 0,
                                layout->closed_loop || axis.self_locking || braked, reach, homing_reach,
                                config::in_slot(station->profile, {0x609A, 0}, ref.slot),
                                config::in_slot(station->profile, {0x60FD, 0}, ref.slot),
                                config::in_slot(station->profile, {0x6061, 0}, ref.slot)}) ||
        !setup.drives.push_back(index))
      return fail(Fault::Inconsistent, fmt::format("axis {}: too many drives", axis.name), machine.file);
  }
  return {};
}

void add_bits(const std::vector<config::WordBit>& bits, rt::FixedVector<cycle::ImageBit, config::kChannelBits>& at) {
  for (const auto& [bit, name, c] : bits)
    at.push_back({static_cast<std::uint8_t>(bit), c.station, static_cast<std::uint16_t>(c.bit / 8),
                  static_cast<std::uint8_t>(1u << (c.bit % 8)), c.invert});
}

std::uint32_t mask_of(const config::Machine& machine, config::Input input) {
  return machine.inputs[static_cast<std::size_t>(input)] ? config::bit(input) : 0;
}

std::uint32_t mask_of(const config::Machine& machine, config::Output output) {
  return machine.outputs[static_cast<std::size_t>(output)] ? config::bit(output) : 0;
}

}  // namespace

Result<void> compose_startup(config::Machine& machine) {
  for (const config::Axis& axis : machine.axes) {
    if (!axis.homing) continue;
    for (const config::DriveRef& ref : axis.drives)
      for (config::Station& station : machine.stations) {
        if (station.id != ref.station || !station.cyclic()) continue;
        auto rows = devices::homing_objects(station.profile, ref.slot, axis);
        if (!rows) return tl::unexpected(rows.error());
        station.profile.startup.insert(station.profile.startup.end(), rows->begin(), rows->end());
      }
  }
  return {};
}

Result<LoopSetup> compose_loop(const config::Machine& machine, Host host) {
  LoopSetup loop;
  loop.period = machine.bus.cycle;
  loop.late_window = cycles_in(seconds(cycle::kLateWindow), loop.period);
  loop.limits = job::limits_of(machine);
  for (const config::Axis& axis : machine.axes) {
    cycle::AxisSetup setup;
    setup.following_base = axis.following_base;
    setup.following_per_speed_s = axis.following_per_speed_s;
    setup.skew_max = axis.skew_max;
    setup.response_delay_s = axis.response_delay_s;
    loop.walk_max[axis.id.value] = std::abs(job::walk_by(machine, axis));
    if (axis.homing) {
      setup.homing.position = axis.homing->position;
      setup.homing.limits.cycle = loop.period;
      setup.homing.limits.timeout_cycles = cycles_in(axis.homing->timeout_s, loop.period);
      const double travel = kHomingTravel * (axis.p_max - axis.p_min) + std::abs(axis.homing->position);
      setup.homing.limits.travel_counts = std::llround(travel * axis.counts_per_unit);
      setup.homing.limits.rules = rules_of(machine, axis);
      const double braking = axis.homing->fast * axis.homing->fast / (2 * axis.homing->acceleration);
      setup.homing.limits.near_counts =
          std::llround((braking + kComesToRest_s * axis.homing->fast) * std::abs(axis.counts_per_unit));
      const double edge = kShowsSwitch_s * axis.homing->slow + kCyclesHidden * seconds(loop.period) * axis.homing->fast;
      setup.homing.limits.edge_counts = std::llround(edge * std::abs(axis.counts_per_unit) + kSlackCounts);
      setup.homing.square_max = axis.homing->square_max;
      setup.homing.square_speed = axis.homing->slow;
      // A side that comes to its switch late runs past it, as the other one has, and back; each of them sees its switch
      // up to a cycle late.
      setup.homing.skew_max = axis.homing->rack_max + braking + 2 * axis.homing->fast * seconds(loop.period);
    }
    if (auto added = add_drives(machine, axis, setup, loop); !added) return tl::unexpected(added.error());
    setup.quick_stop_brakes = config::quick_stop_of(machine, axis) == config::QuickStop::Brakes;
    setup.streamed = axis.kind == config::AxisKind::Streamed && !setup.drives.empty();
    if (!loop.axes.push_back(setup))
      return fail(Fault::Inconsistent, "more axes than the loop holds (16)", machine.file);
  }
  add_bits(config::output_bits(machine), loop.outputs);
  add_bits(config::input_bits(machine), loop.inputs);
  loop.probe_axis = machine.probe.axis;
  loop.valve_mask = config::bit(config::Output::Valve);
  loop.held_mask = mask_of(machine, config::Output::Clamp);
  loop.healthy_mask = mask_of(machine, config::Output::Healthy);
  for (const auto& [lamp, output] : {std::pair{cycle::Lamp::Red, config::Output::StackRed},
                                     std::pair{cycle::Lamp::Yellow, config::Output::StackYellow},
                                     std::pair{cycle::Lamp::Green, config::Output::StackGreen}})
    loop.lamp_masks[static_cast<std::size_t>(lamp)] = mask_of(machine, output);
  if (machine.brake) {
    loop.brake_mask = 1u << machine.brake->bit;
    loop.brake_axis = machine.brake->axis;
    const auto time = [](double s) { return std::chrono::duration_cast<Time>(std::chrono::duration<double>(s)); };
    loop.brake_time = time(machine.brake->time_s);
    loop.brake_release = time(machine.brake->release_s);
  }
  loop.door_mask = mask_of(machine, config::Input::DoorClosed);
  loop.air_mask = mask_of(machine, config::Input::AirOk);
  loop.clamp_mask = mask_of(machine, config::Input::ClampClosed);
  loop.stop_mask = mask_of(machine, config::Input::Stop);
  loop.safety_mask = mask_of(machine, config::Input::SafetyOk);
  loop.mode_mask = mask_of(machine, config::Input::Mode);
  loop.counter_low_max = machine.bus.frames_lost_max;
  // Only a virtual bus in this process, under the wall clock, stands still with its loop when the host stalls: there
  // alone neither is a sign of anything.
  const bool patient = host == Host::WallClock;
  loop.stop_after_missed =
      host == Host::Hardware ? machine.bus.stop_after_missed_hardware : machine.bus.stop_after_missed_sim;
  loop.late_max = std::max(cycle::kLateMax, loop.stop_after_missed);  // a host that may stand still is late as often
  loop.frames_lost_max =
      patient ? std::max(machine.bus.frames_lost_max, machine.bus.stop_after_missed_sim) : machine.bus.frames_lost_max;
  return loop;
}

}  // namespace gantry::run
