// Esc: the RAM and its SyncManagers (ESC data sheet I, chapter 8). Mailbox mode: one buffer that the sides fill and
// empty in turn. Buffered mode: three, of which the station and the bus see one each; in memory_ lies the bus's, in
// other_side_ the station's. A buffer is opened by its first byte and changes hands with its last one.
#include <algorithm>
#include <cstring>

#include "sim/esc/esc.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {
constexpr std::size_t kSm0 = reg::kSyncManager0;
constexpr std::uint8_t kWrittenInterrupt = 0x01, kReadInterrupt = 0x02, kPdiDisable = 0x01;  // bytes 5 and 7
constexpr std::uint8_t kNoBuffer = 3;
}  // namespace

int Esc::covering(std::size_t at, std::size_t& end) const noexcept {
  for (int i = 0; i < kSyncManagers; ++i) {
    if ((active_buffers_ >> i & 1) == 0) continue;
    const Buffer& b = buffers_[static_cast<std::size_t>(i)];
    if (at >= b.from && at < b.to) {
      end = std::min(end, b.to);
      return i;
    }
    if (at < b.from) end = std::min(end, b.from);
  }
  return -1;
}

bool Esc::read_ram(std::size_t at, std::span<std::byte> out) noexcept {
  bool any = false;
  for (std::size_t done = 0; done < out.size();) {
    std::size_t end = at + out.size();
    const int i = covering(at + done, end);
    const auto part = out.subspan(done, end - at - done);
    if (i >= 0) {
      any |= read_buffer(i, at + done, part);
    } else {
      copy_few(part.data(), std::span(memory_).subspan(at + done, part.size()));
      any = true;
    }
    done = end - at;
  }
  return any;
}

bool Esc::write_ram(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  bool any = false;
  for (std::size_t done = 0; done < in.size();) {
    std::size_t end = at + in.size();
    const int i = covering(at + done, end);
    const auto part = in.subspan(done, end - at - done);
    if (i >= 0) {
      any |= write_buffer(i, at + done, part, now);
    } else {
      const std::size_t pins = at + done < kUserRam ? std::min(part.size(), kUserRam - at - done) : 0;
      if (pins > 0) any |= write_pins(at + done, part.first(pins));
      if (pins < part.size()) {
        std::memcpy(memory_.data() + at + done + pins, part.data() + pins, part.size() - pins);
        any = true;
      }
    }
    done = end - at;
  }
  return any;
}

bool Esc::read_buffer(int i, std::size_t at, std::span<std::byte> out) noexcept {
  Buffer& b = buffers_[static_cast<std::size_t>(i)];
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  if (b.locked || b.bus_writes || !b.written) return false;
  const bool last = at + out.size() == b.to;
  bool from_other = false;  // all at once: nothing to keep
  if (at == b.from) {
    b.open = true;
    from_other = !b.mailbox && last;
    if (!b.mailbox && !last) copy_few(memory_.data() + b.from, std::span(other_side_).subspan(b.from, b.to - b.from));
    sm.status = static_cast<std::uint8_t>(sm.status & ~kWrittenInterrupt);
  } else if (!b.open) {
    return false;
  }
  copy_few(out.data(), std::span(from_other ? other_side_ : memory_).subspan(at, out.size()));
  if (last) {
    b.open = false;
    sm.status |= kReadInterrupt;
    if (b.mailbox) {
      b.written = false;
      events_ |= kMailboxRead;
    }
  }
  update_status(i);
  return true;
}

bool Esc::write_buffer(int i, std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  Buffer& b = buffers_[static_cast<std::size_t>(i)];
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  if (b.locked || !b.bus_writes || (b.mailbox && b.written)) return false;
  if (at == b.from) {
    b.open = true;
    sm.status = static_cast<std::uint8_t>(sm.status & ~kReadInterrupt);
  } else if (!b.open) {
    return false;
  }
  const bool last = at + in.size() == b.to;
  const bool to_other = !b.mailbox && last && at == b.from;  // all at once
  copy_few((to_other ? other_side_ : memory_).data() + at, in);
  if (last) {
    b.open = false;
    b.written = true;
    sm.status |= kWrittenInterrupt;
    if (b.mailbox) {
      events_ |= kMailboxWritten;
    } else {
      if (!to_other) copy_few(other_side_.data() + b.from, std::span(memory_).subspan(b.from, b.to - b.from));
      b.number = static_cast<std::uint8_t>((b.number + 1) % 3);
      if (outputs_written_at_ == kNever) put<std::uint8_t>(reg::kWatchdogStatusProcessData, 1);
      outputs_written_at_ = now;
      events_ |= kOutputsWritten;
    }
  }
  update_status(i);
  return true;
}

/// Byte 5, and what 0210h says of a mailbox.
void Esc::update_status(int i) noexcept {
  const auto n = static_cast<std::size_t>(i);
  const Buffer& b = buffers_[n];
  auto& sm = sync_managers_[n];
  const bool full = b.mailbox && b.written;
  const unsigned buffer = b.mailbox ? 0u : b.number;
  const auto status = static_cast<std::uint8_t>((sm.status & (kWrittenInterrupt | kReadInterrupt)) |
                                                (full ? kSmStatusMailboxFull : 0u) | buffer << 4);
  sm.status = status;
  const auto bit = static_cast<std::uint16_t>(1u << (4 + i));
  const bool told = b.mailbox && !b.bus_writes && (status & kWrittenInterrupt) != 0;
  if (((bus_events_ & bit) != 0) == told) return;
  bus_events_ ^= bit;
  update_irq();
}

void Esc::show_sync_managers() noexcept {
  for (std::size_t i = 0; i < kSyncManagers; ++i)
    put<std::uint8_t>(kSm0 + i * kSyncManagerBytes + kSmStatusOffset, sync_managers_[i].status);
}

void Esc::reload_sync_managers(std::size_t at, std::size_t size) noexcept {
  for (int i = 0; i < kSyncManagers; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const std::size_t from = kSm0 + n * kSyncManagerBytes;
    if (at >= from + kSyncManagerBytes || from >= at + size) continue;
    SyncManager sm = get_sync_manager(std::span(memory_).subspan(from, kSyncManagerBytes));
    const SyncManager old = sync_managers_[n];
    const bool active = (sm.activate & kSmActivateEnable) != 0;
    const bool was = (old.activate & kSmActivateEnable) != 0;
    sm.status = old.status;
    Buffer& b = buffers_[n];
    if (active != was || !active) {
      // Off: all that was under way is forgotten.
      const bool locked = b.locked;
      b = {};
      b.locked = locked;
      b.mailbox = (sm.control & 0x03) == kSmMailboxMode;
      b.bus_writes = (sm.control & 0x0C) == kSmEcatWrites;
      sm.status = 0;
      if (active) {
        b.from = sm.start, b.to = static_cast<std::size_t>(sm.start) + sm.length;
        b.watched = !b.mailbox && b.bus_writes && (sm.control & kSmWatchdogTrigger) != 0;
      }
      const bool covers = active && sm.length > 0 && b.from >= kMemoryFrom && b.to <= kMemoryBytes;
      active_buffers_ = covers ? active_buffers_ | 1u << i : active_buffers_ & ~(1u << i);
    }
    if (active != was) events_ |= kSyncManagersChanged;
    if (active && b.mailbox && ((sm.activate ^ sm.pdi_control) & kSmActivateRepeatRequest) != 0)
      events_ |= kMailboxRepeat;
    sync_managers_[n] = sm;
    update_status(i);
  }
  update_watchdog_limit();
}

void Esc::lock_sync_manager(int i, bool locked) noexcept {
  const auto n = static_cast<std::size_t>(i);
  Buffer& b = buffers_[n];
  auto& sm = sync_managers_[n];
  if (b.locked == locked) return;
  b.locked = locked;
  b.open = b.written = false;
  b.number = kNoBuffer;
  sm.status = 0;
  sm.pdi_control = static_cast<std::uint8_t>(locked ? sm.pdi_control | kPdiDisable : sm.pdi_control & ~kPdiDisable);
  put<std::uint8_t>(kSm0 + n * kSyncManagerBytes + 7, sm.pdi_control);
  update_status(i);
}

std::span<std::byte> Esc::area(int i) noexcept {
  if ((active_buffers_ >> i & 1) == 0) return {};
  const Buffer& b = buffers_[static_cast<std::size_t>(i)];
  return std::span(b.mailbox ? memory_ : other_side_).subspan(b.from, b.to - b.from);
}

void Esc::publish(int i) noexcept {
  Buffer& b = buffers_[static_cast<std::size_t>(i)];
  if ((active_buffers_ >> i & 1) == 0 || b.mailbox || b.locked) return;
  b.written = true;
  b.number = static_cast<std::uint8_t>((b.number + 1) % 3);
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  sm.status = static_cast<std::uint8_t>((sm.status & ~kReadInterrupt) | kWrittenInterrupt);
  update_status(i);
}

bool Esc::mailbox_full(int i) const noexcept {
  const Buffer& b = buffers_[static_cast<std::size_t>(i)];
  return b.mailbox && b.written;
}

void Esc::set_mailbox_full(int i, bool full) noexcept {
  Buffer& b = buffers_[static_cast<std::size_t>(i)];
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  b.written = full;
  b.open = false;
  sm.status = static_cast<std::uint8_t>(full           ? (sm.status & ~kReadInterrupt) | kWrittenInterrupt
                                        : b.bus_writes ? (sm.status & ~kWrittenInterrupt) | kReadInterrupt
                                                       : sm.status & ~kWrittenInterrupt);
  update_status(i);
}

void Esc::acknowledge_repeat(int i) noexcept {
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  sm.pdi_control =
      static_cast<std::uint8_t>((sm.pdi_control & ~kSmPdiRepeatAck) | (sm.activate & kSmActivateRepeatRequest));
  put<std::uint8_t>(kSm0 + static_cast<std::size_t>(i) * kSyncManagerBytes + 7, sm.pdi_control);
}

}  // namespace gantry::sim
