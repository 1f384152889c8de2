#include "devices/ethercat/link.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "devices/ethercat/side_by_side.hpp"

namespace gantry::devices {

using namespace wire;

namespace {

constexpr std::size_t kIdleBytes = 4;
constexpr Time kRidePause = microseconds(200);

}  // namespace

void Link::pause(Time duration) {
  const Time until = clock_.now() + duration;
  if (beside_ != nullptr) return beside_->pause_until(until);
  if (slot_ == nullptr || !step_) return clock_.sleep_until(until);
  do step_();
  while (clock_.now() < until);
}

Result<void> Link::goes_on() const {
  if (!ends_ || !ends_()) return {};
  return fail(Fault::Interrupted, "interrupted while the bus was brought up");
}

std::size_t Link::fitting(std::span<const Datagram> batch) const {
  const std::size_t most = slot_ != nullptr ? AcyclicSlot::kMost : kMaxDatagrams - 1;
  std::size_t bytes = kFrameHeader + kDatagramHeader + kIdleBytes + kWorkingCounter, n = 0;
  for (; n < std::min(batch.size(), most); ++n) {
    bytes += kDatagramHeader + batch[n].data.size() + kWorkingCounter;
    if (bytes > kMaxFrameBytes) break;
  }
  return std::max<std::size_t>(n, 1);
}

bool Link::attempt(std::span<Datagram> of_one_frame) {
  frame_.start(++sequence_);
  std::array<SlotIndex, kMaxDatagrams> slots{};
  for (std::size_t i = 0; i < of_one_frame.size(); ++i) {
    const Datagram& d = of_one_frame[i];
    slots[i] = frame_.add(d.command, d.address, std::span<const std::byte>(d.data));
    if (slots[i] == kNoSlot) return false;
  }
  // Beside the largest mailbox there is no room for this one.
  frame_.add_sequence();
  answered_[sequence_ % answered_.size()] = false;
  const bool sent = port_.send(PortIndex::Primary, frame_.bytes());
  ++(sent ? counts_.sent : counts_.not_sent);
  ++counts_.lost;  // until it is back
  if (!sent) return false;
  const Time deadline = clock_.now() + kReplyTimeout;
  std::array<std::byte, kMaxFrameBytes> buffer;
  bool untouched = false;
  do {
    const Received got = port_.receive(buffer, deadline);
    if (got.size == 0) return false;
    Reply reply;
    const auto received = std::span<const std::byte>(buffer).first(got.size);
    if (const Match as = match(frame_, received, reply); as != Match::Ours) {
      count(as, received);
      if (as == Match::Unprocessed && !std::exchange(untouched, true)) --counts_.lost;
      continue;
    }
    answered_[sequence_ % answered_.size()] = true;
    if (!untouched) --counts_.lost;
    for (std::size_t i = 0; i < of_one_frame.size(); ++i) {
      const auto answer = reply.data(slots[i]);
      std::copy(answer.begin(), answer.end(), of_one_frame[i].data.begin());
      of_one_frame[i].working_counter = reply.working_counter(slots[i]);
    }
    return true;
  } while (clock_.now() < deadline);
  return false;
}

/// What came in and is no answer.
void Link::count(Match match, std::span<const std::byte> received) {
  switch (match) {
    case Match::Unprocessed: ++counts_.untouched; break;
    case Match::Malformed: ++counts_.malformed; break;
    case Match::Late:
      ++(answered_[get_datagram_header(received.subspan(kFrameHeader)).index] ? counts_.duplicate : counts_.late);
      break;
    case Match::Foreign:
      ++counts_.foreign;
      if (const auto sender = sender_of(received)) senders_.heard(*sender, sequence_);
      break;
    case Match::Ours: break;
  }
}

bool Link::attempt_riding(std::span<Datagram> at_once) {
  const Time deadline = clock_.now() + kRideTimeout;
  while (!slot_->post(at_once)) {  // an earlier request was given up, and its answer is still to come
    if (slot_->take({}) == AcyclicSlot::Taken::Pending && clock_.now() >= deadline) return false;
    pause(kRidePause);
  }
  for (;;) {
    switch (slot_->take(at_once)) {
      case AcyclicSlot::Taken::Answered: return true;
      case AcyclicSlot::Taken::Lost: return false;
      case AcyclicSlot::Taken::Pending: break;
    }
    if (clock_.now() >= deadline) {
      slot_->withdraw();
      return false;
    }
    pause(kRidePause);
  }
}

bool Link::attempt_now(std::span<Datagram> at_once) {
  return slot_ != nullptr ? attempt_riding(at_once) : attempt(at_once);
}

/// As often as it takes, at most so many times; each attempt sends the same.
bool Link::exchange(std::span<Datagram> at_once, int attempts) {
  if (beside_ != nullptr) return beside_->exchange(at_once, attempts);
  std::vector<std::vector<std::byte>> as_sent;
  for (const Datagram& d : at_once) as_sent.emplace_back(d.data.begin(), d.data.end());
  // What rides is lost with the loop's frames, several in a row when a host stands still.
  const bool rides = slot_ != nullptr && attempts > 1;
  const Time until = clock_.now() + kReplyTimeout;
  for (int i = 0; i < attempts || (rides && clock_.now() < until); ++i) {
    if (attempt_now(at_once)) return true;
    for (std::size_t k = 0; k < at_once.size(); ++k)
      std::copy(as_sent[k].begin(), as_sent[k].end(), at_once[k].data.begin());
  }
  return false;
}

Result<std::uint16_t> Link::transact(Command command, std::uint32_t address, std::span<std::byte> data, int attempts) {
  Datagram one{command, address, data};
  if (exchange(std::span(&one, 1), attempts)) return one.working_counter;
  return tl::unexpected(silent());
}

Result<void> Link::transact(std::span<Datagram> batch) {
  for (std::span<Datagram> left = batch; !left.empty();) {
    const auto now = left.first(fitting(left));
    if (!exchange(now, kAttempts)) return tl::unexpected(silent());
    left = left.subspan(now.size());
  }
  return {};
}

Error Link::silent() const {
  if (slot_ != nullptr)
    return {Fault::BusDown, "the cyclic exchange did not carry a request; the loop stands or the bus is down", {}};
  return {Fault::BusDown,
          port_.link_up(PortIndex::Primary)
              ? "no frame came back from the bus; check the first station's supply and cable"
              : "the link is down; check the cable to the first station",
          {}};
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
