// Brings back stations that have stopped taking part in the cycle or in operation, while the owner has nothing else to
// do. Their axes stay disabled: the operator resets, enables and homes.
//   Recovery recovery(bus);
//   each idle step: recovery.step(control);
// It looks every tenth of a second for as long as something is missing; a station that answers but refuses is asked
// more and more rarely, since every attempt writes its whole record. What keeps a station away is told once, not with
// every attempt.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "app/run/control.hpp"
#include "app/stations/repeated_notes.hpp"
#include "devices/station_bus.hpp"

namespace gantry::run {

class Recovery {
 public:
  explicit Recovery(devices::StationBus& bus) : bus_(bus) {}

  /// One idle step has passed. When something is missing, this one takes longer: `control` steps meanwhile, at most
  /// until one station has come back or has refused.
  void step(Control& control);
  /// Drives that have come back and had lost their supply, or were reset; once.
  [[nodiscard]] std::vector<StationId> take_restarted() { return std::exchange(restarted_, {}); }

 private:
  struct Away {
    bool seen = false;          ///< since all were there
    CycleIndex not_before = 0;  ///< of the next attempt
    double wait_s = 0;          ///< after the next refusal
    Fault told = Fault::None;
    CycleIndex told_at = 0;
  };
  void returned(std::size_t i, const devices::Recovered& back);
  void tell_all_back();
  /// What is to be said of it now; "": nothing.
  [[nodiscard]] std::string told(Fault fault, int of, std::string words);
  void failed(Away& away, const Error& why, const Control& control);

  devices::StationBus& bus_;
  std::vector<Away> away_;  ///< by index of the bus
  std::size_t next_ = 0;    ///< station of the round that runs
  std::vector<StationId> restarted_;
  stations::RepeatedNotes<std::string> notes_{1};  ///< a station that comes and goes does not fill the log
  std::int64_t now_ns_ = 0;
  CycleIndex whole_since_ = -1, short_since_ = -1;
};

}  // namespace gantry::run
