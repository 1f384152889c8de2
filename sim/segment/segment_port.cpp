#include "sim/segment/segment_port.hpp"

#include <algorithm>
#include <cstring>

#include "core/rt/trap.hpp"

namespace gantry::sim {
namespace {

// 80 ns a byte at 100 Mbit/s, with preamble, FCS and gap; then the line there and back.
constexpr std::size_t kOverheadBytes = 24, kShortest = 60;
constexpr Time kByte{80}, kMastersCable{1240};

}  // namespace

bool SegmentPort::send(devices::PortIndex port, std::span<const std::byte> frame) noexcept {
  const rt::Outside outside;
  if (port != devices::PortIndex::Primary || frame.size() > devices::kMaxFrameBytes) return false;
  if (!segment_.link_up()) segment_.advance();  // time passes for the stations, and their supply may return
  if (!segment_.link_up()) return false;
  std::memcpy(passing_.data(), frame.data(), frame.size());
  const std::span whole(passing_.data(), frame.size());
  if (!segment_.process(whole)) return true;  // sent, and lost
  Time arrives = clock_.now();
  if (clock_.is_virtual())  // a real clock passes by itself
    arrives += kByte * static_cast<int>(std::max(whole.size(), kShortest) + kOverheadBytes) + kMastersCable +
               segment_.round_trip();
  back_.put(whole, arrives, segment_.fate());
  return true;
}

devices::Received SegmentPort::receive(std::span<std::byte> buffer, Time deadline) noexcept {
  const rt::Outside outside;
  const Time arrives = back_.next();
  if (arrives == kNever || arrives > std::max(deadline, clock_.now())) {
    clock_.sleep_until(deadline);
    return {};
  }
  clock_.sleep_until(arrives);
  const auto frame = back_.front();
  const std::size_t size = std::min(frame.size(), buffer.size());
  std::memcpy(buffer.data(), frame.data(), size);
  back_.pop();
  return {size, devices::PortIndex::Primary, arrives};
}

bool SegmentPort::link_up(devices::PortIndex port) const noexcept {
  return port == devices::PortIndex::Primary && segment_.link_up();
}

}  // namespace gantry::sim
