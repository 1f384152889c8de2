#include "devices/ethercat/slow_objects.hpp"

#include <algorithm>

#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/wire/cia402.hpp"

namespace gantry::devices {
namespace {

using config::ObjectType;

constexpr Time kLookEvery = milliseconds(20);      // at each input
constexpr Time kAfterRefusal = milliseconds(200);  // of a station that does not answer, or not with a number

ObjectType type_of(const SlowObject& o) {
  return *type_of_size(o.has_sign ? ObjectType::I8 : ObjectType::U8, static_cast<std::size_t>(o.bits) / 8);
}

std::int64_t number_of(const SlowObject& o, std::uint32_t value) {
  return o.has_sign ? static_cast<std::int8_t>(value) : std::int64_t{value};
}

void look(Link& link, StationRecord& s, SlowValue& v) {
  const auto value = read_number(link, s, v.object.by, type_of(v.object));
  if (value) v.value.store(static_cast<std::uint32_t>(*value), std::memory_order_relaxed);
  v.not_before = link.clock().now() + (value ? kLookEvery : kAfterRefusal);
}

}  // namespace

void serve_slow_objects(Link& link, StationRecord& s, BentImage& image) {
  for (SlowValue& v : image.slow()) {
    if (!v.object.output || link.clock().now() < v.not_before) continue;
    const std::uint32_t wanted = v.value.load(std::memory_order_relaxed);
    const bool no_mode = v.object.is_mode && wanted == 0;  // outputs are still, or again, nobody's
    if (no_mode || (v.sent_once && wanted == v.sent)) continue;
    if (!write_number(link, s, v.object.by, type_of(v.object), number_of(v.object, wanted))) {
      v.not_before = link.clock().now() + kAfterRefusal;
      return;
    }
    v.sent = wanted;
    v.sent_once = true;
    for (SlowValue& shown : image.slow())
      if (shown.object.address.index == v.object.address.index + 1) look(link, s, shown);
    return;
  }
  SlowValue* next = nullptr;
  for (SlowValue& v : image.slow())
    if (!v.object.output && (next == nullptr || v.not_before < next->not_before)) next = &v;
  if (next != nullptr && link.clock().now() >= next->not_before) look(link, s, *next);
}

void forget_slow_objects(BentImage& image) {
  for (SlowValue& v : image.slow()) {
    v.sent_once = false;
    v.not_before = {};
    if (!v.object.output) v.value.store(0, std::memory_order_relaxed);
  }
}

}  // namespace gantry::devices
