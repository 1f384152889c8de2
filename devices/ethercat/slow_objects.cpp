#include "devices/ethercat/slow_objects.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/drive_entries.hpp"
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
  if (!v.unanswered_since) v.unanswered_since = link.clock().now();
  const auto value = read_number(link, s, v.object.by, type_of(v.object));
  v.not_before = link.clock().now() + (value ? kLookEvery : kAfterRefusal);
  v.answers = value.has_value();
  if (!value) return;
  v.value.store(static_cast<std::uint32_t>(*value), std::memory_order_relaxed);
  v.looks.store(std::max(1u, v.looks.load(std::memory_order_relaxed) + 1), std::memory_order_relaxed);
  v.unanswered_since.reset();
}

/// An output that the station does not have as the loop wants it.
bool is_wanted(const SlowValue& v, Time now) {
  if (!v.object.output || now < v.not_before) return false;
  const std::uint32_t wanted = v.value.load(std::memory_order_relaxed);
  const bool no_mode = v.object.is_mode && wanted == 0;  // outputs are still, or again, nobody's
  return !no_mode && !(v.sent_once && wanted == v.sent);
}

/// Once when it falls silent, once when it answers again.
void tell_silence_of(const StationRecord& s, SlowValue& v, Time now, std::vector<std::string>& news) {
  const bool silent = v.unanswered_since && now - *v.unanswered_since > kSilentAfter;
  if (silent == v.silent) return;
  v.silent = silent;
  const DriveEntry* e = nullptr;
  for (int slot = 0; slot < s.config->profile.slots && e == nullptr; ++slot)
    e = find_drive_entry(config::first_slot(s.config->profile, v.object.address, slot).index);
  const std::string what = fmt::format("{} ({})", config::to_text(v.object.by), e != nullptr ? e->name : "input");
  const std::string means = e != nullptr && *e->silent != '\0' ? fmt::format(": {}", e->silent) : "";
  news.push_back(silent ? fmt::format("{}: {} is read by SDO and has not answered for {:.1f} s, so that what is known "
                                      "of it is old{}",
                                      s.where, what, seconds(now - *v.unanswered_since), means)
                        : fmt::format("{}: {} answers again", s.where, what));
}

/// Each one once: what the loop wants is asked for again and again.
void tell_refusal_of(const StationRecord& s, SlowValue& v, std::vector<std::string>& news) {
  if (v.refusal == v.refusal_told) return;
  v.refusal_told = v.refusal;
  const std::string what = config::to_text(v.object.by);
  news.push_back(v.refusal.empty()
                     ? fmt::format("{}: {} is taken again", s.where, what)
                     : fmt::format("{}: {} is set by SDO, and that failed: {}", s.where, what, v.refusal));
}

}  // namespace

void tell_silence(const StationRecord& s, BentImage& image, Time now, std::vector<std::string>& news) {
  for (SlowValue& v : image.slow())
    if (v.object.output)
      tell_refusal_of(s, v, news);
    else
      tell_silence_of(s, v, now, news);
}

bool slow_object_is_due(BentImage& image, Time now) {
  return std::ranges::any_of(
      image.slow(), [&](const SlowValue& v) { return v.object.output ? is_wanted(v, now) : now >= v.not_before; });
}

bool slow_objects_answer(BentImage& image) { return std::ranges::all_of(image.slow(), &SlowValue::answers); }

void serve_slow_objects(Link& link, StationRecord& s, BentImage& image) {
  for (SlowValue& v : image.slow()) {
    if (!is_wanted(v, link.clock().now())) continue;
    const std::uint32_t wanted = v.value.load(std::memory_order_relaxed);
    const auto written = write_number(link, s, v.object.by, type_of(v.object), number_of(v.object, wanted));
    v.answers = written.has_value();
    v.refusal = written ? "" : written.error().message;
    if (!written) {
      v.not_before = link.clock().now() + kAfterRefusal;
      return;
    }
    v.sent = wanted;
    v.sent_once = true;
    for (SlowValue& shown : image.slow())
      if (shown.object.address.index == v.object.address.index + 1) look(link, s, shown);
    const std::int64_t asked = number_of(v.object, wanted);
    const auto holds = read_number(link, s, v.object.by, type_of(v.object));
    if (holds && *holds != asked)
      v.refusal = fmt::format("writing {} to {} was acknowledged, and it holds {}", asked, config::to_text(v.object.by),
                              *holds);
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
    if (v.object.output) continue;
    v.value.store(0, std::memory_order_relaxed);
    v.looks.store(0, std::memory_order_relaxed);
    v.unanswered_since.reset();
    v.silent = false;
  }
}

}  // namespace gantry::devices
