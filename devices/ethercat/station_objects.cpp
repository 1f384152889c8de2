#include "devices/ethercat/station_objects.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/object_value.hpp"
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

Result<void> write_pdo_mapping(Link& link, StationRecord& s) {
  if (!s.writes_mapping) return {};
  struct Direction {
    std::uint16_t assign;
    std::span<const PdoRow> pdos;
  };
  for (const auto& d : {Direction{object::kRxPdoAssign, s.rx_pdos}, Direction{object::kTxPdoAssign, s.tx_pdos}}) {
    const auto writes = mapping_writes(d.assign, d.pdos);
    for (const auto& w : writes)
      if (auto ok = write_number(link, s, w.object, w.type, w.value); !ok) return ok;
    if (auto ok = read_back(link, s, writes); !ok) return ok;
  }
  return {};
}

}  // namespace gantry::devices
