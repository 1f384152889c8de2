// One virtual station: its ESC and what stands behind it - the AL state machine, the mailbox, the process data, and
// either drives or the terminals of an I/O station.
//   station.power_on(now);
//   station.esc().write(...);  station.serve(now);         // after each frame: what the bus wants of the station
//   if (station.next_tick() <= now) { move(at); latch(at); <world> sample(); take(at); }   // its cycle
// AL status codes are those of ETG.1000.6 table 11 and ETG.1020; transitions take the time of sim/esc/timing.hpp. The
// code stands in station.cpp (power and cycle), station_states.cpp (AL state machine) and station_mailbox.cpp.
#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/drive/drive402.hpp"
#include "sim/esc/esc.hpp"
#include "sim/objects/coe_server.hpp"
#include "sim/objects/object_dictionary.hpp"
#include "sim/objects/pdo_map.hpp"
#include "sim/station/habits.hpp"

namespace gantry::sim {

/// Ticks of stations that lie closer are one instant of the machine (their clocks agree to less than 1 us).
inline constexpr Time kTogether = microseconds(20);

/// Cycle of a station without SYNC0.
inline constexpr Time kFreeRun = milliseconds(1);

/// What an axis of a station moves, and how its counter runs.
struct DriveWiring {
  Motor* motor = nullptr;
  double counts_per_unit = 1;
  bool invert = false;
};

class Station {
 public:
  /// `wiring`: one for each slot of the profile. Off until power_on(). `config` outlives the station.
  Station(const config::Station& config, std::uint32_t serial, std::vector<DriveWiring> wiring);

  void power_on(Time now);
  void power_off() noexcept;
  /// To follow with power_on(): forgets what a station keeps without power, too - its EEPROM, stored objects, motors.
  void renew() noexcept;
  [[nodiscard]] bool powered() const noexcept { return powered_; }

  void set_timing(const StationTiming& timing) noexcept;
  /// From its next power-on.
  void set_habits(const StationHabits& habits);
  /// At 0 an answer that is held back is there at once, too.
  void slow_mailbox(Time by) noexcept {
    habits_.mailbox_delay = by;
    if (by == Time{0} && mailbox_due_ != kNever) mailbox_due_ = Time{0};
  }

  Esc& esc() noexcept { return esc_; }
  ObjectDictionary& objects() noexcept { return objects_; }
  [[nodiscard]] Drive402* drive(int slot) const noexcept { return drives_[static_cast<std::size_t>(slot)].get(); }
  [[nodiscard]] devices::wire::AlState state() const noexcept { return state_; }

  /// Looks at what the bus has written. True: the route of the frames may change - the loop control of its ports was
  /// among it, or it is to restart.
  bool serve(Time now) noexcept;
  /// The bus has reset it (0040h): it wants to be without power for so long. Asked once.
  [[nodiscard]] std::optional<Time> take_restart() noexcept {
    return std::exchange(restart_, false) ? std::optional(timing_.restart) : std::nullopt;
  }
  /// Watchdog, and state changes that are due.
  void supervise(Time now) noexcept {
    if (esc_.watchdog_expires() <= now || request_.due <= now || mailbox_due_ <= now || operation_until_) do_due(now);
  }

  // Its cycle: SYNC0, or without it each ms.
  [[nodiscard]] Time next_tick() const noexcept {
    if (!powered_) return kNever;
    return sync0_runs() ? esc_.dc().next_sync0() : std::min(next_free_run_, esc_.dc().next_sync0());
  }
  [[nodiscard]] bool sync0_runs() const noexcept {
    return powered_ && esc_.dc().sync0_active() && esc_.dc().pulses() > 0;
  }
  void move(Time at) noexcept;   ///< motors run up to `at`
  void latch(Time at) noexcept;  ///< outputs take effect at the terminals
  void sample() noexcept;        ///< inputs and actual values go to the ESC
  void take(Time at) noexcept;   ///< drives take their commands; the next tick is scheduled

  [[nodiscard]] std::uint16_t io_outputs() const noexcept { return io_outputs_; }
  void set_io_inputs(std::uint16_t bits) noexcept { io_inputs_ = bits, io_inputs_told_ = true; }

 private:
  using AlState = devices::wire::AlState;

  void do_due(Time now) noexcept;
  void on_al_control(Time now) noexcept;
  void take_request(std::uint16_t control, Time now) noexcept;
  void show_state(std::uint16_t code) noexcept;
  void lock_sync_managers() noexcept;
  void change_state(AlState wanted, Time now);
  [[nodiscard]] std::uint16_t check_mailbox() const noexcept;
  [[nodiscard]] std::uint16_t check_layout() const noexcept;
  [[nodiscard]] std::uint16_t check_process_data() const noexcept;
  [[nodiscard]] std::uint16_t check_sync() const noexcept;
  void enter(AlState state) noexcept;
  void fail(AlState state, std::uint16_t code) noexcept;
  void try_operation(Time now) noexcept;
  void on_sync_managers_changed() noexcept;
  void on_mailbox(Time now) noexcept;
  void forget_mailbox() noexcept;
  void fill_mailbox(Time now) noexcept;
  void emergency(std::uint16_t error, std::uint16_t al_status_code, Time now) noexcept;
  void drop_outputs(bool orderly) noexcept;
  void latch_outputs() noexcept;
  [[nodiscard]] bool has_mailbox() const noexcept { return mailbox_out_ >= 0 && mailbox_in_ >= 0; }

  const config::Station& config_;
  const std::uint32_t serial_;
  StationHabits habits_;
  bool powered_ = false, restart_ = false;
  // The AL state machine, new with each power-on.
  AlState state_ = AlState::Init;
  bool error_ = false;
  bool identification_ = false;  ///< 0134h shows the device's identification instead of a code
  bool outputs_new_ = false;     ///< written since the last tick
  /// What 0120h asks for and when the station is done with it.
  struct Request {
    std::uint16_t control = 0;
    Time due = kNever;
  };
  Request request_;
  std::optional<Time> operation_until_;  ///< OP was asked for and waits this long for outputs and SYNC0
  Time last_tick_{}, next_free_run_{};
  std::int64_t in_op_ = 0;  ///< cycles
  int missed_outputs_ = 0;  ///< error counter of ETG.1020, 10F1h:2
  std::uint16_t io_outputs_ = 0, io_inputs_ = 0;
  bool io_inputs_told_ = false;  ///< the terminals are wired: they, not the dictionary, say what comes in
  int mailbox_out_ = -1, mailbox_in_ = -1, process_out_ = -1, process_in_ = -1;  ///< SyncManagers; -1: none
  Esc esc_;

  std::vector<DriveWiring> wiring_;
  std::vector<config::SyncManagerRow> rows_;  ///< by SyncManager
  StationTiming timing_;
  Kept kept_;  ///< objects in the drive's own memory
  ObjectDictionary objects_;
  Object* error_register_;     ///< 1001h
  const Object* missed_most_;  ///< 10F1h:2: how far missed outputs may count up; 0: not watched (ETG.1020)
  // New with each power-on, too.
  std::unique_ptr<CoeServer> coe_;
  std::vector<std::unique_ptr<Drive402>> drives_;
  PdoMap rx_, tx_;
  Time mailbox_due_ = kNever;      ///< when an answer is there that takes its time
  CoeServer::Bytes last_mailbox_;  ///< for the repeat request
};

}  // namespace gantry::sim
