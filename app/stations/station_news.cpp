#include "app/stations/station_news.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "devices/profiles/fault_text.hpp"

namespace gantry::stations {
namespace {

using devices::ErrorCounters;

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
class Growth {
 public:
  void port(std::size_t number) { port_ = fmt::format("port {}: ", number); }
  void inside() { port_ = "inside: "; }
  void add(unsigned before, unsigned now, std::string_view what) {
    const unsigned more = now >= before ? now - before : now;
    if (more == 0) return;
    const char* const between = words_.empty() ? "" : port_.empty() ? ", " : "; ";
    words_ += fmt::format("{}{}{} {}", between, port_, more, what);
    port_.clear();
  }
  [[nodiscard]] const std::string& words() const { return words_; }

 private:
  std::string port_, words_;
};

/// Without the errors that it has only passed on: the station where they came in tells them.
std::string growth(const ErrorCounters& before, const ErrorCounters& now) {
  Growth g;
  for (std::size_t p = 0; p < now.ports.size(); ++p) {
    const ErrorCounters::Port &a = before.ports[p], &b = now.ports[p];
    g.port(p);
    g.add(a.invalid_frames, b.invalid_frames, "frames with a wrong checksum");
    g.add(a.rx_errors, b.rx_errors, "wrong symbols");
    g.add(a.lost_links, b.lost_links, "lost links");
  }
  g.inside();
  g.add(before.processing_unit, now.processing_unit, "frames that are no EtherCAT");
  g.add(before.pdi, now.pdi, "errors towards its own processor");
  return g.words();
}

}  // namespace

std::string_view emergency_class(std::uint16_t code) {
  for (const CodeClass& row : kClasses)
    if ((code & row.mask) == row.code) return row.text;
  return "of a class that no standard names";
}

std::vector<StationNews::Item> StationNews::counted(std::int64_t now_ns) {
  std::vector<Item> items;
  const auto& stations = bus_.stations();
  seen_.resize(stations.size());
  devices::StationHealth health;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    Seen& seen = seen_[i];
    if (!bus_.health(i, health) || health.looks == seen.counted_at || now_ns < seen.quiet_until_ns) continue;
    seen.counted_at = health.looks;
    const ErrorCounters now = devices::decode_error_counters(health.errors);
    if (seen.known && now == seen.told) continue;
    const std::string words = seen.known ? growth(seen.told, now) : "";
    seen.told = now;
    seen.known = true;
    if (words.empty()) continue;
    seen.quiet_until_ns = now_ns + kQuiet_ns;
    items.push_back(
        {stations[i].id, 0,
         Error{Fault::LinkErrors, fmt::format("{}: {}", info(Fault::LinkErrors).text, words), stations[i].where}});
  }
  return items;
}

bool StationNews::mail() {
  const auto& stations = bus_.stations();
  seen_.resize(stations.size());
  devices::StationHealth health;
  bool any = false;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    // What was fetched shows only with the next look.
    if (!bus_.health(i, health) || !health.mailbox_waiting || health.looks == seen_[i].fetched_at) continue;
    seen_[i].fetched_at = health.looks;
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
  for (const devices::StationRecord& s : bus_.stations())
    if (s.id == station) error.where = s.where;
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
