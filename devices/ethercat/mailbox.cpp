#include "devices/ethercat/mailbox.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::devices {
namespace {

using namespace wire;
using config::SyncManagerKind;

constexpr Time kPoll = microseconds(200);
constexpr std::uint16_t kStatusByte = 5, kActivateByte = 6, kPdiControlByte = 7;

std::uint16_t sm_register(int number, std::uint16_t byte) {
  return static_cast<std::uint16_t>(reg::kSyncManager0 + kSyncManagerBytes * static_cast<std::size_t>(number) + byte);
}

}  // namespace

std::size_t Mailbox::capacity() const {
  const auto* sm = find_sync_manager(station_, SyncManagerKind::MailboxOut, nullptr);
  return sm == nullptr || sm->length < kMailboxHeader ? 0 : sm->length - kMailboxHeader;
}

Result<bool> Mailbox::full(SyncManagerKind kind) {
  int number = 0;
  find_sync_manager(station_, kind, &number);
  const auto status = link_.read<std::uint8_t>(station_.address, sm_register(number, kStatusByte));
  if (!status) return tl::unexpected(status.error());
  return (*status & kSmStatusMailboxFull) != 0;
}

Result<void> Mailbox::send(MailboxType type, std::span<const std::byte> body) {
  const auto* sm = find_sync_manager(station_, SyncManagerKind::MailboxOut, nullptr);
  if (sm == nullptr || body.size() > capacity())
    return fail(Fault::MailboxProtocol,
                fmt::format("a request of {} bytes does not fit the station's mailbox of {}", body.size(), capacity()),
                station_.where);
  MailboxState& state = station_.mailbox;
  const bool counted = state.count != MailboxState::Count::Foreign;
  if (counted) state.request_counter = next_counter(state.request_counter);
  if (!counted) state.count = MailboxState::Count::Tried;
  // The whole mailbox is written: its last byte is what hands it over.
  request_.assign(sm->length, std::byte{0});
  put_mailbox_header(request_, {.length = static_cast<std::uint16_t>(body.size()),
                                .type = type,
                                .counter = counted ? state.request_counter : std::uint8_t{0}});
  std::copy(body.begin(), body.end(), request_.begin() + kMailboxHeader);
  return hand_over();
}

Result<void> Mailbox::hand_over() {
  const auto* sm = find_sync_manager(station_, SyncManagerKind::MailboxOut, nullptr);
  const Time deadline = link_.clock().now() + kSendTimeout;
  for (;;) {
    // A lost reply is repeated with the same counter: the station drops what it has already.
    std::vector<std::byte> data = request_;
    const auto wkc = link_.transact(Command::Fpwr, physical_address(station_.address, sm->start), data);
    if (!wkc) return tl::unexpected(wkc.error());
    if (*wkc == kWkcWrite) return {};
    if (link_.clock().now() >= deadline)
      return fail(Fault::MailboxTimeout, "the station does not take a request from its mailbox", station_.where);
    link_.pause(kPoll);
  }
}

/// False: the station does not know the repeat request.
Result<bool> Mailbox::ask_repeat(int number) {
  if (!station_.mailbox.repeats) return false;
  auto& toggle = station_.mailbox.repeat_toggle;
  toggle = !toggle;
  station_.mailbox.repeated = true;
  ++station_.mailbox_repeats;
  const auto activate = static_cast<std::uint8_t>(kSmActivateEnable | (toggle ? kSmActivateRepeatRequest : 0));
  if (auto ok = link_.write<std::uint8_t>(station_.address, sm_register(number, kActivateByte), activate); !ok)
    return tl::unexpected(ok.error());
  const Time deadline = link_.clock().now() + kSendTimeout;
  for (;;) {
    const auto pdi = link_.read<std::uint8_t>(station_.address, sm_register(number, kPdiControlByte));
    if (!pdi) return tl::unexpected(pdi.error());
    if (((*pdi & kSmPdiRepeatAck) != 0) == toggle) return true;
    if (link_.clock().now() >= deadline) return station_.mailbox.repeats = false;
    link_.pause(kPoll);
  }
}

/// Reads the full mailbox. When no answer comes, either the request was lost and the mailbox is full as before, or the
/// reply was, and has emptied it. Asking the station to repeat is right in both cases: it gives the message that was
/// read last and then the one that waits, and a copy is known by its counter. From a full mailbox alone one could not
/// distinguish the lost message from the next one. A station that does not repeat is read again as long as its mailbox
/// is full.
Result<std::vector<std::byte>> Mailbox::fetch() {
  int number = 0;
  const auto* sm = find_sync_manager(station_, SyncManagerKind::MailboxIn, &number);
  std::vector<std::byte> reply(sm->length);
  for (int attempt = 0; attempt < Link::kAttempts; ++attempt) {
    const auto wkc = link_.transact(Command::Fprd, physical_address(station_.address, sm->start), reply, 1);
    if (wkc && *wkc == kWkcRead) return reply;
    if (wkc) return std::vector<std::byte>{};  // empty after all
    const auto repeats = ask_repeat(number);
    if (!repeats) return tl::unexpected(repeats.error());
    if (*repeats) continue;
    const auto still = full(SyncManagerKind::MailboxIn);
    if (!still) return tl::unexpected(still.error());
    if (!*still) return fail(Fault::MailboxTimeout, "the station does not repeat a lost reply", station_.where);
  }
  return fail(Fault::BusDown, "the station's reply is lost again and again", station_.where);
}

Result<std::vector<std::byte>> Mailbox::receive(MailboxType type) {
  constexpr int kMostResent = 2;  // one that knows no counter 0, and then meets the counter it saw last
  Time deadline = link_.clock().now() + kReplyTimeout;
  for (;;) {
    if (auto ok = link_.goes_on(); !ok) return tl::unexpected(ok.error());
    const auto waiting = full(SyncManagerKind::MailboxIn);
    if (!waiting) return tl::unexpected(waiting.error());
    if (*waiting) {
      auto reply = fetch();
      if (!reply) return reply;
      if (reply->size() >= kMailboxHeader) {
        const MailboxHeader h = get_mailbox_header(*reply);
        if (kMailboxHeader + h.length > reply->size())
          return fail(
              Fault::MailboxProtocol,
              fmt::format("a reply says {} bytes, the mailbox has {}", h.length, reply->size() - kMailboxHeader),
              station_.where);
        // Only after a repeat can a reply come twice; some stations count nothing, or always the same.
        MailboxState& state = station_.mailbox;
        const bool repeated = state.repeated && h.counter != 0 && h.counter == state.last_reply_counter;
        if (!repeated) state.repeated = false;
        state.last_reply_counter = h.counter;
        const auto body = std::span<const std::byte>(*reply).subspan(kMailboxHeader, h.length);
        const bool taken = repeated || keep_emergency(h, body);
        if (!taken && h.type == type && state.count == MailboxState::Count::Tried && state.request_counter != 0)
          state.count = MailboxState::Count::Ours;
        if (!taken && h.type == type) return std::vector<std::byte>(body.begin(), body.end());
        if (!taken && h.type == MailboxType::Error)
          return fail(Fault::MailboxProtocol,
                      fmt::format("the station answers with a mailbox error, detail {}",
                                  h.length >= 4 ? get_le<std::uint16_t>(*reply, kMailboxHeader + 2) : 0),
                      station_.where);
      }
    }
    const bool late = link_.clock().now() >= deadline;
    if (late && station_.mailbox.count != MailboxState::Count::Ours && !request_.empty() && resent_ < kMostResent) {
      ++resent_;
      ++station_.mailbox_repeats;
      MailboxHeader again = get_mailbox_header(request_);
      again.counter = station_.mailbox.request_counter = next_counter(station_.mailbox.request_counter);
      put_mailbox_header(request_, again);
      if (auto ok = hand_over(); !ok) return tl::unexpected(ok.error());
      deadline = link_.clock().now() + kReplyTimeout;
    } else if (late)
      return fail(Fault::MailboxTimeout, fmt::format("no reply within {} ms", kReplyTimeout / milliseconds(1)),
                  station_.where);
    if (!*waiting) link_.pause(kPoll);
  }
}

bool Mailbox::keep_emergency(const MailboxHeader& header, std::span<const std::byte> body) {
  if (header.type != MailboxType::Coe || body.size() < kCoeHeader + kEmergencyBytes ||
      coe_service(get_le<std::uint16_t>(body, 0)) != CoeService::Emergency)
    return false;
  const auto raw = body.subspan(kCoeHeader);
  Emergency e{get_le<std::uint16_t>(raw, 0), get_le<std::uint8_t>(raw, 2), {}};
  for (std::size_t i = 0; i < e.data.size(); ++i) e.data[i] = get_le<std::uint8_t>(raw, 3 + i);
  auto& kept = station_.mailbox.emergencies;
  if (kept.size() < MailboxState::kMostEmergencies) kept.push_back(e);
  return true;
}

Result<void> Mailbox::drain() {
  for (int i = 0; i < 16; ++i) {
    const auto waiting = full(SyncManagerKind::MailboxIn);
    if (!waiting) return tl::unexpected(waiting.error());
    if (!*waiting) {
      station_.mailbox.clean = true;
      return {};
    }
    const auto old = fetch();
    if (!old) return tl::unexpected(old.error());
    if (old->size() < kMailboxHeader) continue;
    const MailboxHeader h = get_mailbox_header(*old);
    station_.mailbox.last_reply_counter = h.counter;
    if (kMailboxHeader + h.length <= old->size())
      keep_emergency(h, std::span<const std::byte>(*old).subspan(kMailboxHeader, h.length));
  }
  return fail(Fault::MailboxProtocol, "the station fills its mailbox without being asked", station_.where);
}

}  // namespace gantry::devices
