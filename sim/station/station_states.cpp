// Station: the AL state machine (ETG.1000.6, 5.3; ETG.1020).
#include <algorithm>
#include <array>

#include "sim/station/al_codes.hpp"
#include "sim/station/station.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr std::uint16_t kAlIdentification = 0x0020;  // AL control and status, bit 5

bool is_state(unsigned value) noexcept { return value == 1 || value == 2 || value == 3 || value == 4 || value == 8; }

}  // namespace

bool Station::serve(Time now) noexcept {
  const std::uint32_t events = esc_.take_events();
  if (events == 0) return false;
  if ((events & Esc::kFrameEnds) != 0 && esc_.end_frame()) return restart_ = true;
  if ((events & Esc::kOutputsWritten) != 0) {
    outputs_new_ = true;
    if (!sync0_runs()) latch_outputs();
  }
  // A master that asks for INIT clears the SyncManagers right behind: the state it asked for is what they are judged
  // by.
  if ((events & Esc::kSyncManagersChanged) != 0 && (events & Esc::kAlControl) == 0 && request_.due == kNever)
    on_sync_managers_changed();
  if ((events & Esc::kSync0Changed) != 0 && !esc_.dc().sync0_active()) {
    next_free_run_ = (now / kFreeRun + 1) * kFreeRun;
    if (state_ == AlState::Op) fail(AlState::SafeOp, al_code::kFatalSync);
  }
  if ((events & Esc::kAlControl) != 0) on_al_control(now);
  if ((events & (Esc::kMailboxWritten | Esc::kMailboxRead | Esc::kMailboxRepeat)) != 0) on_mailbox(now);
  if (operation_until_) try_operation(now);
  return (events & Esc::kPortsChanged) != 0;
}

void Station::on_al_control(Time now) noexcept {
  const std::uint16_t control = esc_.al_control();
  const unsigned wanted = control & kAlStateMask;
  // The identification is asked for on the side and takes no state change (ETG.1020, explicit device identification).
  identification_ = (control & kAlIdentification) != 0 && !error_;
  if (wanted == static_cast<unsigned>(state_)) {  // no change, or the acknowledgement of an error: done at once
    request_ = {};
    if (error_ || operation_until_) return take_request(control, now);
    return show_state(0);
  }
  if (error_ && (control & kAlError) != 0) {  // the acknowledgement is heard at once, the change takes its time
    error_ = false;
    show_state(0);
  }
  request_ = {control, now + (wanted > static_cast<unsigned>(state_) ? timing_.al_up : timing_.al_down)};
  if (request_.due <= now) supervise(now);
}

void Station::take_request(std::uint16_t control, Time now) noexcept {
  const unsigned wanted = control & kAlStateMask;
  const bool acknowledged = (control & kAlError) != 0;
  // An error stands until it is acknowledged; without that only the way down is open.
  if (error_ && !acknowledged && wanted >= static_cast<unsigned>(state_)) return;
  operation_until_.reset();
  if (!is_state(wanted)) return fail(state_, al_code::kUnknownState);
  change_state(static_cast<AlState>(wanted), now);
}

void Station::show_state(std::uint16_t code) noexcept {
  auto status = static_cast<std::uint16_t>(state_);
  if (error_) status |= kAlError;
  // What stands on the device's selector (assumed: the alias, which the drives' rotary or DIP switches set).
  if (identification_) {
    status |= kAlIdentification;
    code = config_.alias;
  }
  esc_.set_al_status(status | habits_.al_bits, code);
}

/// A SyncManager that a state does not use is closed to the bus (as stations with their own firmware do).
void Station::lock_sync_managers() noexcept {
  for (int i = 0; i < Esc::kSyncManagers; ++i) {
    const bool mailbox = i == mailbox_out_ || i == mailbox_in_;
    esc_.lock_sync_manager(i, mailbox ? state_ == AlState::Init : state_ < AlState::SafeOp);
  }
}

void Station::change_state(AlState wanted, Time now) {
  // BOOT lies behind INIT alone: from elsewhere that step does not exist, for stations that could do it, too.
  if (wanted == AlState::Boot)
    return fail(state_, state_ == AlState::Init ? al_code::kNoBootstrap : al_code::kInvalidChange);
  if (wanted <= state_) return enter(wanted);
  if (habits_.refuses && habits_.refuses->state == wanted) return fail(state_, habits_.refuses->code);
  std::uint16_t code = al_code::kInvalidChange;
  if (state_ == AlState::Init && wanted == AlState::PreOp) {
    code =
        esc_.sii_loaded() && (!habits_.needs_eeprom || esc_.sii_is_stations()) ? check_mailbox() : al_code::kSiiError;
  }
  if (state_ == AlState::PreOp && wanted == AlState::SafeOp) {
    rx_ = PdoMap::build(objects_, PdoDirection::Rx);
    tx_ = PdoMap::build(objects_, PdoDirection::Tx);
    code = check_process_data();
    if (code == 0) code = check_layout();
    if (code == 0) code = check_sync();
    if (code != 0) emergency(0xA000, code, now);
  }
  if (state_ == AlState::SafeOp && wanted == AlState::Op) {
    code = check_sync();
    if (code == 0 && esc_.dc().sync0_active() && esc_.dc().next_sync0() == kNever) code = al_code::kNoSync;
    if (code == 0) {
      operation_until_ = now + timing_.al_up_max;
      if (error_) enter(AlState::SafeOp);
      return try_operation(now);
    }
    emergency(0xA001, code, now);
  }
  if (code != 0) return fail(state_, code);
  enter(wanted);
}

/// ETG.1000.6, 5.6.4: a state change that failed; the code follows as diagnostic data.
void Station::emergency(std::uint16_t error, std::uint16_t al_status_code, Time now) noexcept {
  if (!has_mailbox()) return;
  coe_->emergency(error, static_cast<std::uint8_t>(objects_.value({0x1001, 0})), al_status_code);
  fill_mailbox(now);
}

void Station::try_operation(Time now) noexcept {
  const bool outputs = rx_.bytes() == 0 || esc_.outputs_written_at() != kNever;
  const bool sync = !esc_.dc().sync0_active() || esc_.dc().pulses() > 0;
  if (outputs && sync) {
    operation_until_.reset();
    return enter(AlState::Op);
  }
  if (now < *operation_until_) return;
  operation_until_.reset();
  const auto code = outputs ? al_code::kNoSync : al_code::kSmWatchdog;
  emergency(0xA001, code, now);
  fail(AlState::SafeOp, code);
}

void Station::enter(AlState state) noexcept {
  if (state_ == AlState::Op && state != AlState::Op) drop_outputs(true);
  if (state == AlState::SafeOp && state_ != AlState::SafeOp) esc_.stop_watchdog();  // outputs count from here on
  if (state == AlState::Init) forget_mailbox();
  state_ = state;
  error_ = false;
  missed_outputs_ = 0;
  lock_sync_managers();
  show_state(0);
  if (state == AlState::SafeOp || state == AlState::Op) sample();
}

void Station::fail(AlState state, std::uint16_t code) noexcept {
  if (state_ == AlState::Op && state != AlState::Op) drop_outputs(false);
  operation_until_.reset();
  request_ = {};
  state_ = state;
  error_ = true;
  identification_ = false;
  lock_sync_managers();
  show_state(code);
}

std::uint16_t Station::check_mailbox() const noexcept {
  if (!has_mailbox()) return 0;
  for (const int i : {mailbox_out_, mailbox_in_}) {
    const auto& row = rows_[static_cast<std::size_t>(i)];
    const auto& sm = esc_.sync_manager(i);
    const std::uint8_t expected = i == mailbox_out_ ? kSmControlMailboxOut : kSmControlMailboxIn;
    constexpr std::uint8_t kModeAndDirection = 0x0F;
    if (!esc_.sync_manager_active(i) || sm.start != row.start || sm.length != row.length ||
        (sm.control & kModeAndDirection) != (expected & kModeAndDirection))
      return al_code::kMailboxConfig;
  }
  return 0;
}

std::uint16_t Station::check_process_data() const noexcept {
  if (!rx_.complete()) return al_code::kOutputMapping;
  if (!tx_.complete()) return al_code::kInputMapping;
  const auto fits = [&](int i, std::size_t bytes, std::uint8_t direction) {
    if (i < 0) return bytes == 0;
    const auto& sm = esc_.sync_manager(i);
    if (bytes == 0) return !esc_.sync_manager_active(i) || sm.length == 0;
    return esc_.sync_manager_active(i) && sm.length == bytes && sm.start == rows_[static_cast<std::size_t>(i)].start &&
           (sm.control & 0x0F) == direction;
  };
  if (!fits(process_out_, rx_.bytes(), kSmEcatWrites)) return al_code::kOutputConfig;
  if (!fits(process_in_, tx_.bytes(), 0)) return al_code::kInputConfig;
  return 0;
}

/// ETG.1020: SyncManagers that the station does not have, and areas that lie over each other. Process data takes three
/// buffers (ESC data sheet I, 8.1).
std::uint16_t Station::check_layout() const noexcept {
  struct Extent {
    std::size_t from, to;
  };
  std::array<Extent, Esc::kSyncManagers> used{};
  std::size_t count = 0;
  for (int i = 0; i < Esc::kSyncManagers; ++i) {
    const auto& sm = esc_.sync_manager(i);
    if (!esc_.sync_manager_active(i) || sm.length == 0) continue;
    if (i >= static_cast<int>(rows_.size())) return al_code::kSyncManagerConfig;
    const bool buffered = (sm.control & 0x03) != kSmMailboxMode && sm.start >= reg::kProcessRam;
    used[count++] = {sm.start, sm.start + (buffered ? 3u : 1u) * std::size_t{sm.length}};
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (used[i].to > Esc::kMemoryBytes) return al_code::kSyncManagerConfig;
    for (std::size_t k = 0; k < i; ++k)
      if (used[i].from < used[k].to && used[k].from < used[i].to) return al_code::kSyncManagerConfig;
  }
  return 0;
}

std::uint16_t Station::check_sync() const noexcept {
  const DcUnit& dc = esc_.dc();
  if (dc.sync1_without_sync0()) return al_code::kSyncConfig;
  if (habits_.clock && esc_.clock_activation() != habits_.clock->activate) return al_code::kSyncConfig;
  if (!dc.sync0_active() || !config_.profile.drive) return 0;
  if (dc.sync0_cycle_ns() == 0) return al_code::kSyncConfig;
  const auto& cycles = config_.profile.drive->cycle_times_us;
  const bool known = cycles.empty() || std::any_of(cycles.begin(), cycles.end(), [&](std::uint32_t us) {
                       return us * 1000ull == dc.sync0_cycle_ns();
                     });
  return known ? 0 : al_code::kSync0Cycle;
}

void Station::on_sync_managers_changed() noexcept {
  if (state_ >= AlState::SafeOp && check_process_data() != 0) fail(AlState::PreOp, check_process_data());
  if (state_ >= AlState::PreOp && check_mailbox() != 0) fail(AlState::Init, al_code::kMailboxConfig);
}

void Station::do_due(Time now) noexcept {
  if (esc_.watchdog_expires() <= now) {
    esc_.expire_watchdog();
    if (state_ == AlState::Op) fail(AlState::SafeOp, al_code::kSmWatchdog);
  }
  if (request_.due <= now) {
    const std::uint16_t control = request_.control;
    request_ = {};
    take_request(control, now);
    if (!error_) on_sync_managers_changed();
  }
  if (mailbox_due_ <= now) fill_mailbox(now);
  if (operation_until_) try_operation(now);
}

void Station::drop_outputs(bool orderly) noexcept {
  io_outputs_ = 0;
  if (drives_.empty()) rx_.clear();  // the safe state of a terminal: off
  for (auto& drive : drives_) drive->outputs_lost(orderly);
}

}  // namespace gantry::sim
