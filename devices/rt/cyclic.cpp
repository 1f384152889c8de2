#include "devices/rt/cyclic.hpp"

#include <algorithm>

namespace gantry::devices {
namespace {

using namespace wire;

constexpr int kFramesLookedAt = 64;  // in one cycle: old and foreign frames must not hold the loop

}  // namespace

void Cyclic::build(AcyclicSlot& acyclic) noexcept {
  frame_.start(++sequence_);
  lrw_ = frame_.add(Command::Lrw, layout_.logical_start, std::size_t{layout_.output_bytes} + layout_.input_bytes);
  if (lrw_ != kNoSlot) std::copy(outputs_.begin(), outputs_.end(), frame_.data(lrw_).begin());
  clock_ = layout_.reference_address != 0
               ? frame_.add(Command::Frmw, physical_address(layout_.reference_address, reg::kDcSystemTime), 8)
               : kNoSlot;
  states_ = frame_.add(Command::Brd, physical_address(0, reg::kAlStatus), 2);
  rider_ = acyclic.ride(frame_);
}

Exchange Cyclic::judge(const Reply& reply) noexcept {
  Exchange e;
  e.expected = layout_.working_counter;
  if (lrw_ != kNoSlot) e.working_counter = reply.working_counter(lrw_);
  const std::uint16_t seen = reply.working_counter(states_);
  e.al_states = get_le<std::uint16_t>(reply.data(states_), 0);
  if (clock_ != kNoSlot && reply.working_counter(clock_) != 0)
    e.dc_time_ns = get_le<std::uint64_t>(reply.data(clock_), 0);

  if (e.working_counter > e.expected || seen > layout_.stations) {
    e.fault = Fault::WorkingCounterHigh;
    ++counts_.working_counter_high;
  } else if (e.working_counter < e.expected || seen < layout_.stations) {
    e.fault = Fault::WorkingCounterLow;
    ++counts_.working_counter_low;
  }
  e.inputs_fresh = e.working_counter == e.expected;
  if (e.inputs_fresh && lrw_ != kNoSlot) {
    const auto data = reply.data(lrw_).subspan(layout_.output_bytes);
    std::copy(data.begin(), data.end(), inputs_.begin());
  }
  return e;
}

Exchange Cyclic::run(FramePort& port, AcyclicSlot& acyclic, Time deadline) noexcept {
  build(acyclic);
  Exchange lost;
  lost.expected = layout_.working_counter;
  lost.fault = Fault::FrameLost;
  const bool sent = port.send(PortIndex::Primary, frame_.bytes());
  ++(sent ? counts_.sent : counts_.not_sent);
  for (int looked = 0; sent && looked < kFramesLookedAt; ++looked) {
    const Received got = port.receive(received_, deadline);
    if (got.size == 0) break;
    Reply reply;
    switch (match(frame_, std::span<const std::byte>(received_).first(got.size), reply)) {
      case Match::Ours:
        if (rider_ != kNoSlot) acyclic.answer(reply, rider_);
        return judge(reply);
      case Match::Unprocessed: ++counts_.unprocessed; break;
      case Match::Late: ++counts_.late; break;
      case Match::Foreign: ++counts_.foreign; break;
      case Match::Malformed: ++counts_.malformed; break;
    }
  }
  if (rider_ != kNoSlot) acyclic.lose();
  ++counts_.lost;
  if (!port.link_up(PortIndex::Primary)) lost.fault = Fault::BusDown;
  return lost;
}

}  // namespace gantry::devices
