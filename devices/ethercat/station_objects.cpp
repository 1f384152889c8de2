#include "devices/ethercat/station_objects.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/wire/cia402.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {

using namespace wire;
using config::ObjectType;
using config::PdoRow;

namespace {

struct Write {
  config::ObjectAddress object;
  ObjectType type;
  std::int64_t value;
};

/// What is written for one direction, in order.
std::vector<Write> mapping_writes(std::uint16_t assign, std::span<const PdoRow> pdos) {
  std::vector<Write> w{{{assign, 0}, ObjectType::U8, 0}};
  for (const auto& pdo : pdos) {
    w.push_back({{pdo.index, 0}, ObjectType::U8, 0});
    std::uint8_t sub = 0;
    for (const auto& entry : pdo.entries) {
      const auto& [index, object_sub] = entry.address;
      w.push_back({{pdo.index, ++sub}, ObjectType::U32, mapping_entry(index, object_sub, entry.bit_length)});
    }
    w.push_back({{pdo.index, 0}, ObjectType::U8, sub});
  }
  std::uint8_t sub = 0;
  for (const auto& pdo : pdos) w.push_back({{assign, ++sub}, ObjectType::U16, pdo.index});
  w.push_back({{assign, 0}, ObjectType::U8, sub});
  return w;
}

Result<void> read_back(Link& link, StationRecord& s, const std::vector<Write>& writes) {
  for (auto w = writes.begin(); w != writes.end(); ++w) {
    const bool written_again = std::any_of(w + 1, writes.end(), [&](const Write& l) { return l.object == w->object; });
    if (written_again) continue;
    const auto value = read_number(link, s, w->object, w->type);
    if (!value) return tl::unexpected(value.error());
    if (*value != w->value)
      return fail(Fault::PdoMappingDiffers,
                  fmt::format("{:04X}h:{:02X} reads back as {:X}h, written was {:X}h", w->object.index, w->object.sub,
                              *value, w->value),
                  s.where);
  }
  return {};
}

}  // namespace

Result<void> write_direction(Link& link, StationRecord& s, bool outputs, std::uint32_t* aborted) {
  auto writes = mapping_writes(pdo_assignment(s, outputs), outputs ? s.rx_pdos : s.tx_pdos);
  std::erase_if(writes, [&](const Write& w) {
    const bool assignment = w.object.index < object::kRxPdoMap0 || w.object.index >= object::kSyncManagerType;
    return assignment ? s.fixed(outputs).assignment : s.fixed(outputs).mapping;
  });
  for (const auto& w : writes)
    if (auto ok = write_number(link, s, w.object, w.type, w.value, aborted); !ok) return ok;
  return read_back(link, s, writes);
}

Result<void> write_pdo_mapping(Link& link, StationRecord& s) {
  if (!s.writes_mapping) return {};
  for (const bool outputs : {true, false})
    if (auto ok = write_direction(link, s, outputs); !ok) return ok;
  return {};
}

Result<void> set_first_mode(Link& link, StationRecord& s) {
  for (const SlowObject& object : s.slow)
    if (object.is_mode)
      if (auto ok = write_number(link, s, object.by, ObjectType::I8, cia402::kCsp); !ok) return ok;
  return {};
}

Result<void> leave_out_absent(Link& link, StationRecord& s, std::vector<std::string>& notes) {
  if (s.config == nullptr || !s.config->profile.drive) return {};
  for (auto row = s.startup.begin(); row != s.startup.end();) {
    bool acceleration = false;
    for (int slot = 0; slot < s.config->profile.slots; ++slot)
      acceleration |= row->address == config::in_slot(s.config->profile, {cia402::kHomingAcceleration, 0}, slot);
    std::uint32_t aborted = 0;
    if (acceleration)
      if (auto value = sdo_upload(link, s, row->address, SdoAccess::Single, &aborted); !value && aborted == 0)
        return tl::unexpected(value.error());
    if (aborted != abort_code::kNoObject) {
      ++row;
      continue;
    }
    notes.push_back(
        fmt::format("{}: it has no {:04X}h (homing acceleration): it homes with its own", s.where, row->address.index));
    row = s.startup.erase(row);
  }
  return {};
}

}  // namespace gantry::devices
