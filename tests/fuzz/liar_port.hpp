// A station that says whatever a fuzz input says, behind FramePort: frames come back well formed, what they carry is
// the input's. The answer to each datagram is the business of the derived target; the NOPs that carry our sequence
// number pass untouched, as through any ring.
//   struct Liar : LiarPort { Answer answer(const DatagramHeader&, std::span<std::byte> data) override; };
// Time is virtual: a wait for a frame that does not come costs nothing.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "core/clock.hpp"
#include "devices/frame_port.hpp"
#include "devices/wire/ethercat.hpp"
#include "tests/fuzz/input.hpp"

namespace gantry::fuzz {

class LiarPort : public devices::FramePort {
 public:
  explicit LiarPort(VirtualClock& clock) : clock_(clock) {}

  enum class Answer { Takes, TakesNot, Lost };  ///< working counter 1 or 0, or the frame does not come back
  /// One datagram: `data` is what it carries and will carry back.
  virtual Answer answer(const devices::wire::DatagramHeader& asked, std::span<std::byte> data) = 0;

  bool send(devices::PortIndex, std::span<const std::byte> frame) noexcept override {
    using namespace devices::wire;
    note_said(frame);  // what the master does next is what it made of the answers
    waiting_ = false;
    auto& reply = reply_;
    reply.assign(frame.begin(), frame.end());
    reply[6] |= std::byte{kProcessedMacBit};
    for (std::size_t at = kFrameHeader;;) {
      const auto header = get_datagram_header(std::span(reply).subspan(at));
      const auto data = std::span(reply).subspan(at + kDatagramHeader, header.length);
      const std::size_t counter = at + kDatagramHeader + header.length;
      const Answer given = header.command == Command::Nop ? Answer::TakesNot : answer(header, data);
      if (given == Answer::Lost) return true;
      put_le<std::uint16_t>(reply, counter, given == Answer::Takes ? 1 : 0);
      if (!header.more) break;
      at = counter + kWorkingCounter;
    }
    waiting_ = true;
    return true;
  }
  devices::Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    if (!waiting_) {
      clock_.sleep_until(deadline);
      return {};
    }
    waiting_ = false;
    std::copy(reply_.begin(), reply_.end(), buffer.begin());
    return {reply_.size(), devices::PortIndex::Primary, clock_.now()};
  }
  [[nodiscard]] bool link_up(devices::PortIndex) const noexcept override { return true; }

 protected:
  VirtualClock& clock_;

 private:
  std::vector<std::byte> reply_;  ///< Link has one frame under way at a time
  bool waiting_ = false;
};

}  // namespace gantry::fuzz
