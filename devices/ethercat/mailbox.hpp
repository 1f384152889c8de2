// The mailbox of one station: one request out, one reply in, nothing lost in between (ETG.1000.4, 6.6: counter,
// repeat).
//   Mailbox box(link, station);
//   box.send(wire::MailboxType::Coe, request);
//   auto reply = box.receive(wire::MailboxType::Coe);      // bytes after the mailbox header
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {

class Mailbox {
 public:
  static constexpr Time kSendTimeout = milliseconds(100);  ///< until the station has emptied its mailbox
  static constexpr Time kReplyTimeout = milliseconds(1000);

  Mailbox(Link& link, StationRecord& station) : link_(link), station_(station) {}

  /// Most bytes after the header that a request may have.
  [[nodiscard]] std::size_t capacity() const;
  /// Fault::MailboxTimeout when the station's mailbox stays full.
  Result<void> send(wire::MailboxType type, std::span<const std::byte> body);
  /// The next reply of this type; others are dropped, emergencies are kept in the record. A request that the station
  /// may have taken for a repeat (MailboxState::Count) is sent again, at most twice.
  /// Fault::MailboxTimeout, Fault::MailboxProtocol.
  Result<std::vector<std::byte>> receive(wire::MailboxType type);
  /// Takes what came unasked, and throws away what an earlier, abandoned request left behind.
  Result<void> drain();

 private:
  [[nodiscard]] Result<bool> full(config::SyncManagerKind kind);
  [[nodiscard]] Result<std::vector<std::byte>> fetch();
  [[nodiscard]] Result<void> hand_over();
  [[nodiscard]] Result<bool> ask_repeat(int number);
  bool keep_emergency(const wire::MailboxHeader& header, std::span<const std::byte> body);

  Link& link_;
  StationRecord& station_;
  std::vector<std::byte> request_;  ///< the last one, header included
  int resent_ = 0;
};

}  // namespace gantry::devices
