// What stations tell of themselves while the machine works: emergency messages, and errors that they count on their
// links. The cycles look at one station in turn and show both; only an emergency is then fetched, by datagrams that
// ride in the loop's frames.
//   StationNews news(bus, machine);
//   each step: for (const auto& item : news.counted(now_ns)) ...   if (news.mail()) for (... : news.fetch()) ...
// Off the RT side.
#pragma once
#include <string>
#include <vector>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "devices/station_bus.hpp"

namespace gantry::stations {

class StationNews {
 public:
  struct Item {
    StationId station;
    std::int32_t detail = 0;  ///< the emergency's code
    Error words;
  };
  StationNews(devices::StationBus& bus, const config::Machine& machine) : bus_(bus), machine_(machine) {}

  /// Counters that have grown, by station at most every ten seconds.
  std::vector<Item> counted(std::int64_t now_ns);
  /// A mailbox holds something that nobody has asked for.
  [[nodiscard]] bool mail();
  /// Fetches it.
  std::vector<Item> fetch();

 private:
  struct Seen {
    bool known = false;
    devices::ErrorCounts told;  ///< as last told, or as they were at the beginning
    std::int64_t quiet_until_ns = 0;
    std::uint64_t counted_at = 0, fetched_at = 0;  ///< StationLook::looks
  };
  [[nodiscard]] Error emergency_words(StationId station, const devices::Emergency& emergency) const;

  devices::StationBus& bus_;
  const config::Machine& machine_;
  std::vector<Seen> seen_;  ///< by index of the bus
};

/// What an emergency code says by itself: its class (CiA 301, 7.2.7.1; A0xxh by ETG.1000.6, 5.6.4).
std::string_view emergency_class(std::uint16_t code);

}  // namespace gantry::stations
