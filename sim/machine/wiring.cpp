#include "sim/machine/wiring.hpp"

#include <algorithm>
#include <array>

#include "sim/machine/bus_actions.hpp"

namespace gantry::sim {

namespace {
constexpr std::uint64_t kKeepEvery = 64;  ///< cycles between two records of where the motors are
}

Wiring::Wiring(const config::Machine& machine, Segment& segment, World& world)
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

void Wiring::recall(const std::vector<double>& values) {
  if (values.size() != kept_.size()) return;  // another machine file: its motors start anew
  for (std::size_t i = 0; i < drives_.size(); ++i)
    segment_.restore(drives_[i].axis, drives_[i].drive, {values[2 * i], values[2 * i + 1]});
  kept_ = values;
}

void Wiring::keep() {
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

void Wiring::on_sync(std::uint64_t cycle, Time now) noexcept {
  Moment moment;
  std::array<int, kMaxAxes> sides{};
  for (const Drive& d : drives_) {
    moment.axes[d.axis.value] += segment_.motor(d.axis, d.drive).position();
    ++sides[d.axis.value];
  }
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if (sides[i] > 1) moment.axes[i] /= sides[i];
  moment.outputs = outputs();
  moment.clamp_commanded = clamp_commanded();

  const Senses senses = world_.step(cycle, now, moment);
  for (const Drive& d : drives_)
    if (d.axis == machine_.probe.axis) segment_.motor(d.axis, d.drive).set_contact(senses.probe_contact);
  set_inputs(senses.inputs);
  due_.insert(due_.end(), senses.bus.begin(), senses.bus.end());
  if (cycle % kKeepEvery == 0) keep();
}

void Wiring::do_due() {
  for (const BusAction& action : due_) do_action(action, segment_, machine_);
  due_.clear();
}

std::vector<Wiring::InputStation>::iterator Wiring::find(StationId station) {
  return std::find_if(input_stations_.begin(), input_stations_.end(),
                      [&](const InputStation& s) { return s.station == station; });
}

std::uint32_t Wiring::outputs() const {
  std::uint32_t out = 0;
  for (const auto& [bit, name, channel] : output_bits_) {
    const bool level = (segment_.io_outputs(channel.station) >> channel.bit & 1) != 0;
    if (level != channel.invert) out |= 1u << bit;
  }
  return out;
}

bool Wiring::clamp_commanded() const {
  const auto& clamp = machine_.outputs[static_cast<std::size_t>(config::Output::Clamp)];
  return clamp && segment_.in_operation(clamp->station);
}

void Wiring::set_inputs(std::uint32_t inputs) {
  for (InputStation& s : input_stations_) s.bits = 0;
  for (const auto& [bit, name, channel] : input_bits_) {
    const bool level = ((inputs >> bit & 1) != 0) != channel.invert;
    if (level) find(channel.station)->bits |= static_cast<std::uint16_t>(1u << channel.bit);
  }
  for (const InputStation& s : input_stations_) segment_.set_io_inputs(s.station, s.bits);
}

}  // namespace gantry::sim
