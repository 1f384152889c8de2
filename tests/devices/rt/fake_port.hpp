// A line of stations reduced to what a cyclic frame sees of it: every datagram is answered with set counters and data.
// Frames can be lost, delayed by cycles, or come twice.
#pragma once
#include <deque>
#include <functional>
#include <vector>

#include "devices/frame_port.hpp"
#include "devices/rt/cyclic.hpp"

namespace gantry::devices {

/// Stations as the LRW, LWR and LRD of a frame meet them: regions of the logical map, and nothing else of an ESC.
class FakePort final : public FramePort {
 public:
  std::vector<CyclicStation> stations;
  std::vector<bool> alive;  ///< by station; empty: all
  int counter_error = 0;    ///< added to the working counter of process data
  std::uint16_t brd_counter = 2, al_states = 8;
  std::uint64_t dc_time = 0;
  std::vector<std::byte> inputs;  ///< of all stations
  std::vector<std::byte> seen_outputs = std::vector<std::byte>(4096);
  bool up = true, lose = false, twice = false, hold_back = false;
  bool loop_back = false;                                ///< frames come back as they went out
  bool echo = false;                                     ///< the same, before the answer
  std::function<void(std::vector<std::byte>&)> changed;  ///< what happens to an answer on its way
  int sent = 0;
  std::deque<std::vector<std::byte>> waiting, held;

  bool send(PortIndex, std::span<const std::byte> frame) noexcept override {
    ++sent;
    if (!up) return false;
    if (lose) return true;
    if (loop_back || echo) waiting.emplace_back(frame.begin(), frame.end());
    if (loop_back) return true;
    auto reply = answer(frame);
    if (changed) changed(reply);
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
  /// Through the FMMUs of all stations; the working counter.
  int logical(wire::Command command, std::uint32_t address, std::span<std::byte> data) {
    int wkc = 0;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const CyclicStation& s = stations[i];
      if (s.logical < address || s.logical + s.region_bytes > address + data.size() || (!alive.empty() && !alive[i]))
        continue;
      const auto region = data.subspan(s.logical - address, s.region_bytes);
      if (command != wire::Command::Lrd && s.output_bytes > 0) {
        std::copy_n(region.begin() + s.output_at, s.output_bytes, seen_outputs.begin() + s.output_offset);
        wkc += command == wire::Command::Lrw ? 2 : 1;
      }
      if (command != wire::Command::Lwr && s.input_bytes > 0) {
        std::copy_n(inputs.begin() + s.input_offset, s.input_bytes, region.begin() + s.input_at);
        ++wkc;
      }
    }
    return wkc + counter_error;
  }

  std::vector<std::byte> answer(std::span<const std::byte> frame) {
    using namespace wire;
    std::vector<std::byte> reply(frame.begin(), frame.end());
    reply[6] |= std::byte{kProcessedMacBit};
    for (std::size_t at = kFrameHeader;;) {
      if (at + kDatagramHeader + kWorkingCounter > reply.size()) return reply;
      const auto h = get_datagram_header(std::span(reply).subspan(at));
      if (at + kDatagramHeader + h.length + kWorkingCounter > reply.size()) return reply;  // a changed length
      const auto data = std::span(reply).subspan(at + kDatagramHeader, h.length);
      const std::size_t counter = at + kDatagramHeader + h.length;
      int wkc = 1;
      switch (h.command) {
        case Command::Nop: wkc = 0; break;
        case Command::Lrw:
        case Command::Lwr:
        case Command::Lrd: wkc = logical(h.command, h.address, data); break;
        case Command::Brd:
          wkc = brd_counter;
          for (std::size_t i = 0; i < data.size(); ++i)
            data[i] = static_cast<std::byte>(i < 2 ? al_states >> (8 * i) : 0);
          break;
        case Command::Frmw:
          for (std::size_t i = 0; i < data.size(); ++i)
            data[i] = static_cast<std::byte>(i < 8 ? dc_time >> (8 * i) : 0);
          break;
        default: std::fill(data.begin(), data.end(), std::byte{0x77}); break;
      }
      put_le<std::uint16_t>(reply, counter, static_cast<std::uint16_t>(wkc));
      if (!h.more) return reply;
      at = counter + kWorkingCounter;
    }
  }
};

}  // namespace gantry::devices
