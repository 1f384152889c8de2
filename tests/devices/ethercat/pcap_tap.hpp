// A FramePort that writes every frame, both ways, to a pcap file for tshark to judge, and passes it on.
#pragma once
#include <cstdint>
#include <fstream>
#include <string>

#include "devices/passing_port.hpp"

namespace gantry::devices {

class PcapTap final : public PassingPort {
 public:
  PcapTap(FramePort& port, Clock& clock, const std::string& file)
      : PassingPort(port), clock_(clock), out_(file, std::ios::binary | std::ios::trunc) {
    // libpcap file header: nanosecond magic, version 2.4, snap length, link type 1 (Ethernet)
    for (const std::uint32_t word : {0xA1B23C4Du, 0x00040002u, 0u, 0u, 65535u, 1u}) put(word);
  }
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    record(frame);
    return port_.send(port, frame);
  }
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    const Received got = port_.receive(buffer, deadline);
    if (got.size > 0) record(buffer.first(got.size));
    return got;
  }
  void flush() { out_.flush(); }
  [[nodiscard]] std::size_t frames() const noexcept { return frames_; }

 private:
  void put(std::uint32_t word) { out_.write(reinterpret_cast<const char*>(&word), sizeof word); }
  void record(std::span<const std::byte> frame) {
    const std::int64_t now = clock_.now().count();
    put(static_cast<std::uint32_t>(now / 1'000'000'000));
    put(static_cast<std::uint32_t>(now % 1'000'000'000));
    put(static_cast<std::uint32_t>(frame.size()));
    put(static_cast<std::uint32_t>(frame.size()));
    out_.write(reinterpret_cast<const char*>(frame.data()), static_cast<std::streamsize>(frame.size()));
    ++frames_;
  }

  Clock& clock_;
  std::ofstream out_;
  std::size_t frames_ = 0;
};

}  // namespace gantry::devices
