// Which stations a fault of the bus is about. The loop knows that not all take part or that not all are operational;
// the cycles that follow show who, and this waits for them: a few, one for each station.
//   Culprits culprits(bus);
//   culprits.ask(event);   each step: culprits.watch(snapshot);   while (auto known = culprits.next()) ...
// Off the RT side; it only reads what the cycles have brought and never waits itself.
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "app/cycle/channels.hpp"
#include "devices/station_bus.hpp"

namespace gantry::stations {

class Culprits {
 public:
  struct Known {
    cycle::Event event;
    std::string where;  ///< "station 3 'z', station 4 'cu'"; empty: it was over before it could be told who
    std::string what;   ///< "; station 3 'z' is in SAFE_OP: AL status code 001Bh, ..."
  };
  explicit Culprits(const devices::StationBus& bus) : bus_(bus) {}

  /// Faults that the loop tells without a station.
  static bool wanted(Fault fault) noexcept {
    return fault == Fault::TooFewTookPart || fault == Fault::StationSilent || fault == Fault::StationLeftOp;
  }
  void ask(const cycle::Event& event);
  void watch(const cycle::Snapshot& now);
  /// The oldest that is known by now.
  std::optional<Known> next();
  /// Something of this fault is still to come.
  [[nodiscard]] bool waiting(Fault fault) const;

 private:
  struct Asked {
    cycle::Event event;
    std::uint64_t since = 0;  ///< bus_.cycles()
    int steps = 0;            ///< so far: a loop that stands brings no more cycles
  };
  [[nodiscard]] std::uint64_t turn() const;
  [[nodiscard]] Known name(const cycle::Event& event) const;

  const devices::StationBus& bus_;
  std::deque<Asked> asked_;
  std::vector<std::uint64_t> missed_before_;  ///< Presence::missed while all was well
};

}  // namespace gantry::stations
