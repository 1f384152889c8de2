// The 1 ms loop: commands and segments in, process image out and in, snapshots and events out. One tick is
//   commands -> interpolator, compensation, guard -> image -> exchange -> feedback -> supervision -> snapshot
// so that what a cycle's inputs show is answered in the very next frame. It owns nothing that waits: the pacer decides
// when, the bus how long.
//   Loop loop(setup, bus, nullptr, clock, channels);   pacer.shift(loop.tick(pacer.wait(clock)));
// RT: no allocation, no lock, no exception; bounded by the number of axes, drives and elapsed periods.
#pragma once
#include <bitset>
#include <cstdint>

#include "app/cycle/axes.hpp"
#include "app/cycle/channels.hpp"
#include "app/cycle/loop_setup.hpp"
#include "app/cycle/machine_state.hpp"
#include "app/cycle/pacer.hpp"
#include "app/cycle/stop_frame.hpp"
#include "app/cycle/supervisor.hpp"
#include "devices/bus.hpp"
#include "devices/rt/canopen_cyclic.hpp"
#include "devices/rt/dc_lock.hpp"
#include "motion/rt/compensation.hpp"
#include "motion/rt/guard.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::cycle {

class Loop {
 public:
  /// `can` may be null. `clock` is only read, for the loop's own times. `stop`: made ready in every cycle for those who
  /// watch this loop; null where nobody does.
  Loop(const LoopSetup& setup, devices::FieldBus& bus, devices::CanPort* can, Clock& clock, Channels& channels,
       StopFrame* stop = nullptr);

  /// One cycle. Returns by how much the coming cycles shall be shifted to stay locked to the bus's reference clock.
  Time tick(const Beat& beat) noexcept;
  [[nodiscard]] Time period() const noexcept { return setup_.period; }

 private:
  /// The next commanded values: what one tick of motion comes to.
  struct Commanded {
    motion::Setpoint setpoint;
    AxisVec target{};
    std::uint32_t outputs = 0;
  };

  void take_commands() noexcept;
  void obey(const Command& command) noexcept;
  [[nodiscard]] Fault refuse(const Command& command) const noexcept;
  [[nodiscard]] Fault refuse_walk(bool in_setup) const noexcept;
  [[nodiscard]] Fault interlock() const noexcept;
  void bound_walk() noexcept;
  void abort() noexcept;
  void hold() noexcept;
  void advance(const Beat& beat) noexcept;
  void step_motion() noexcept;
  void step_setpoint() noexcept;
  void brake_from(const AxisVec& before_last, const AxisVec& last) noexcept;
  [[nodiscard]] std::uint32_t output_word(CycleIndex cycle) const noexcept;
  void write_image(const Beat& beat) noexcept;
  void heed_watchdog() noexcept;
  void heed_silence() noexcept;
  [[nodiscard]] bool at_rest() const noexcept;
  [[nodiscard]] std::uint32_t held_by_last_word() const noexcept;
  void exchange(const Beat& beat, Time now) noexcept;
  /// Every frame of the last exchange came back.
  [[nodiscard]] bool answered() const noexcept {
    return exchange_.fault != Fault::FrameLost && exchange_.fault != Fault::BusDown;
  }
  [[nodiscard]] Time frame_deadline(Time due) const noexcept;
  void follow_progress() noexcept;
  void follow_probe() noexcept;
  void watch_approach() noexcept;
  void disarm(Fault why) noexcept;
  void follow_stop() noexcept;
  [[nodiscard]] bool latched_nearby() const noexcept;
  void give_up_torque() noexcept;
  void take_torque() noexcept;
  [[nodiscard]] bool brake_released() const noexcept;
  [[nodiscard]] bool brake_open() const noexcept;
  void finish_reset() noexcept;
  void watch_homing() noexcept;
  void tell_homing(const Axes::Homed& failed) noexcept;
  void finish_homing() noexcept;
  void finish_block() noexcept;
  void react(Fault fault, AxisId axis, std::int32_t detail, StationId station = kNoStation, double value = 0) noexcept;
  [[nodiscard]] bool explains(Fault fault) const noexcept;
  [[nodiscard]] Lamp lamp() const noexcept;
  void carry_out(const ReactionRow& reaction, Fault fault) noexcept;
  void hold_position() noexcept;
  /// The state that the table has for this cause, if it has one.
  void change(Cause cause) noexcept;
  [[nodiscard]] Cause rest() const noexcept;
  /// `axis`: whose fault it is, where it is one's.
  void answer(std::uint32_t id, Fault fault, AxisId axis = kNoAxis) noexcept;
  void answer_pending(Fault fault) noexcept;
  void tell(Event event) noexcept;
  void tell_not_braking(Fault fault, AxisId axis, double by, StationId station) noexcept;
  void tell_moving() noexcept;
  void follow_braking() noexcept;
  void follow_kept_torque() noexcept;
  void tell_snapshot(const Beat& beat, bool sent) noexcept;

  LoopSetup setup_;
  devices::FieldBus& bus_;
  devices::CanPort* can_;
  devices::CanopenCyclic can_cyclic_;
  Clock& clock_;
  Channels& channels_;
  StopFrame* stop_;

  Axes axes_;
  Supervisor supervisor_;
  motion::Interpolator interpolator_;
  motion::Compensation compensation_;
  devices::DcLock dc_lock_;

  State state_ = State::Offline;
  Commanded commanded_;
  AxisVec before_last_{};  ///< the target of the tick before commanded_
  devices::Exchange exchange_;
  int silent_ = 0;  ///< exchanges in a row that were not answered
  CycleIndex cycle_ = 0;
  Fault latched_ = Fault::None;
  CycleIndex latched_at_ = 0;
  Reaction reacted_ = Reaction::Note;  ///< the strongest since the first latch
  Event present_;                      ///< the worst latching fault that this cycle shows; None: it shows none
  bool aborting_ = false;              ///< Channels::stop_now, as this cycle found it
  std::uint32_t pending_ = 0, pending_disable_ = 0, pending_probe_ = 0,
                pending_reset_ = 0;     ///< ids of commands that take time
  Purpose purpose_ = Purpose::Job;      ///< of what plays
  std::uint32_t block_ = 0, tick_ = 0;  ///< what plays; kept until the last compensated tick is out
  motion::Limits walk_limits_;          ///< of a walk that plays: about where it began
  bool starves_ = false;                ///< it waits for motion that is not planned yet
  bool settled_ = true;                 ///< the compensation has let everything out
  bool shut_valve_ = false;             ///< this tick closes the valve, also in what is still on its way
  bool valve_cut_ = false;              ///< this tick closes it, and it was open
  bool hold_waits_ = false;             ///< a hold waits for the valve to shut as planned
  bool probing_ = false;                ///< the block's last segment waits for the probe
  bool probe_over_ = false;             ///< of this block: it has touched, or will not
  bool probe_told_ = false;
  Fault stopped_by_ = Fault::None;  ///< what ended the block that is braking
  int reset_ticks_ = 0, settle_ticks_ = 0;
  std::bitset<kMaxDrives> kept_torque_;  ///< told of these, or latched
  int stop_ticks_ = 0;                   ///< since the drives were asked to stop and to lose their torque
  bool taking_torque_ = false;           ///< the axes stand, and the brake is closing
  int brake_ticks_ = 0;
  int release_ticks_ = 0;  ///< for which the brake's output has been on
  double override_ = 1;
  std::uint32_t outputs_set_ = 0;  ///< output bits that commands have set
  std::uint32_t sent_outputs_ = 0, inputs_ = 0;
  Time compute_{}, bus_time_{};
  Snapshot snapshot_;
};

}  // namespace gantry::cycle
