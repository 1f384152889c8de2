// What recovery and diagnosis need of any bus, beside its exchange (bus.hpp): its stations, whether they take part,
// what they say by themselves, and a station that went away brought back.
//   for (std::size_t i = 0; i < bus.station_count(); ++i) if (bus.presence(i, p) && !p.operational) ... bus.station(i)
//   if (auto back = bus.recover(i); back && *back) log((*back)->found);
// Working counter, AL states and clocks stay behind it (docs/decisions/015).
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "core/rt/fixed_vector.hpp"
#include "devices/bus.hpp"
#include "devices/rt/cyclic_counts.hpp"
#include "devices/rt/sender_watch.hpp"

namespace gantry::devices {

/// One station, as bring-up has found it.
struct BusStation {
  StationId id;
  const config::Station* config = nullptr;                          ///< null: the machine file does not know it
  std::string where;                                                ///< "station 3 'y1'": position from 0 and name
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;  ///< as its EEPROM says
  bool since_power_up = false;                                      ///< nobody has set it up since its supply came
  /// Why it must not have torque: what it holds is not what its rows ask for, or does not act yet. Found at every
  /// start.
  std::vector<Error> doubts;
  /// What it holds of its own limits where nothing pins them (config/held_limits.hpp).
  struct Held {
    config::ObjectAddress object;
    std::int64_t value = 0;
  };
  std::vector<Held> held;
};

/// How a station takes part in the cycles, as they have seen it.
struct Presence {
  std::uint64_t missed = 0;    ///< cycles in which it did not, although the bus answered
  std::uint64_t asked_at = 0;  ///< cycles() when its state was last seen; 0: it was not asked for
  bool operational = true;     ///< what it was then
};

/// One counter of errors that a station keeps. The texts live as long as the program.
struct ErrorCount {
  std::string_view part;  ///< "port 1"
  std::string_view what;  ///< "lost links"
  unsigned value = 0;
  bool operator==(const ErrorCount&) const = default;
};
using ErrorCounts = rt::FixedVector<ErrorCount, 16>;

/// What the cycles have seen of a station beside its process data.
struct StationLook {
  std::uint64_t looks = 0;       ///< how often it was looked at
  bool message_waiting = false;  ///< it has something to say that nobody has asked for
};

/// An emergency message (CiA 301, 7.2.7; over EtherCAT ETG.1000.6, 5.6.4).
struct Emergency {
  std::uint16_t code = 0;  ///< as in 603Fh
  std::uint8_t error_register = 0;
  std::array<std::uint8_t, 5> data{};
};

/// A station that takes part again.
struct Recovered {
  std::string found;       ///< in what state it was found: "in SAFE_OP: AL status code 001Bh, ..."
  bool restarted = false;  ///< it had lost its supply, or was reset
};

/// Blocking calls belong to the run thread; what says so may be called from any.
class StationBus : public FieldBus {
 public:
  [[nodiscard]] virtual std::size_t station_count() const noexcept = 0;
  /// In the order of the line. Valid until the next bring_up() or shut_down().
  [[nodiscard]] virtual const BusStation& station(std::size_t i) const noexcept = 0;
  /// What bring-up found worth reporting, and behind it after shut_down() what did not come to rest.
  [[nodiscard]] virtual const std::vector<std::string>& notes() const noexcept = 0;

  // What the cycles have seen; any thread.
  /// Exchanges since bring_up().
  [[nodiscard]] virtual std::uint64_t cycles() const noexcept = 0;
  /// False when it was not looked at yet.
  virtual bool presence(std::size_t i, Presence& out) const noexcept = 0;
  virtual bool look(std::size_t i, StationLook& out) const noexcept = 0;
  /// As of the last look.
  [[nodiscard]] virtual ErrorCounts error_counts(std::size_t i) const noexcept = 0;
  /// Its state as it was last seen: "in SAFE_OP: AL status code 001Bh, ...".
  [[nodiscard]] virtual std::string state_words(std::size_t i) const = 0;
  [[nodiscard]] virtual CyclicCounts counters() const noexcept = 0;
  /// Replies of mailboxes that were asked for once more, and requests that were sent again, since bring_up().
  [[nodiscard]] virtual std::uint64_t mailbox_repeats() const noexcept { return 0; }
  /// Another master whose frames came in, and how many of them the cycles have seen; nothing as long as there was none.
  [[nodiscard]] virtual std::optional<OtherMaster> other_master() const noexcept { return std::nullopt; }

  /// Whether bring_up() is to end, asked while it waits for stations: it fails with Fault::Interrupted then.
  virtual void heed(std::function<bool()> ends) = 0;
  /// In virtual time: what a blocking call does to let a cycle pass.
  virtual void step_by(std::function<void()> step) = 0;
  /// Looks for a station that does not take part, and brings it back while the loop goes on; nothing when it takes part
  /// already. Fault::StationMissing when it stays away; other faults are those of bring-up. Bounded.
  virtual Result<std::optional<Recovered>> recover(std::size_t i) = 0;
  /// Takes what stations have sent unasked since the last call; only those whose look() says so are asked.
  virtual std::vector<std::pair<StationId, Emergency>> take_emergencies() = 0;
  /// Objects that a profile has in the process image and a station does not: they are written and read beside it.
  [[nodiscard]] virtual bool has_slow_objects() const noexcept { return false; }
  /// What stations were given at bring-up is read once more, while their drives have torque: what differs becomes a
  /// doubt about its station. Blocking. Fault::MailboxTimeout ... when one does not answer.
  virtual Result<void> compare_parameters() { return {}; }
  /// What fell silent since the last call, or answers again: with station and object.
  virtual std::vector<std::string> serve_objects() { return {}; }
};

}  // namespace gantry::devices
