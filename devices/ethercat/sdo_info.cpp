#include "devices/ethercat/sdo_info.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "devices/ethercat/mailbox.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::ObjectAddress;

constexpr std::size_t kMostBytes = 2 * 65536 + 16;  // every index there can be
constexpr int kMostFragments = 4096, kMostStrays = 16;

tl::unexpected<Error> broken(const StationRecord& s, std::string_view what) {
  return fail(Fault::MailboxProtocol, fmt::format("SDO information: {}", what), s.where);
}

/// Sends a request and joins the fragments of the answer: the data behind the SDO information headers.
Result<Bytes> exchange(Link& link, StationRecord& station, std::uint8_t opcode, std::span<const std::byte> data) {
  if (!station.has_coe()) return broken(station, "the station has no CoE");
  Mailbox box(link, station);
  if (!station.mailbox.clean)
    if (auto ok = box.drain(); !ok) return tl::unexpected(ok.error());
  station.mailbox.clean = false;

  Bytes request(kCoeHeader + sdo_info::kHeader + data.size());
  put_le<std::uint16_t>(request, 0, coe_header(CoeService::SdoInformation));
  put_le<std::uint8_t>(request, kCoeHeader, opcode);
  std::copy(data.begin(), data.end(), request.begin() + kCoeHeader + sdo_info::kHeader);
  if (auto ok = box.send(MailboxType::Coe, request); !ok) return tl::unexpected(ok.error());

  Bytes joined;
  int strays = 0;
  for (int fragments = 0; fragments < kMostFragments; ++fragments) {
    const auto reply = box.receive(MailboxType::Coe);
    if (!reply) return reply;
    const std::span<const std::byte> r(*reply);
    if (r.size() < kCoeHeader) return broken(station, "the reply is too short");
    if (coe_service(get_le<std::uint16_t>(r, 0)) != CoeService::SdoInformation) {
      // A station that does not know the service may answer with an SDO abort.
      if (r.size() >= kCoeHeader + kSdoBytes && sdo::is_abort(get_le<std::uint8_t>(r, kCoeHeader))) {
        const auto code = get_le<std::uint32_t>(r, kCoeHeader + 4);
        station.mailbox.clean = true;
        return fail(Fault::SdoAbort, fmt::format("SDO information: {} (abort code {:08X}h)", abort_text(code), code),
                    station.where);
      }
      if (++strays > kMostStrays) return broken(station, "replies to other requests keep coming");
      continue;
    }
    if (r.size() < kCoeHeader + sdo_info::kHeader) return broken(station, "the reply is too short");
    const auto op = get_le<std::uint8_t>(r, kCoeHeader);
    const auto body = r.subspan(kCoeHeader + sdo_info::kHeader);
    if ((op & sdo_info::kOpcodeMask) == sdo_info::kError) {
      const auto code = body.size() >= 4 ? get_le<std::uint32_t>(body, 0) : 0;
      station.mailbox.clean = true;
      return fail(Fault::SdoAbort, fmt::format("SDO information: {} (abort code {:08X}h)", abort_text(code), code),
                  station.where);
    }
    if ((op & sdo_info::kOpcodeMask) != opcode + 1) {
      if (++strays > kMostStrays) return broken(station, "replies to other requests keep coming");
      continue;
    }
    joined.insert(joined.end(), body.begin(), body.end());
    if (joined.size() > kMostBytes) return broken(station, "the answer does not end");
    if ((op & sdo_info::kIncomplete) == 0) {
      station.mailbox.clean = true;
      return joined;
    }
  }
  return broken(station, "the answer does not end");
}

/// The same; errors say what was asked.
Result<Bytes> ask(Link& link, StationRecord& station, std::uint8_t opcode, std::span<const std::byte> data,
                  std::string_view asked) {
  auto answer = exchange(link, station, opcode, data);
  if (answer) return answer;
  Error error = std::move(answer.error());
  error.message = fmt::format("{}: {}", asked, error.message);
  if (error.where.empty()) error.where = station.where;
  return tl::unexpected(std::move(error));
}

std::string text(std::span<const std::byte> raw) {
  std::string name;
  for (const std::byte b : raw) {
    const char c = static_cast<char>(b);
    if (c == '\0') break;
    name += c >= 0x20 && c < 0x7F ? c : '?';
  }
  return name;
}

}  // namespace

Result<std::vector<std::uint16_t>> read_object_indices(Link& link, StationRecord& station, std::uint16_t list) {
  std::array<std::byte, 2> request{};
  put_le<std::uint16_t>(request, 0, list);
  const auto answer =
      ask(link, station, sdo_info::kListRequest, request, fmt::format("listing objects (list {})", list));
  if (!answer) return tl::unexpected(answer.error());
  if (answer->size() < 2 || get_le<std::uint16_t>(*answer, 0) != list)
    return broken(station, "the answer is about another list");
  std::vector<std::uint16_t> indices;
  for (std::size_t at = 2; at + 2 <= answer->size(); at += 2) indices.push_back(get_le<std::uint16_t>(*answer, at));
  return indices;
}

Result<ObjectDescription> describe_object(Link& link, StationRecord& station, std::uint16_t index) {
  std::array<std::byte, 2> request{};
  put_le<std::uint16_t>(request, 0, index);
  const auto answer = ask(link, station, sdo_info::kObjectRequest, request, fmt::format("describing {:04X}h", index));
  if (!answer) return tl::unexpected(answer.error());
  if (answer->size() < sdo_info::kObjectName || get_le<std::uint16_t>(*answer, sdo_info::kObjectIndex) != index)
    return broken(station, "the answer is about another object");
  ObjectDescription d;
  d.index = index;
  d.data_type = get_le<std::uint16_t>(*answer, sdo_info::kObjectType);
  d.max_sub = get_le<std::uint8_t>(*answer, sdo_info::kObjectMaxSub);
  d.code = get_le<std::uint8_t>(*answer, sdo_info::kObjectCode) & 0x0F;
  d.name = text(std::span<const std::byte>(*answer).subspan(sdo_info::kObjectName));
  return d;
}

Result<EntryDescription> describe_entry(Link& link, StationRecord& station, ObjectAddress address) {
  std::array<std::byte, 4> request{};
  put_le<std::uint16_t>(request, 0, address.index);
  put_le<std::uint8_t>(request, 2, address.sub);
  const auto answer = ask(link, station, sdo_info::kEntryRequest, request,
                          fmt::format("describing {:04X}h:{:02X}", address.index, address.sub));
  if (!answer) return tl::unexpected(answer.error());
  if (answer->size() < sdo_info::kEntryName || get_le<std::uint16_t>(*answer, 0) != address.index ||
      get_le<std::uint8_t>(*answer, sdo_info::kEntrySub) != address.sub)
    return broken(station, "the answer is about another entry");
  EntryDescription e;
  e.address = address;
  e.data_type = get_le<std::uint16_t>(*answer, sdo_info::kEntryType);
  e.bit_length = get_le<std::uint16_t>(*answer, sdo_info::kEntryBits);
  e.access = get_le<std::uint16_t>(*answer, sdo_info::kEntryAccess);
  // Values that were not asked for would stand before the name.
  if (get_le<std::uint8_t>(*answer, sdo_info::kEntryValueInfo) == 0)
    e.name = text(std::span<const std::byte>(*answer).subspan(sdo_info::kEntryName));
  return e;
}

Result<std::vector<ObjectDescription>> read_object_list(Link& link, StationRecord& station, bool with_entries) {
  const auto indices = read_object_indices(link, station, sdo_info::kListAll);
  if (!indices) return tl::unexpected(indices.error());
  std::vector<ObjectDescription> objects;
  for (const std::uint16_t index : *indices) {
    auto object = describe_object(link, station, index);
    if (!object && object.error().fault == Fault::SdoAbort) {
      ObjectDescription& listed = objects.emplace_back();
      listed.index = index;
      listed.refused = std::move(object.error().message);
      continue;
    }
    if (!object) return tl::unexpected(object.error());
    for (int sub = 0; with_entries && sub <= object->max_sub; ++sub) {
      auto entry = describe_entry(link, station, {index, static_cast<std::uint8_t>(sub)});
      if (entry)
        object->entries.push_back(std::move(*entry));
      else if (entry.error().fault != Fault::SdoAbort)
        return tl::unexpected(entry.error());
    }
    objects.push_back(std::move(*object));
  }
  return objects;
}

}  // namespace gantry::devices
