#include "devices/ethercat/sdo.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/mailbox.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::ObjectAddress;
using config::ObjectType;

constexpr std::size_t kBody = kCoeHeader + kSdoBytes;  // of every SDO message but normal transfers
constexpr std::size_t kSegmentHeader = kCoeHeader + 1;
constexpr std::size_t kMaxObjectBytes = 64 * 1024;
constexpr int kMostStrays = 16;  // answers to requests that were given up, before ours

std::string text(ObjectAddress o) { return fmt::format("{:04X}h:{:02X}", o.index, o.sub); }

std::string reading(ObjectAddress o) { return "reading " + text(o); }

/// "writing 60400010h to 1600h:01": the value with as many digits as it has bytes.
std::string writing(ObjectAddress o, std::span<const std::byte> value) {
  if (value.size() > 4) return fmt::format("writing {} bytes to {}", value.size(), text(o));
  std::string digits;
  for (const std::byte b : value) digits.insert(0, fmt::format("{:02X}", std::to_integer<unsigned>(b)));
  return fmt::format("writing {}h to {}", digits, text(o));
}

struct Conversation {
  Link& link;
  StationRecord& station;
  ObjectAddress object;
  std::string asked;  ///< in words, for errors
  Mailbox box{link, station};
  std::uint32_t aborted = 0;  ///< code of the abort that ended it
  int strays = 0;             ///< answers that were not to us
  bool begins_clean = false;  ///< none of them can be of a request that was given up

  [[nodiscard]] tl::unexpected<Error> broken(std::string_view what) const {
    return fail(Fault::MailboxProtocol, fmt::format("{}: {}", asked, what), station.where);
  }
  /// An error of the mailbox or of a register, with what it was for.
  [[nodiscard]] tl::unexpected<Error> during(Error error) const {
    error.message = fmt::format("{}: {}", asked, error.message);
    if (error.where.empty()) error.where = station.where;
    return tl::unexpected(std::move(error));
  }

  /// Ends a transfer that the station still believes in (ETG.1000.6, 5.6.2.7). It does not answer to that; whether it
  /// takes it changes nothing for us.
  [[nodiscard]] tl::unexpected<Error> abort(std::uint32_t code, std::string_view what) {
    Bytes request(kBody);
    put_le<std::uint16_t>(request, 0, coe_header(CoeService::SdoRequest));
    put_sdo_header(std::span(request).subspan(kCoeHeader), {sdo::kAbort, object.index, object.sub, code});
    (void)box.send(MailboxType::Coe, request);
    return broken(what);
  }

  /// Sends an SDO message and returns the answer's bytes from the CoE header on; aborts become errors.
  Result<Bytes> ask(std::span<const std::byte> sdo_message) {
    Bytes request(kCoeHeader + sdo_message.size());
    put_le<std::uint16_t>(request, 0, coe_header(CoeService::SdoRequest));
    std::copy(sdo_message.begin(), sdo_message.end(), request.begin() + kCoeHeader);
    if (auto ok = box.send(MailboxType::Coe, request); !ok) return during(ok.error());
    return listen();
  }

  /// The next answer.
  Result<Bytes> listen() {
    for (; strays < kMostStrays; ++strays) {
      auto reply = box.receive(MailboxType::Coe);
      if (!reply) return during(reply.error());
      if (reply->size() < kCoeHeader) return broken("the reply is too short");
      const auto service = coe_service(get_le<std::uint16_t>(*reply, 0));
      // An abort comes with the service "request" as well as "response" (ETG.1000.6, 5.6.2.7).
      if (service != CoeService::SdoResponse && service != CoeService::SdoRequest)
        return broken("the reply is no SDO response");
      if (reply->size() < kSegmentHeader) return broken("the reply is too short");
      if (reply->size() >= kBody) {
        const SdoHeader h = get_sdo_header(std::span<const std::byte>(*reply).subspan(kCoeHeader));
        if (sdo::is_abort(h.command)) {
          if (h.index != object.index && h.index != 0) continue;  // of a request that was given up
          aborted = h.data;
          return fail(Fault::SdoAbort, fmt::format("{}: {} (abort code {:08X}h)", asked, abort_text(h.data), h.data),
                      station.where);
        }
      }
      return reply;
    }
    return broken("replies to other requests keep coming");
  }

  /// First answer of an initiate request: the command is as expected and the object is ours.
  Result<Bytes> initiate(const SdoHeader& header, std::span<const std::byte> data, std::uint8_t expected) {
    Bytes message(kSdoBytes);
    put_sdo_header(message, header);
    message.insert(message.end(), data.begin(), data.end());
    auto reply = ask(message);
    while (reply && about_another(*reply, expected)) {
      ++strays;
      reply = listen();
    }
    if (!reply && strays > 0 && aborted == 0) return broken("the reply is to another request");
    if (!reply) return reply;
    if (reply->size() < kBody) return broken("the reply is too short");
    return reply;
  }

  /// The answer to a request that was given up, which a station may hold for long (and repeat when its mailbox starts
  /// anew), or one that it gives twice. Ours follows.
  [[nodiscard]] bool about_another(const Bytes& reply, std::uint8_t expected) const {
    if (reply.size() < kBody) return false;
    const SdoHeader h = get_sdo_header(std::span<const std::byte>(reply).subspan(kCoeHeader));
    return h.index != object.index || h.sub != object.sub || (h.command & sdo::kCommandMask) != expected;
  }

  /// The rest of an object that did not fit the first answer.
  Result<Bytes> collect_segments(Bytes value, std::size_t complete) {
    for (std::uint8_t toggle = 0; value.size() < complete; toggle ^= sdo::kToggle) {
      std::array<std::byte, kSdoBytes> message{};
      put_le<std::uint8_t>(message, 0, static_cast<std::uint8_t>(sdo::kUploadSegmentRequest | toggle));
      const auto reply = ask(message);
      if (!reply) return reply;
      const auto command = get_le<std::uint8_t>(*reply, kCoeHeader);
      if ((command & sdo::kCommandMask) != sdo::kUploadSegmentResponse)
        return abort(abort_code::kCommand, "the answer is no segment");
      if ((command & sdo::kToggle) != toggle) return abort(abort_code::kToggle, "a segment is out of turn");
      std::size_t size = reply->size() - kSegmentHeader;
      if (size <= 7) size = std::min(size, sdo::short_segment_size(command));
      const auto first = reply->begin() + kSegmentHeader;
      value.insert(value.end(), first, first + static_cast<std::ptrdiff_t>(size));
      const bool last = (command & sdo::kLastSegment) != 0;
      if (last != (value.size() == complete) || (size == 0 && !last))
        return abort(abort_code::kSize, "segments and size disagree");
    }
    return value;
  }

  /// What did not fit the first request.
  Result<void> send_segments(std::span<const std::byte> rest) {
    const std::size_t most = box.capacity() - kSegmentHeader;
    for (std::uint8_t toggle = 0; !rest.empty(); toggle ^= sdo::kToggle) {
      const auto now = rest.first(std::min(rest.size(), most));
      rest = rest.subspan(now.size());
      Bytes message(1 + std::max<std::size_t>(now.size(), 7));
      put_le<std::uint8_t>(
          message, 0,
          static_cast<std::uint8_t>(sdo::kDownloadSegmentRequest | toggle | sdo::segment_size_bits(now.size()) |
                                    (rest.empty() ? sdo::kLastSegment : 0)));
      std::copy(now.begin(), now.end(), message.begin() + 1);
      const auto reply = ask(message);
      if (!reply) return tl::unexpected(reply.error());
      const auto command = get_le<std::uint8_t>(*reply, kCoeHeader);
      if ((command & sdo::kCommandMask) != sdo::kDownloadSegmentResponse)
        return abort(abort_code::kCommand, "the answer is no acknowledgement of a segment");
      if ((command & sdo::kToggle) != toggle)
        return abort(abort_code::kToggle, "a segment is acknowledged out of turn");
    }
    return {};
  }
};

Result<Conversation> begin(Link& link, StationRecord& station, ObjectAddress object, std::string asked) {
  if (!station.has_mailbox())
    return fail(Fault::MailboxProtocol, fmt::format("{}: the station has no mailbox", asked), station.where);
  Conversation c{link, station, object, std::move(asked)};
  if (c.box.capacity() < kBody) return c.broken("the station's mailbox is too small for an SDO");
  c.begins_clean = station.mailbox.clean;
  if (!station.mailbox.clean || station.mailbox.talkative)
    if (auto ok = c.box.drain(); !ok) return c.during(ok.error());
  station.mailbox.clean = false;  // until this one has ended in order
  return c;
}

/// What a transfer came to: a station that refused it has answered all the same.
template <class T>
T ended(Conversation& c, T result) {
  c.station.mailbox.clean = result.has_value() || c.aborted != 0;
  if (c.strays > 0 && c.begins_clean) c.station.mailbox.talkative = true;
  return result;
}

std::uint8_t access_bit(SdoAccess access) { return access == SdoAccess::Complete ? sdo::kCompleteAccess : 0; }

/// How many of an expedited answer's four bytes are the value. An answer may leave that out (42h instead of 4Bh): then
/// they are those that the object is known to have, as long as nothing but their sign stands behind them.
std::size_t expedited_bytes(const SdoHeader& h, std::size_t known) {
  if ((h.command & sdo::kSizeIndicated) != 0) return sdo::expedited_size(h.command);
  if (known == 0 || known >= 4) return 4;
  const std::uint32_t behind = h.data >> (8 * known), minus = 0xFFFFFFFFu >> (8 * known);
  const bool negative = (h.data >> (8 * known - 1) & 1u) != 0;
  return behind == 0 || (negative && behind == minus) ? known : 4;
}

Result<Bytes> upload(Conversation& c, SdoAccess access, std::size_t known) {
  const ObjectAddress object = c.object;
  auto reply =
      c.initiate({static_cast<std::uint8_t>(sdo::kUploadRequest | access_bit(access)), object.index, object.sub, 0}, {},
                 sdo::kUploadResponse);
  if (!reply) return reply;
  const SdoHeader h = get_sdo_header(std::span<const std::byte>(*reply).subspan(kCoeHeader));
  const auto data = reply->begin() + kCoeHeader + 4;
  if ((h.command & sdo::kExpedited) != 0) {
    return Bytes(data, data + static_cast<std::ptrdiff_t>(expedited_bytes(h, known)));
  }
  if (h.data > kMaxObjectBytes) return c.abort(abort_code::kOutOfMemory, "the object is larger than anything we read");
  const std::size_t here = std::min<std::size_t>(reply->size() - kBody, h.data);
  Bytes value(reply->begin() + kBody, reply->begin() + static_cast<std::ptrdiff_t>(kBody + here));
  return c.collect_segments(std::move(value), h.data);
}

Result<void> download(Conversation& c, std::span<const std::byte> value, SdoAccess access) {
  SdoHeader h{static_cast<std::uint8_t>(sdo::kDownloadRequest | access_bit(access)), c.object.index, c.object.sub, 0};
  std::span<const std::byte> behind;
  if (!value.empty() && value.size() <= 4 && access == SdoAccess::Single) {
    h.command = static_cast<std::uint8_t>(h.command | sdo::kExpedited | sdo::kSizeIndicated |
                                          sdo::expedited_size_bits(value.size()));
    for (std::size_t i = 0; i < value.size(); ++i) h.data |= std::to_integer<std::uint32_t>(value[i]) << (8 * i);
  } else {
    h.command |= sdo::kSizeIndicated;
    h.data = static_cast<std::uint32_t>(value.size());
    behind = value.first(std::min(value.size(), c.box.capacity() - kBody));
  }
  const auto reply = c.initiate(h, behind, sdo::kDownloadResponse);
  if (!reply) return tl::unexpected(reply.error());
  const bool expedited = (h.command & sdo::kExpedited) != 0;
  return c.send_segments(expedited ? std::span<const std::byte>{} : value.subspan(behind.size()));
}

/// Says the station by this that it does not know complete access?
bool refuses_complete(std::uint32_t abort) {
  return abort == abort_code::kCompleteAccessUnsupported || abort == abort_code::kUnsupportedAccess ||
         abort == abort_code::kCommand;
}

/// Sub-index 0 as two bytes, then the others, read one by one.
Result<Bytes> upload_singly(Link& link, StationRecord& station, std::uint16_t index) {
  const auto count = sdo_upload(link, station, {index, 0});
  if (!count) return count;
  Bytes all{count->empty() ? std::byte{0} : count->front(), std::byte{0}};
  for (int sub = 1; sub <= std::to_integer<int>(all[0]); ++sub) {
    const auto value = sdo_upload(link, station, {index, static_cast<std::uint8_t>(sub)});
    if (!value) return value;
    all.insert(all.end(), value->begin(), value->end());
  }
  return all;
}

/// The same for a download. How long each sub-index is, the station knows. Objects like a PDO's mapping take their
/// entries only while sub-index 0 is 0; where it is fixed, that is refused and does not matter.
Result<void> download_singly(Link& link, StationRecord& station, std::uint16_t index,
                             std::span<const std::byte> value) {
  if (value.size() < 2)
    return fail(Fault::SdoSizeMismatch, fmt::format("{:04X}h: complete access needs sub-index 0 as two bytes", index),
                station.where);
  const std::array<std::byte, 1> count{value[0]}, none{};
  std::vector<std::size_t> sizes;
  for (int sub = 1; sub <= std::to_integer<int>(count[0]); ++sub) {
    const auto old = sdo_upload(link, station, {index, static_cast<std::uint8_t>(sub)});
    if (!old) return tl::unexpected(old.error());
    sizes.push_back(old->size());
  }
  const auto cleared = sdo_download(link, station, {index, 0}, none);
  if (!cleared && cleared.error().fault != Fault::SdoAbort) return cleared;
  std::size_t at = 2;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] > value.size() - at)
      return fail(Fault::SdoSizeMismatch, fmt::format("{:04X}h: the value ends within sub-index {}", index, i + 1),
                  station.where);
    const ObjectAddress sub{index, static_cast<std::uint8_t>(i + 1)};
    if (auto ok = sdo_download(link, station, sub, value.subspan(at, sizes[i])); !ok) return ok;
    at += sizes[i];
  }
  return cleared ? sdo_download(link, station, {index, 0}, count) : Result<void>{};
}

}  // namespace

Result<Bytes> sdo_upload(Link& link, StationRecord& station, ObjectAddress object, SdoAccess access,
                         std::uint32_t* aborted, std::size_t known_bytes) {
  auto c = begin(link, station, object, reading(object));
  if (!c) return tl::unexpected(c.error());
  auto value = ended(*c, upload(*c, access, known_bytes));
  if (aborted != nullptr) *aborted = c->aborted;
  if (!value && access == SdoAccess::Complete && object.sub == 0 && refuses_complete(c->aborted))
    return upload_singly(link, station, object.index);
  return value;
}

Result<void> sdo_download(Link& link, StationRecord& station, ObjectAddress object, std::span<const std::byte> value,
                          SdoAccess access, std::uint32_t* aborted) {
  auto c = begin(link, station, object, writing(object, value));
  if (!c) return tl::unexpected(c.error());
  auto done = ended(*c, download(*c, value, access));
  if (aborted != nullptr) *aborted = c->aborted;
  if (!done && access == SdoAccess::Complete && object.sub == 0 && refuses_complete(c->aborted))
    return download_singly(link, station, object.index, value);
  return done;
}

Result<std::int64_t> read_number(Link& link, StationRecord& station, ObjectAddress object, ObjectType type,
                                 std::uint32_t* aborted) {
  const auto bytes = sdo_upload(link, station, object, SdoAccess::Single, aborted, bytes_of(type));
  if (!bytes) return tl::unexpected(bytes.error());
  if (const auto value = to_number_of_any_size(type, *bytes)) return *value;
  return fail(Fault::SdoSizeMismatch,
              fmt::format("{}: has {} bytes, the profile says {}", reading(object), bytes->size(), bytes_of(type)),
              station.where);
}

Result<void> write_number(Link& link, StationRecord& station, ObjectAddress object, ObjectType type, std::int64_t value,
                          std::uint32_t* aborted) {
  std::uint32_t refused = 0;
  auto done = sdo_download(link, station, object, to_bytes(type, value), SdoAccess::Single, &refused);
  if (aborted != nullptr) *aborted = refused;
  const bool of_size =
      refused == abort_code::kSize || refused == abort_code::kSizeTooLarge || refused == abort_code::kSizeTooSmall;
  if (done || !of_size) return done;
  const auto as_it_is = sdo_upload(link, station, object);
  if (!as_it_is || as_it_is->size() == bytes_of(type)) return done;
  const auto other = type_of_size(type, as_it_is->size());
  if (!other || to_number(*other, to_bytes(*other, value)) != value)
    return fail(Fault::SdoSizeMismatch,
                fmt::format("{}: has {} bytes, the profile says {}", writing(object, to_bytes(type, value)),
                            as_it_is->size(), bytes_of(type)),
                station.where);
  return sdo_download(link, station, object, to_bytes(*other, value), SdoAccess::Single, aborted);
}

}  // namespace gantry::devices
