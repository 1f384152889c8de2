// A short virtual line for the targets on the sim's side: one drive with a mailbox and one terminal, and frames of one
// datagram put together byte by byte.
//   SegmentBench line;   line.fprd(0x0130, 2);   line.round(frame);
#pragma once
#include <array>
#include <cstdlib>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "sim/segment.hpp"

namespace gantry::fuzz {

inline const config::Machine& short_line() {
  static const config::Machine machine = [] {
    config::Machine m;
    for (const char* file : {"drives/id286.yaml", "devices/dio16.yaml"}) {
      auto profile = config::load_profile(std::string(GANTRY_SOURCE_DIR "/config/") + file);
      if (!profile) std::abort();
      config::Station s;
      s.id = StationId{static_cast<std::uint16_t>(m.stations.size())};
      s.position = static_cast<int>(m.stations.size());
      s.profile = std::move(*profile);
      s.name = s.profile.name;
      m.stations.push_back(std::move(s));
    }
    return m;
  }();
  return machine;
}

class SegmentBench {
 public:
  VirtualClock clock;
  sim::Segment segment{short_line(), clock};

  /// Any bytes after the Ethernet header.
  bool round(std::span<const std::byte> payload) {
    std::vector<std::byte> frame(14 + payload.size());  // a heap block of the exact size
    frame[12] = std::byte{0x88}, frame[13] = std::byte{0xA4};
    std::copy(payload.begin(), payload.end(), frame.begin() + 14);
    clock.sleep_until(clock.now() + microseconds(100));
    const bool back = segment.process(frame);
    answer.assign(frame.begin(), frame.end());
    return back;
  }
  void datagram(unsigned command, unsigned adp, unsigned ado, std::span<const std::byte> data) {
    std::vector<std::byte> p(2 + 10 + data.size() + 2);
    const auto put = [&](std::size_t at, unsigned v) { p[at] = static_cast<std::byte>(v); };
    const auto length = static_cast<unsigned>(data.size());
    const unsigned header = (12 + length) | 0x1000;
    put(0, header & 0xFF), put(1, header >> 8), put(2, command);
    put(4, adp & 0xFF), put(5, adp >> 8), put(6, ado & 0xFF), put(7, ado >> 8), put(8, length & 0xFF),
        put(9, length >> 8);
    std::copy(data.begin(), data.end(), p.begin() + 12);
    round(p);
  }
  /// Writes by position.
  void write(unsigned position, unsigned ado, std::span<const std::byte> data) {
    datagram(2, static_cast<std::uint16_t>(-static_cast<int>(position)), ado, data);
  }
  template <class... B>
  void poke(unsigned position, unsigned ado, B... bytes) {
    const std::array<std::byte, sizeof...(B)> data{static_cast<std::byte>(bytes)...};
    write(position, ado, data);
  }
  /// The drive's mailbox as its profile has it, and PRE_OP.
  void mailbox_up() {
    poke(0, 0x0800, 0x00, 0x10, 0x80, 0x00, 0x26, 0, 1, 0, 0x80, 0x10, 0x80, 0x00, 0x22, 0, 1, 0);
    poke(0, 0x0120, 2, 0);
    settle();
  }
  /// A transition may take its time.
  void settle() {
    for (int i = 0; i < 20; ++i) {
      clock.sleep_until(clock.now() + milliseconds(1));
      segment.advance();
    }
  }

  std::vector<std::byte> answer;
};

}  // namespace gantry::fuzz
