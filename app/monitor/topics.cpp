#include "app/monitor/topics.hpp"

#include <cmath>
#include <cstring>
#include <string_view>

#include "config/machine.hpp"

namespace gantry::monitor {
namespace {

template <std::size_t N>
void put(char (&out)[N], std::string_view text) {
  const Text<N> bounded(text);
  std::memcpy(out, bounded.chars, N);
}

const char* kind_name(const SharedEvent& e) {
  if (e.told == Told::Action) return "action";
  if (e.told == Told::Part) return "part";
  switch (e.event.kind) {
    case cycle::EventKind::CommandDone: return "command_done";
    case cycle::EventKind::BlockDone: return "block_done";
    case cycle::EventKind::Touched: return "touched";
    case cycle::EventKind::Fault: return "fault";
    case cycle::EventKind::StateChange: return "state";
  }
  return "?";
}

const char* severity_name(Severity severity) {
  switch (severity) {
    case Severity::Info: return "info";
    case Severity::Warning: return "warning";
    case Severity::Error: return "error";
    case Severity::Fatal: return "fatal";
  }
  return "?";
}

/// Names of the set bits.
std::uint32_t names_of(std::uint32_t bits, const std::array<Text<32>, 32>& names,
                       std::array<gantry_msg_Name, 32>& out) {
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < names.size(); ++i)
    if ((bits >> i & 1u) != 0 && !names[i].view().empty()) put(out[n++], names[i].view());
  return n;
}

std::string_view axis_name(const MachineInfo& info, AxisId axis) {
  return axis.value < info.axes ? info.axis[axis.value].name.view() : std::string_view();
}

}  // namespace

void StateSample::set(const MachineInfo& info, std::uint64_t session, const SharedSnapshot& shared) {
  const cycle::Snapshot& s = shared.snapshot;
  put(sample.machine, info.name.view());
  sample.session = session;
  sample.time_ns = shared.wall_ns;
  sample.cycle = s.cycle;
  put(sample.state, cycle::name(s.state));
  sample.block = s.block;
  sample.tick = s.tick;
  sample.feature = s.feature == motion::kTravel ? -1 : static_cast<std::int32_t>(s.feature);
  sample.override_factor = s.override_factor;
  sample.path_speed = s.path_speed;
  for (std::uint32_t i = 0; i < info.axes; ++i) {
    auto& a = axes_[i];
    put(a.name, info.axis[i].name.view());
    a.rotary = info.axis[i].rotary;
    a.target = s.target[i];
    a.actual = s.actual[i];
    a.following_known = std::isfinite(s.following[i]);
    a.following = a.following_known ? s.following[i] : 0;
    a.enabled = (s.enabled >> i & 1u) != 0;
    a.referenced = (s.referenced >> i & 1u) != 0;
  }
  sample.axes = {._maximum = info.axes, ._length = info.axes, ._buffer = axes_.data(), ._release = false};
  sample.outputs = s.outputs;
  sample.inputs = s.inputs;
  const auto outputs = names_of(s.outputs, info.output, outputs_);
  const auto inputs = names_of(s.inputs, info.input, inputs_);
  sample.outputs_on = {._maximum = outputs, ._length = outputs, ._buffer = outputs_.data(), ._release = false};
  sample.inputs_on = {._maximum = inputs, ._length = inputs, ._buffer = inputs_.data(), ._release = false};
  sample.latched_fault = static_cast<std::uint16_t>(s.latched);
  put(sample.latched_text, s.latched == Fault::None ? std::string_view() : gantry::info(s.latched).text);
}

void JointSample::set(const MachineInfo& info, const SharedSnapshot& shared) {
  constexpr double kMetresPerMm = 1e-3;
  for (std::uint32_t i = 0; i < info.axes; ++i) {
    name_text_[i] = info.axis[i].name.view();
    names_[i] = name_text_[i].data();
    positions_[i] = shared.snapshot.actual[i] * (info.axis[i].rotary ? 1.0 : kMetresPerMm);
  }
  sample.header.stamp.sec = static_cast<std::int32_t>(shared.wall_ns / 1'000'000'000);
  sample.header.stamp.nanosec = static_cast<std::uint32_t>(shared.wall_ns % 1'000'000'000);
  sample.header.frame_id = frame_.data();
  sample.name = {._maximum = info.axes, ._length = info.axes, ._buffer = names_.data(), ._release = false};
  sample.position = {._maximum = info.axes, ._length = info.axes, ._buffer = positions_.data(), ._release = false};
}

gantry_msg_Event event_sample(const MachineInfo& info, std::uint64_t session, std::uint64_t number,
                              const SharedEvent& shared) {
  const cycle::Event& e = shared.event;
  const FaultInfo& fault = gantry::info(e.fault);
  gantry_msg_Event sample{};
  put(sample.machine, info.name.view());
  sample.session = session;
  sample.seq = number;
  sample.time_ns = shared.wall_ns;
  sample.cycle = e.cycle;
  put(sample.kind, kind_name(shared));
  sample.fault = static_cast<std::uint16_t>(e.fault);
  if (e.fault != Fault::None) {
    put(sample.code, code(e.fault));
    put(sample.fault_name, fault.name);
    put(sample.remedy, fault.remedy);
  }
  put(sample.severity, severity_name(e.fault == Fault::None ? Severity::Info : fault.severity));
  put(sample.axis, axis_name(info, e.axis));
  sample.detail = e.detail;
  sample.value = std::isfinite(e.value) ? e.value : 0;
  sample.block = e.block;
  sample.count = shared.count;
  std::string_view text = shared.text.view();
  if (text.empty() && e.fault != Fault::None) text = fault.text;
  if (text.empty() && e.kind == cycle::EventKind::StateChange) text = cycle::name(static_cast<cycle::State>(e.detail));
  put(sample.text, text);
  return sample;
}

gantry_msg_Alarm alarm_sample(const MachineInfo& info, std::uint64_t session, const SharedAlarm& shared) {
  const FaultInfo& fault = gantry::info(shared.fault);
  gantry_msg_Alarm sample{};
  put(sample.machine, info.name.view());
  put(sample.code, code(shared.fault));
  sample.session = session;
  sample.since_ns = shared.since_ns;
  sample.active = true;
  sample.fault = static_cast<std::uint16_t>(shared.fault);
  put(sample.fault_name, fault.name);
  put(sample.severity, severity_name(fault.severity));
  put(sample.where, shared.where.view());
  put(sample.text, shared.text.view());
  put(sample.remedy, fault.remedy);
  return sample;
}

gantry_msg_JobStatus job_sample(const MachineInfo& info, std::uint64_t session, std::int64_t time_ns,
                                const SharedJob& shared) {
  gantry_msg_JobStatus sample{};
  put(sample.machine, info.name.view());
  sample.session = session;
  sample.time_ns = time_ns;
  put(sample.job, shared.job.view());
  put(sample.recipe, shared.recipe.view());
  put(sample.state, shared.state.view());
  sample.blocks_done = shared.blocks_done;
  sample.blocks_total = shared.blocks_total;
  sample.features_done = shared.features_done;
  sample.features_total = shared.features_total;
  sample.elapsed_s = shared.elapsed_s;
  sample.predicted_s = shared.predicted_s;
  sample.remaining_known = shared.remaining_s >= 0;
  sample.remaining_s = sample.remaining_known ? shared.remaining_s : 0;
  put(sample.message, shared.message.view());
  return sample;
}

}  // namespace gantry::monitor
