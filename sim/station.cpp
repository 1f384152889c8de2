#include "sim/station.hpp"

#include <algorithm>
#include <cstring>

#include "sim/sii_image.hpp"

namespace gantry::sim {

using namespace devices::wire;
using config::SyncManagerKind;

namespace {

constexpr Time kFreeRun = milliseconds(1);           // cycle of a station without SYNC0
constexpr Time kOperationWait = milliseconds(1000);  // bound of SAFE_OP to OP (assumed)
constexpr int kMissedStep = 3;                       // ETG.1020: +3 for a missed SM event, -1 for a good one

// AL status codes
constexpr std::uint16_t kInvalidChange = 0x0011, kUnknownState = 0x0012, kNoBootstrap = 0x0013, kMailboxConfig = 0x0016,
                        kSyncError = 0x001A, kSmWatchdog = 0x001B, kOutputConfig = 0x001D, kInputConfig = 0x001E,
                        kFatalSync = 0x002C, kNoSync = 0x002D, kSyncConfig = 0x0030, kSync0Cycle = 0x0036;

bool is_state(unsigned value) noexcept { return value == 1 || value == 2 || value == 3 || value == 4 || value == 8; }

}  // namespace

Station::Station(const config::Station& config, std::uint32_t serial, std::vector<DriveWiring> wiring)
    : config_(config),
      serial_(serial),
      wiring_(std::move(wiring)),
      rows_(sync_managers(config.profile)),
      esc_(sii_image(config.profile, config.alias, serial), config.profile.dc),
      drives_(wiring_.size()) {
  for (int i = 0; i < static_cast<int>(rows_.size()); ++i) switch (rows_[static_cast<std::size_t>(i)].kind) {
      case SyncManagerKind::MailboxOut: mailbox_out_ = i; break;
      case SyncManagerKind::MailboxIn: mailbox_in_ = i; break;
      case SyncManagerKind::ProcessOut: process_out_ = i; break;
      case SyncManagerKind::ProcessIn: process_in_ = i; break;
    }
}

void Station::power_on(Time now) {
  powered_ = true;
  for (auto& drive : drives_) drive.reset();
  objects_ = std::make_unique<ObjectDictionary>(config_.profile, serial_);
  coe_ =
      std::make_unique<CoeServer>(*objects_, has_mailbox() ? rows_[static_cast<std::size_t>(mailbox_in_)].length : 0);
  for (std::size_t slot = 0; slot < wiring_.size(); ++slot)
    drives_[slot] = std::make_unique<Drive402>(*objects_, static_cast<int>(slot), *wiring_[slot].motor,
                                               wiring_[slot].counts_per_unit, wiring_[slot].invert);
  rx_ = tx_ = PdoMap{};
  state_ = AlState::Init, error_ = false;
  operation_until_.reset();
  last_mailbox_.clear();
  outputs_new_ = false, missed_outputs_ = 0;
  io_outputs_ = 0;
  esc_.power_on(now);
  last_tick_ = now;
  next_free_run_ = (now / kFreeRun + 1) * kFreeRun;
}

void Station::power_off() noexcept {
  powered_ = false;
  io_outputs_ = 0;
  state_ = AlState::Init;
  for (const auto& w : wiring_) w.motor->restore(w.motor->position());  // it stops where it is
}

// --- AL state machine
// -------------------------------------------------------------------------------------------------

void Station::serve(Time now) noexcept {
  const std::uint32_t events = esc_.take_events();
  if (events == 0) return;
  if ((events & Esc::kOutputsWritten) != 0) {
    outputs_new_ = true;
    if (!sync0_runs()) latch_outputs();
  }
  if ((events & Esc::kSyncManagersChanged) != 0) on_sync_managers_changed();
  if ((events & Esc::kSync0Changed) != 0 && !esc_.dc().sync0_active()) {
    next_free_run_ = (now / kFreeRun + 1) * kFreeRun;
    if (state_ == AlState::Op) fail(AlState::SafeOp, kFatalSync);
  }
  if ((events & Esc::kAlControl) != 0) on_al_control(now);
  if ((events & (Esc::kMailboxWritten | Esc::kMailboxRead | Esc::kMailboxRepeat)) != 0) on_mailbox();
  if (operation_until_) try_operation(now);
}

void Station::on_al_control(Time now) noexcept {
  const std::uint16_t control = esc_.al_control();
  const unsigned wanted = control & kAlStateMask;
  const bool acknowledged = (control & kAlError) != 0;
  // An error stands until it is acknowledged; without that only the way down is open.
  if (error_ && !acknowledged && wanted >= static_cast<unsigned>(state_)) return;
  operation_until_.reset();
  if (!is_state(wanted)) return fail(state_, kUnknownState);
  change_state(static_cast<AlState>(wanted), now);
}

void Station::change_state(AlState wanted, Time now) {
  if (wanted == AlState::Boot) return fail(state_, kNoBootstrap);
  if (wanted <= state_) return enter(wanted);
  std::uint16_t code = kInvalidChange;
  if (state_ == AlState::Init && wanted == AlState::PreOp) code = check_mailbox();
  if (state_ == AlState::PreOp && wanted == AlState::SafeOp) {
    rx_ = PdoMap::build(*objects_, PdoDirection::Rx);
    tx_ = PdoMap::build(*objects_, PdoDirection::Tx);
    code = check_process_data();
    if (code == 0) code = check_sync();
  }
  if (state_ == AlState::SafeOp && wanted == AlState::Op) {
    code = check_sync();
    if (code == 0 && esc_.dc().sync0_active() && esc_.dc().next_sync0() == kNever) code = kNoSync;
    if (code == 0) {
      operation_until_ = now + kOperationWait;
      if (error_) enter(AlState::SafeOp);
      return try_operation(now);
    }
  }
  if (code != 0) return fail(state_, code);
  enter(wanted);
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
  fail(AlState::SafeOp, outputs ? kNoSync : kSmWatchdog);
}

void Station::enter(AlState state) noexcept {
  if (state_ == AlState::Op && state != AlState::Op) drop_outputs(true);
  if (state == AlState::SafeOp && state_ != AlState::SafeOp) esc_.stop_watchdog();  // outputs count from here on
  if (state == AlState::Init) coe_->reset();
  state_ = state;
  error_ = false;
  missed_outputs_ = 0;
  esc_.set_al_status(static_cast<std::uint16_t>(state), 0);
  if (state == AlState::SafeOp || state == AlState::Op) sample();
}

void Station::fail(AlState state, std::uint16_t code) noexcept {
  if (state_ == AlState::Op && state != AlState::Op) drop_outputs(false);
  operation_until_.reset();
  state_ = state;
  error_ = true;
  esc_.set_al_status(static_cast<std::uint16_t>(static_cast<std::uint16_t>(state) | kAlError), code);
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
      return kMailboxConfig;
  }
  return 0;
}

std::uint16_t Station::check_process_data() const noexcept {
  const auto fits = [&](int i, std::size_t bytes, std::uint8_t direction) {
    if (i < 0) return bytes == 0;
    const auto& sm = esc_.sync_manager(i);
    if (bytes == 0) return !esc_.sync_manager_active(i) || sm.length == 0;
    return esc_.sync_manager_active(i) && sm.length == bytes && sm.start == rows_[static_cast<std::size_t>(i)].start &&
           (sm.control & 0x0F) == direction;
  };
  if (!fits(process_out_, rx_.bytes(), kSmEcatWrites)) return kOutputConfig;
  if (!fits(process_in_, tx_.bytes(), 0)) return kInputConfig;
  return 0;
}

std::uint16_t Station::check_sync() const noexcept {
  const DcUnit& dc = esc_.dc();
  if (!dc.sync0_active() || !config_.profile.drive) return 0;
  if (dc.sync0_cycle_ns() == 0) return kSyncConfig;
  const auto& cycles = config_.profile.drive->cycle_times_us;
  const bool known = cycles.empty() || std::any_of(cycles.begin(), cycles.end(), [&](std::uint32_t us) {
                       return us * 1000ull == dc.sync0_cycle_ns();
                     });
  return known ? 0 : kSync0Cycle;
}

void Station::on_sync_managers_changed() noexcept {
  if (state_ >= AlState::SafeOp && check_process_data() != 0) fail(AlState::PreOp, check_process_data());
  if (state_ >= AlState::PreOp && check_mailbox() != 0) fail(AlState::Init, kMailboxConfig);
}

void Station::supervise(Time now) noexcept {
  if (esc_.watchdog_expires() <= now) {
    esc_.expire_watchdog();
    if (state_ == AlState::Op) fail(AlState::SafeOp, kSmWatchdog);
  }
  if (operation_until_) try_operation(now);
}

void Station::drop_outputs(bool orderly) noexcept {
  io_outputs_ = 0;
  for (auto& drive : drives_) drive->outputs_lost(orderly);
}

// --- Mailbox
// ----------------------------------------------------------------------------------------------------------

void Station::on_mailbox() noexcept {
  if (!has_mailbox() || state_ == AlState::Init) return;
  const auto& in = esc_.sync_manager(mailbox_in_);
  if (((in.activate ^ in.pdi_control) & kSmActivateRepeatRequest) != 0) {
    // The last message again, whatever the mailbox holds now (ETG.1000.4, 6.7.1).
    const auto area = esc_.area(mailbox_in_);
    if (!last_mailbox_.empty() && area.size() >= last_mailbox_.size()) {
      std::copy(last_mailbox_.begin(), last_mailbox_.end(), area.begin());
      esc_.set_mailbox_full(mailbox_in_, true);
    }
    esc_.acknowledge_repeat(mailbox_in_);
  }
  if (esc_.mailbox_full(mailbox_out_)) {
    coe_->take(esc_.area(mailbox_out_), state_ == AlState::PreOp);
    esc_.set_mailbox_full(mailbox_out_, false);
  }
  fill_mailbox();
}

void Station::fill_mailbox() noexcept {
  if (!has_mailbox() || state_ == AlState::Init || !coe_->waiting() || esc_.mailbox_full(mailbox_in_)) return;
  const auto area = esc_.area(mailbox_in_);
  last_mailbox_ = coe_->next();
  if (area.size() < last_mailbox_.size()) return;
  std::copy(last_mailbox_.begin(), last_mailbox_.end(), area.begin());
  esc_.set_mailbox_full(mailbox_in_, true);
}

// --- Cycle
// ------------------------------------------------------------------------------------------------------------

Time Station::next_tick() const noexcept {
  if (!powered_) return kNever;
  return sync0_runs() ? esc_.dc().next_sync0() : std::min(next_free_run_, esc_.dc().next_sync0());
}

void Station::move(Time at) noexcept {
  if (at <= last_tick_) return;
  const double dt_s = seconds(at - last_tick_);
  last_tick_ = at;
  for (auto& drive : drives_) drive->advance(dt_s);
}

void Station::latch(Time at) noexcept {
  if (esc_.dc().next_sync0() <= at + kTogether) esc_.dc().pulse();
  next_free_run_ = (at / kFreeRun + 1) * kFreeRun;
  latch_outputs();
  if (state_ != AlState::Op || !sync0_runs()) return;
  // ETG.1020, 10F1h:2: how far missed outputs may count up; 0: not watched.
  const auto limit = objects_->value({0x10F1, 2});
  missed_outputs_ = outputs_new_ ? std::max(missed_outputs_ - 1, 0) : missed_outputs_ + kMissedStep;
  outputs_new_ = false;
  if (limit > 0 && missed_outputs_ > limit) fail(AlState::SafeOp, kSyncError);
}

void Station::latch_outputs() noexcept {
  if (state_ != AlState::Op || process_out_ < 0 || !drives_.empty()) return;
  const auto image = esc_.area(process_out_);
  if (image.size() < rx_.bytes()) return;
  rx_.unpack(image);
  std::uint16_t bits = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(image.size(), 2); ++i)
    bits = static_cast<std::uint16_t>(bits | std::to_integer<unsigned>(image[i]) << (8 * i));
  io_outputs_ = bits;
}

void Station::sample() noexcept {
  for (auto& drive : drives_) drive->sample();
  if (state_ < AlState::SafeOp || process_in_ < 0) return;
  const auto image = esc_.area(process_in_);
  if (image.size() < tx_.bytes()) return;
  if (drives_.empty()) {
    for (std::size_t i = 0; i < std::min<std::size_t>(image.size(), 2); ++i)
      image[i] = static_cast<std::byte>(io_inputs_ >> (8 * i) & 0xFF);
    tx_.unpack(image);
  } else {
    tx_.pack(image);
  }
}

void Station::take(Time at) noexcept {
  if (state_ == AlState::Op && process_out_ >= 0) {
    const auto image = esc_.area(process_out_);
    if (image.size() >= rx_.bytes()) rx_.unpack(image);
  }
  const double cycle_s =
      sync0_runs() && esc_.dc().sync0_cycle_ns() > 0 ? 1e-9 * esc_.dc().sync0_cycle_ns() : seconds(kFreeRun);
  bool any_fault = false;
  for (auto& drive : drives_) {
    drive->take(cycle_s, state_ >= AlState::PreOp);
    if (const auto code = drive->take_emergency(); code && has_mailbox()) coe_->emergency(*code, 1);
    any_fault |= drive->faulted();
  }
  if (!drives_.empty())
    if (Object* error_register = objects_->find({0x1001, 0})) error_register->value = any_fault ? 1 : 0;
  fill_mailbox();
  supervise(at);
}

}  // namespace gantry::sim
