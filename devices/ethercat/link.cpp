#include "devices/ethercat/link.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <vector>

namespace gantry::devices {

using namespace wire;

bool Link::attempt(Command command, std::uint32_t address, std::span<std::byte> data, std::uint16_t& working_counter) {
  frame_.start(++sequence_);
  const SlotIndex slot = frame_.add(command, address, std::span<const std::byte>(data));
  // A second, idle datagram carries the second byte of the sequence: a reply of 256 frames ago is not taken.
  const SlotIndex idle = frame_.add(Command::Nop, 0, 2);
  if (slot == kNoSlot || idle == kNoSlot || !port_.send(PortIndex::Primary, frame_.bytes())) return false;
  const Time deadline = clock_.now() + kReplyTimeout;
  std::array<std::byte, kMaxFrameBytes> buffer;
  do {
    const Received got = port_.receive(buffer, deadline);
    if (got.size == 0) return false;
    Reply reply;
    if (match(frame_, std::span<const std::byte>(buffer).first(got.size), reply) != Match::Ours) continue;
    const auto answer = reply.data(slot);
    std::copy(answer.begin(), answer.end(), data.begin());
    working_counter = reply.working_counter(slot);
    return true;
  } while (clock_.now() < deadline);
  return false;
}

bool Link::attempt_riding(Command command, std::uint32_t address, std::span<std::byte> data,
                          std::uint16_t& working_counter) {
  const Time deadline = clock_.now() + kRideTimeout;
  while (!slot_->post(command, address, data)) {  // the one before was given up and is still under way
    std::uint16_t ignored = 0;
    std::array<std::byte, 1> nothing{};
    if (slot_->take(std::span(nothing).first(0), ignored) == AcyclicSlot::Taken::Pending && clock_.now() >= deadline)
      return false;
    pause(microseconds(200));
  }
  for (;;) {
    switch (slot_->take(data, working_counter)) {
      case AcyclicSlot::Taken::Answered: return true;
      case AcyclicSlot::Taken::Lost: return false;
      case AcyclicSlot::Taken::Pending: break;
    }
    if (clock_.now() >= deadline) {
      slot_->withdraw();
      return false;
    }
    pause(microseconds(200));
  }
}

Result<std::uint16_t> Link::transact(Command command, std::uint32_t address, std::span<std::byte> data, int attempts) {
  const std::vector<std::byte> request(data.begin(), data.end());
  for (int i = 0; i < attempts; ++i) {
    std::copy(request.begin(), request.end(), data.begin());
    std::uint16_t working_counter = 0;
    if (slot_ != nullptr ? attempt_riding(command, address, data, working_counter)
                         : attempt(command, address, data, working_counter))
      return working_counter;
  }
  if (slot_ != nullptr)
    return fail(Fault::BusDown, "the cyclic exchange did not carry a request; the loop stands or the bus is down");
  return fail(Fault::BusDown, port_.link_up(PortIndex::Primary)
                                  ? "no frame came back from the bus; check the first station's supply and cable"
                                  : "the link is down; check the cable to the first station");
}

Result<void> Link::read(std::uint16_t station, std::uint16_t reg, std::span<std::byte> data) {
  const auto wkc = transact(Command::Fprd, physical_address(station, reg), data);
  if (!wkc) return tl::unexpected(wkc.error());
  if (*wkc == kWkcRead) return {};
  return fail(Fault::StationMissing, fmt::format("the station does not answer (read of {:04X}h)", reg));
}

Result<void> Link::write(std::uint16_t station, std::uint16_t reg, std::span<const std::byte> data) {
  std::vector<std::byte> copy(data.begin(), data.end());
  const auto wkc = transact(Command::Fpwr, physical_address(station, reg), copy);
  if (!wkc) return tl::unexpected(wkc.error());
  if (*wkc == kWkcWrite) return {};
  return fail(Fault::StationMissing, fmt::format("the station does not answer (write of {:04X}h)", reg));
}

Result<std::uint16_t> Link::write_all(std::uint16_t reg, std::span<const std::byte> data) {
  std::vector<std::byte> copy(data.begin(), data.end());
  return transact(Command::Bwr, physical_address(0, reg), copy);
}

}  // namespace gantry::devices
