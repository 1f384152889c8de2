// The mailbox of a virtual station and its one protocol, CANopen over EtherCAT: SDO upload and download (expedited,
// normal, segmented, complete access), SDO information, abort codes as ETG.1000.6 has them, emergencies.
//   CoeServer server(objects, 128, 128);
//   server.take(request_mailbox, pre_op);     // the master has filled the receive mailbox
//   if (server.waiting()) send_mailbox = server.next();
// Off the cyclic path: it may allocate.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "devices/wire/coe.hpp"
#include "sim/objects/mailbox_lies.hpp"
#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

class CoeServer {
 public:
  using Bytes = std::vector<std::byte>;

  /// `reply_bytes`: length of the mailbox that the master reads.
  CoeServer(ObjectDictionary& objects, std::size_t reply_bytes) : objects_(objects), reply_bytes_(reply_bytes) {}

  /// One mailbox as the master wrote it, header included. What it asks for is queued. A repeated counter is a repeated
  /// request and is dropped (ETG.1000.4, 5.6.2).
  void take(std::span<const std::byte> mailbox, bool pre_op);
  /// Emergency (ETG.1000.6, 5.6.4): CANopen error code, error register, five bytes of the vendor's.
  void emergency(std::uint16_t code, std::uint8_t error_register, std::uint16_t diagnostic = 0);

  /// Another request may be taken: not too many answers wait to be fetched.
  [[nodiscard]] bool room() const noexcept { return replies_.size() < 16; }
  [[nodiscard]] bool waiting() const noexcept { return !replies_.empty(); }
  /// The next mailbox for the master, header included; not longer than reply_bytes.
  Bytes next();
  /// Command byte of an abort; whether there is SDO information.
  void set_manner(std::uint8_t abort_command, bool information) noexcept {
    abort_command_ = abort_command, information_ = information;
  }
  void set_lies(const MailboxLies& lies) { lies_ = lies; }
  /// INIT: nothing is under way any more.
  void reset() noexcept;

 private:
  using SdoHeader = devices::wire::SdoHeader;

  void serve_sdo(std::span<const std::byte> sdo, bool pre_op);
  void upload(const SdoHeader& request);
  void upload_segment(std::uint8_t command);
  void download(const SdoHeader& request, std::span<const std::byte> data, bool pre_op);
  void download_segment(std::uint8_t command, std::span<const std::byte> data, bool pre_op);
  void abort(config::ObjectAddress address, std::uint32_t code);
  [[nodiscard]] std::uint32_t read(config::ObjectAddress address, bool complete, Bytes& data) const;
  [[nodiscard]] std::uint32_t write(config::ObjectAddress address, bool complete, std::span<const std::byte> data,
                                    bool pre_op);

  // SDO information (coe_information.cpp)
  void serve_information(std::span<const std::byte> info);
  void list_objects(std::uint16_t list);
  void describe_object(std::uint16_t index);
  void describe_entry(config::ObjectAddress address, std::uint8_t value_info);
  void information_error(std::uint32_t code);
  void reply_information(std::uint8_t opcode, const Bytes& body);

  void reply_sdo(const SdoHeader& header, std::span<const std::byte> more);
  void reply_segment(std::uint8_t command, std::span<const std::byte> data);
  void reply_error(devices::wire::MailboxError error);
  void reply(devices::wire::MailboxType type, Bytes payload);
  void queue(devices::wire::MailboxType type, const Bytes& payload);
  [[nodiscard]] bool may_be_expedited(const Bytes& data) const noexcept;

  /// A transfer that needs more than one mailbox.
  struct Transfer {
    enum class Kind { None, Upload, Download } kind = Kind::None;
    config::ObjectAddress address;
    bool complete = false;
    Bytes data;
    std::size_t done = 0;      ///< upload: bytes sent
    std::size_t expected = 0;  ///< download: bytes announced
    bool toggle = false;       ///< what the next segment must carry
  };

  ObjectDictionary& objects_;
  std::size_t reply_bytes_;
  std::uint8_t abort_command_ = devices::wire::sdo::kAbort;
  bool information_ = true;
  MailboxLies lies_;
  std::deque<Bytes> replies_;
  Transfer transfer_;
  std::uint8_t last_request_counter_ = 0, reply_counter_ = 0;
};

}  // namespace gantry::sim
