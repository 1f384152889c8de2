#include "sim/segment_port.hpp"

#include <algorithm>
#include <cstring>

#include "core/rt/trap.hpp"

namespace gantry::sim {
namespace {

// 80 ns a byte at 100 Mbit/s, with preamble, FCS and gap; then the line there and back.
constexpr std::size_t kOverheadBytes = 24, kShortest = 60;
constexpr Time kByte{80}, kStationThereAndBack{1240};

}  // namespace

bool SegmentPort::send(devices::PortIndex port, std::span<const std::byte> frame) noexcept {
  const rt::Outside outside;
  if (port != devices::PortIndex::Primary || frame.size() > devices::kMaxFrameBytes || count_ == kFrames ||
      !segment_.link_up())
    return false;
  InFlight& f = queue_[(head_ + count_) % kFrames];
  std::memcpy(f.bytes.data(), frame.data(), frame.size());
  f.size = frame.size();
  if (!segment_.process({f.bytes.data(), f.size})) return true;  // sent, and lost
  f.arrives = clock_.now();
  if (clock_.is_virtual())  // a real clock passes by itself
    f.arrives += kByte * static_cast<int>(std::max(f.size, kShortest) + kOverheadBytes) +
                 kStationThereAndBack * segment_.station_count();
  ++count_;
  return true;
}

devices::Received SegmentPort::receive(std::span<std::byte> buffer, Time deadline) noexcept {
  const rt::Outside outside;
  if (count_ == 0 || queue_[head_].arrives > std::max(deadline, clock_.now())) {
    clock_.sleep_until(deadline);
    return {};
  }
  const InFlight& f = queue_[head_];
  clock_.sleep_until(f.arrives);
  const std::size_t size = std::min(f.size, buffer.size());
  std::memcpy(buffer.data(), f.bytes.data(), size);
  const devices::Received received{size, devices::PortIndex::Primary, f.arrives};
  head_ = (head_ + 1) % kFrames;
  --count_;
  return received;
}

bool SegmentPort::link_up(devices::PortIndex port) const noexcept {
  return port == devices::PortIndex::Primary && segment_.link_up();
}

}  // namespace gantry::sim
