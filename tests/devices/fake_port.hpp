// A line of stations reduced to what a cyclic frame sees of it: every datagram is answered with set counters and data.
// Frames can be lost, delayed by cycles, or come twice.
#pragma once
#include <deque>
#include <functional>
#include <vector>

#include "devices/frame_port.hpp"
#include "devices/rt/frame.hpp"

namespace gantry::devices {

class FakePort final : public FramePort {
 public:
  std::uint16_t lrw_counter = 6, brd_counter = 2, al_states = 8;
  std::uint64_t dc_time = 0;
  std::vector<std::byte> inputs;  ///< of the LRW, behind the outputs
  std::size_t output_bytes = 0;
  std::vector<std::byte> seen_outputs;
  bool up = true, lose = false, twice = false, hold_back = false;
  int sent = 0;
  std::deque<std::vector<std::byte>> waiting, held;

  bool send(PortIndex, std::span<const std::byte> frame) noexcept override {
    ++sent;
    if (!up) return false;
    if (lose) return true;
    auto reply = answer(frame);
    if (hold_back) {
      held.push_back(std::move(reply));
      return true;
    }
    if (twice) waiting.push_back(reply);
    waiting.push_back(std::move(reply));
    return true;
  }
  Received receive(std::span<std::byte> buffer, Time) noexcept override {
    if (waiting.empty()) return {};
    const auto frame = waiting.front();
    waiting.pop_front();
    std::copy(frame.begin(), frame.end(), buffer.begin());
    return {frame.size(), PortIndex::Primary, Time{}};
  }
  [[nodiscard]] bool link_up(PortIndex) const noexcept override { return up; }
  void release() {
    for (auto& f : held) waiting.push_back(std::move(f));
    held.clear();
  }

 private:
  std::vector<std::byte> answer(std::span<const std::byte> frame) {
    using namespace wire;
    std::vector<std::byte> reply(frame.begin(), frame.end());
    reply[6] |= std::byte{kProcessedMacBit};
    for (std::size_t at = kFrameHeader;;) {
      const auto h = get_datagram_header(std::span(reply).subspan(at));
      const auto data = std::span(reply).subspan(at + kDatagramHeader, h.length);
      const std::size_t counter = at + kDatagramHeader + h.length;
      std::uint16_t wkc = 1;
      if (h.command == Command::Lrw) {
        wkc = lrw_counter;
        seen_outputs.assign(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(output_bytes));
        std::copy(inputs.begin(), inputs.end(), data.begin() + static_cast<std::ptrdiff_t>(output_bytes));
      } else if (h.command == Command::Brd) {
        wkc = brd_counter;
        put_le<std::uint16_t>(data, 0, al_states);
      } else if (h.command == Command::Frmw) {
        put_le<std::uint64_t>(data, 0, dc_time);
      } else if (h.command == Command::Fprd) {
        for (auto& b : data) b = std::byte{0x77};
      }
      put_le<std::uint16_t>(reply, counter, wkc);
      if (!h.more) return reply;
      at = counter + kWorkingCounter;
    }
  }
};

}  // namespace gantry::devices
