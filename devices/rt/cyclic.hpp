// The cyclic exchange: one frame with LRW over the logical map, FRMW 0910h (the reference clock's time goes to all the
// others) and BRD 0130h (AL states of all stations OR-ed), and whatever rides along in the AcyclicSlot.
//   Cyclic cyclic(layout, outputs, inputs);
//   const Exchange e = cyclic.run(port, deadline);
// The inputs change only when the frame came back and its working counter was the expected one. Several frames a cycle
// (a map of more than 1400 bytes) and LRD/LWR will live here too.
// Lives in the RT loop.
#pragma once
#include <cstdint>
#include <span>

#include "devices/bus.hpp"
#include "devices/frame_port.hpp"
#include "devices/rt/acyclic.hpp"
#include "devices/rt/frame.hpp"

namespace gantry::devices {

struct CyclicLayout {
  std::uint32_t logical_start = 0;
  std::uint16_t output_bytes = 0, input_bytes = 0;  ///< outputs first in the logical map
  std::uint16_t working_counter = 0;                ///< expected of the LRW
  std::uint16_t stations = 0;                       ///< expected of the BRD
  std::uint16_t reference_address = 0;              ///< station address of the reference clock; 0: none
  /// Data bytes that one LRW can carry beside the other datagrams of the frame.
  static constexpr std::size_t kMaxBytes = 1400;
};

/// What happened since the start.
struct CyclicCounts {
  std::uint64_t sent = 0, lost = 0, late = 0, foreign = 0, malformed = 0, unprocessed = 0, working_counter_low = 0,
                working_counter_high = 0, not_sent = 0;
};

class Cyclic {
 public:
  Cyclic() = default;
  Cyclic(const CyclicLayout& layout, std::span<const std::byte> outputs, std::span<std::byte> inputs) noexcept
      : layout_(layout), outputs_(outputs), inputs_(inputs) {}

  Exchange run(FramePort& port, AcyclicSlot& acyclic, Time deadline) noexcept;

  [[nodiscard]] const CyclicCounts& counts() const noexcept { return counts_; }

 private:
  void build(AcyclicSlot& acyclic) noexcept;
  [[nodiscard]] Exchange judge(const Reply& reply) noexcept;

  CyclicLayout layout_;
  std::span<const std::byte> outputs_;
  std::span<std::byte> inputs_;
  std::uint32_t sequence_ = 0;
  Frame frame_;
  SlotIndex lrw_ = kNoSlot, clock_ = kNoSlot, states_ = kNoSlot, rider_ = kNoSlot;
  std::array<std::byte, kMaxFrameBytes> received_{};
  CyclicCounts counts_;
};

}  // namespace gantry::devices
