// CoeServer: the SDO information service (ETG.1000.6, 5.6.3): which objects there are, what they are called, and what
// their entries hold.
#include <algorithm>
#include <array>
#include <set>

#include "sim/objects/coe_server.hpp"

namespace gantry::sim {

using namespace devices::wire;
using config::ObjectType;

namespace {

enum Opcode : std::uint8_t {
  kListRequest = 1,
  kListResponse = 2,
  kObjectRequest = 3,
  kObjectResponse = 4,
  kEntryRequest = 5,
  kEntryResponse = 6,
  kErrorResponse = 7,
};
constexpr std::uint8_t kOpcodeMask = 0x7F, kIncomplete = 0x80;
constexpr std::size_t kInfoHeader = 4;  // opcode, reserved, fragments left

constexpr std::uint16_t kLists = 5;  // 0: lengths of 1..5; 1 all, 2 RxPDO, 3 TxPDO, 4 stored, 5 start-up
// Value information: what the entry description shall carry
constexpr std::uint8_t kUnitType = 0x08, kDefault = 0x10, kMinimum = 0x20, kMaximum = 0x40;
// Access rights
constexpr std::uint16_t kReadAlways = 0x0007, kWriteAlways = 0x0038, kWritePreOp = 0x0008, kInRxPdo = 0x0040,
                        kInTxPdo = 0x0080, kBackup = 0x0100, kSetting = 0x0200;

std::uint16_t access_of(const Object& o) {
  unsigned rights = o.readable ? kReadAlways : 0u;
  if (o.writable) rights |= o.rule == ObjectRule::Plain ? kWriteAlways : kWritePreOp;
  if (o.mappable && o.writable) rights |= kInRxPdo;
  if (o.mappable && o.readable) rights |= kInTxPdo;
  if (o.kept) rights |= kBackup;
  if (o.writable && !o.mappable && o.rule == ObjectRule::Plain) rights |= kSetting;
  return static_cast<std::uint16_t>(rights);
}

bool in_list(const Object& o, std::uint16_t list) {
  switch (list) {
    case 1: return true;
    case 2: return o.mappable && o.writable;
    case 3: return o.mappable && o.readable;
    case 4: return o.kept;
    case 5: return o.writable && !o.mappable && o.rule == ObjectRule::Plain;
    default: return false;
  }
}

template <class T>
void append(CoeServer::Bytes& out, std::uint64_t value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

void append(CoeServer::Bytes& out, const std::string& text) {
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

}  // namespace

void CoeServer::serve_information(std::span<const std::byte> info) {
  if (info.size() < kInfoHeader) return reply_error(MailboxError::SizeTooShort);
  const auto opcode = get_le<std::uint8_t>(info, 0) & kOpcodeMask;
  const auto body = info.subspan(kInfoHeader);
  if (opcode == kListRequest && body.size() >= 2) return list_objects(get_le<std::uint16_t>(body, 0));
  if (opcode == kObjectRequest && body.size() >= 2) return describe_object(get_le<std::uint16_t>(body, 0));
  if (opcode == kEntryRequest && body.size() >= 4)
    return describe_entry({get_le<std::uint16_t>(body, 0), get_le<std::uint8_t>(body, 2)},
                          get_le<std::uint8_t>(body, 3));
  information_error(abort_code::kCommand);
}

void CoeServer::list_objects(std::uint16_t list) {
  if (list > kLists) return information_error(abort_code::kUnsupportedAccess);
  std::array<std::set<std::uint16_t>, kLists + 1> lists;
  for (const Object& o : objects_.all())
    for (std::uint16_t n = 1; n <= kLists; ++n)
      if (in_list(o, n)) lists[n].insert(o.address.index);
  Bytes body;
  append<std::uint16_t>(body, list);
  if (list == 0)
    for (std::uint16_t n = 1; n <= kLists; ++n) append<std::uint16_t>(body, lists[n].size());
  else
    for (const std::uint16_t index : lists[list]) append<std::uint16_t>(body, index);
  reply_information(kListResponse, body);
}

void CoeServer::describe_object(std::uint16_t index) {
  const auto subs = objects_.index(index);
  if (subs.empty()) return information_error(abort_code::kNoObject);
  const ObjectShape shape = objects_.shape(index);
  Bytes body;
  append<std::uint16_t>(body, index);
  append<std::uint16_t>(body, shape.data_type);
  append<std::uint8_t>(body, subs.back().address.sub);
  append<std::uint8_t>(body, static_cast<std::uint64_t>(shape.code));
  append(body, shape.name);
  reply_information(kObjectResponse, body);
}

void CoeServer::describe_entry(config::ObjectAddress address, std::uint8_t value_info) {
  const Object* o = objects_.find(address);
  if (o == nullptr)
    return information_error(objects_.index(address.index).empty() ? abort_code::kNoObject : abort_code::kNoSub);
  // No units are told: the vendor's have no number of ETG.1004.
  std::uint8_t told = value_info & 0x07;
  const bool number = o->type != ObjectType::String;
  if (number) told |= value_info & kDefault;
  if (number && o->facts->min) told |= value_info & kMinimum;
  if (number && o->facts->max) told |= value_info & kMaximum;
  Bytes body;
  append<std::uint16_t>(body, address.index);
  append<std::uint8_t>(body, address.sub);
  append<std::uint8_t>(body, told);
  append<std::uint16_t>(body, base_type(o->type));
  append<std::uint16_t>(body, number ? static_cast<unsigned>(config::bits(o->type)) : 8 * o->facts->text.size());
  append<std::uint16_t>(body, access_of(*o));
  const auto value = [&](std::int64_t v) {
    for (std::size_t i = 0; i < size_of(o->type); ++i)
      body.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(v) >> (8 * i) & 0xFF));
  };
  if ((told & kDefault) != 0) value(o->facts->initial);
  if ((told & kMinimum) != 0) value(*o->facts->min);
  if ((told & kMaximum) != 0) value(*o->facts->max);
  append(body, o->facts->name);
  reply_information(kEntryResponse, body);
}

void CoeServer::information_error(std::uint32_t code) {
  Bytes body;
  append<std::uint32_t>(body, code);
  reply_information(kErrorResponse, body);
}

/// In as many mailboxes as it needs; each says how many follow.
void CoeServer::reply_information(std::uint8_t opcode, const Bytes& body) {
  const std::size_t room = reply_bytes_ - kMailboxHeader - kCoeHeader - kInfoHeader;
  const std::size_t fragments = std::max<std::size_t>((body.size() + room - 1) / room, 1);
  for (std::size_t i = 0; i < fragments; ++i) {
    const auto part = std::span(body).subspan(i * room, std::min(room, body.size() - i * room));
    const std::size_t left = fragments - 1 - i;
    Bytes payload;
    append<std::uint16_t>(payload, coe_header(CoeService::SdoInformation));
    append<std::uint8_t>(payload, opcode | (left > 0 ? kIncomplete : 0));
    append<std::uint8_t>(payload, 0);
    append<std::uint16_t>(payload, left);
    payload.insert(payload.end(), part.begin(), part.end());
    reply(MailboxType::Coe, std::move(payload));
  }
}

}  // namespace gantry::sim
