#include "app/stations/station_news.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "devices/profiles/fault_text.hpp"

namespace gantry::stations {
namespace {

using devices::ErrorCounts;

constexpr std::int64_t kQuiet_ns = 10'000'000'000;

struct CodeClass {
  std::uint16_t mask, code;
  std::string_view text;
};
// The narrow ones first.
constexpr std::array kClasses{
    CodeClass{0xFFFF, 0xA000, "refused PRE_OP to SAFE_OP"},
    CodeClass{0xFFFF, 0xA001, "refused SAFE_OP to OP"},
    CodeClass{0xFF00, 0x0000, "error reset, or no error"},
    CodeClass{0xFF00, 0x2100, "current, input side"},
    CodeClass{0xFF00, 0x2200, "current inside"},
    CodeClass{0xFF00, 0x2300, "current, output side"},
    CodeClass{0xFF00, 0x3100, "mains voltage"},
    CodeClass{0xFF00, 0x3200, "voltage inside"},
    CodeClass{0xFF00, 0x3300, "output voltage"},
    CodeClass{0xFF00, 0x4100, "ambient temperature"},
    CodeClass{0xFF00, 0x4200, "device temperature"},
    CodeClass{0xFF00, 0x6100, "internal software"},
    CodeClass{0xFF00, 0x6200, "user software"},
    CodeClass{0xFF00, 0x6300, "data set"},
    CodeClass{0xFF00, 0x8100, "communication"},
    CodeClass{0xFF00, 0x8200, "protocol"},
    CodeClass{0xFF00, 0xF000, "additional functions"},
    CodeClass{0xFF00, 0xFF00, "device specific"},
    CodeClass{0xF000, 0x1000, "generic"},
    CodeClass{0xF000, 0x2000, "current"},
    CodeClass{0xF000, 0x3000, "voltage"},
    CodeClass{0xF000, 0x4000, "temperature"},
    CodeClass{0xF000, 0x5000, "device hardware"},
    CodeClass{0xF000, 0x6000, "device software"},
    CodeClass{0xF000, 0x7000, "additional modules"},
    CodeClass{0xF000, 0x8000, "monitoring"},
    CodeClass{0xF000, 0x9000, "external"},
};

/// "port 1: 3 frames with a wrong checksum, 1 lost links"; a counter that is lower has begun anew with the supply.
std::string growth(const ErrorCounts& before, const ErrorCounts& now) {
  std::string words;
  std::string_view part;
  for (std::size_t i = 0; i < now.size() && i < before.size(); ++i) {
    const unsigned more = now[i].value >= before[i].value ? now[i].value - before[i].value : now[i].value;
    if (more == 0) continue;
    const bool elsewhere = words.empty() || now[i].part != part;
    if (!words.empty()) words += elsewhere ? "; " : ", ";
    part = now[i].part;
    words += elsewhere ? fmt::format("{}: {} {}", part, more, now[i].what) : fmt::format("{} {}", more, now[i].what);
  }
  return words;
}

}  // namespace

std::string_view emergency_class(std::uint16_t code) {
  for (const CodeClass& row : kClasses)
    if ((code & row.mask) == row.code) return row.text;
  return "of a class that no standard names";
}

std::vector<StationNews::Item> StationNews::counted(std::int64_t now_ns) {
  std::vector<Item> items;
  seen_.resize(bus_.station_count());
  devices::StationLook look;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    Seen& seen = seen_[i];
    if (!bus_.look(i, look) || look.looks == seen.counted_at || now_ns < seen.quiet_until_ns) continue;
    seen.counted_at = look.looks;
    const ErrorCounts now = bus_.error_counts(i);
    if (seen.known && std::ranges::equal(now, seen.told)) continue;
    const std::string words = seen.known ? growth(seen.told, now) : "";
    seen.told = now;
    seen.known = true;
    if (words.empty()) continue;
    seen.quiet_until_ns = now_ns + kQuiet_ns;
    items.push_back(
        {bus_.station(i).id, 0,
         Error{Fault::LinkErrors, fmt::format("{}: {}", info(Fault::LinkErrors).text, words), bus_.station(i).where}});
  }
  return items;
}

bool StationNews::mail() {
  seen_.resize(bus_.station_count());
  devices::StationLook look;
  bool any = false;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    // What was fetched shows only with the next look.
    if (!bus_.look(i, look) || !look.message_waiting || look.looks == seen_[i].fetched_at) continue;
    seen_[i].fetched_at = look.looks;
    any = true;
  }
  return any;
}

std::vector<StationNews::Item> StationNews::fetch() {
  std::vector<Item> items;
  for (const auto& [station, emergency] : bus_.take_emergencies())
    items.push_back({station, emergency.code, emergency_words(station, emergency)});
  return items;
}

Error StationNews::emergency_words(StationId station, const devices::Emergency& e) const {
  Error error{Fault::EmergencyMessage, "", ""};
  for (std::size_t i = 0; i < bus_.station_count(); ++i)
    if (bus_.station(i).id == station) error.where = bus_.station(i).where;
  std::string text;
  for (const config::Station& s : machine_.stations)
    if (s.id == station && s.profile.drive && e.code != 0)
      for (const auto& row : s.profile.drive->errors)
        if (row.code == e.code) text = devices::fault_text(s.profile, e.code).text;
  if (text.empty()) text = fmt::format("{} (code {:04X}h)", emergency_class(e.code), e.code);
  std::string data;
  for (const std::uint8_t byte : e.data) data += fmt::format(" {:02X}", byte);
  error.message = fmt::format("{}: {}; error register {:02X}h, data{}", info(Fault::EmergencyMessage).text, text,
                              e.error_register, data);
  return error;
}

}  // namespace gantry::stations
