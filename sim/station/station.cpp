#include "sim/station/station.hpp"

#include <algorithm>
#include <cstring>

#include "sim/objects/sii_image.hpp"
#include "sim/station/al_codes.hpp"

namespace gantry::sim {

using namespace devices::wire;
using config::SyncManagerKind;

namespace {

constexpr int kMissedStep = 3;  // ETG.1020: +3 for a missed SM event, -1 for a good one

ClockWidth clock_of(const config::StationProfile& profile) noexcept {
  if (!profile.dc) return ClockWidth::None;
  return profile.clock_bits == 32 ? ClockWidth::Bits32 : ClockWidth::Bits64;
}

}  // namespace

Station::Station(const config::Station& config, std::uint32_t serial, std::vector<DriveWiring> wiring)
    : config_(config),
      serial_(serial),
      esc_(sii_image(config.profile, config.alias, serial), clock_of(config.profile)),
      wiring_(std::move(wiring)),
      rows_(sync_managers(config.profile)),
      objects_(config.profile, serial, &kept_),
      error_register_(objects_.find({0x1001, 0})),
      missed_most_(objects_.find({0x10F1, 2})),
      drives_(wiring_.size()) {
  for (int i = 0; i < static_cast<int>(rows_.size()); ++i) switch (rows_[static_cast<std::size_t>(i)].kind) {
      case SyncManagerKind::MailboxOut: mailbox_out_ = i; break;
      case SyncManagerKind::MailboxIn: mailbox_in_ = i; break;
      case SyncManagerKind::ProcessOut: process_out_ = i; break;
      case SyncManagerKind::ProcessIn: process_in_ = i; break;
    }
}

void Station::power_on(Time now) {
  powered_ = true, restart_ = false;
  for (auto& drive : drives_) drive.reset();
  objects_.power_on();
  coe_ = std::make_unique<CoeServer>(objects_, has_mailbox() ? rows_[static_cast<std::size_t>(mailbox_in_)].length : 0);
  for (std::size_t slot = 0; slot < wiring_.size(); ++slot)
    drives_[slot] = std::make_unique<Drive402>(objects_, static_cast<int>(slot), *wiring_[slot].motor,
                                               wiring_[slot].counts_per_unit, wiring_[slot].invert);
  for (const auto& drive : drives_) drive->tell(habits_.lies);
  coe_->set_manner(habits_.abort_command, !habits_.no_information);
  coe_->set_lies(habits_.mailbox);
  if (habits_.ignores) objects_.ignore_writes(habits_.ignores);
  mailbox_due_ = kNever;
  rx_ = tx_ = PdoMap{};
  state_ = AlState::Init, error_ = identification_ = false;
  request_ = {};
  operation_until_.reset();
  last_mailbox_.clear();
  outputs_new_ = false, missed_outputs_ = 0;
  in_op_ = 0;
  io_outputs_ = 0;
  esc_.power_on(now);
  lock_sync_managers();
  last_tick_ = now;
  next_free_run_ = (now / kFreeRun + 1) * kFreeRun;
}

void Station::renew() noexcept {
  kept_.clear();
  io_inputs_ = 0, io_inputs_told_ = false;
  for (const auto& w : wiring_) w.motor->renew();
  esc_.renew();
}

void Station::set_timing(const StationTiming& timing) noexcept {
  timing_ = timing;
  esc_.set_timing(timing);
}

void Station::set_habits(const StationHabits& habits) {
  habits_ = habits;
  objects_.set_pdo_rules({habits.assignment_fixed, habits.mapping_fixed, habits.even_pdos});
  objects_.set_save(habits.save);
  auto image = sii_image(config_.profile, config_.alias, serial_, habits.clock);
  if (habits.eeprom) habits.eeprom(image);
  esc_.deliver_sii(std::move(image));
}

void Station::power_off() noexcept {
  powered_ = false;
  io_outputs_ = 0;
  state_ = AlState::Init;
  for (const auto& w : wiring_) w.motor->restore(w.motor->position());  // it stops where it is
}

// --- Cycle
// ------------------------------------------------------------------------------------------------------------

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
  const std::int64_t most = missed_most_->value;
  missed_outputs_ = outputs_new_ ? std::max(missed_outputs_ - 1, 0) : missed_outputs_ + kMissedStep;
  outputs_new_ = false;
  if (most > 0 && missed_outputs_ > most) fail(AlState::SafeOp, al_code::kSyncError);
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
  if (io_inputs_told_) {
    for (std::size_t i = 0; i < std::min<std::size_t>(image.size(), 2); ++i)
      image[i] = static_cast<std::byte>(io_inputs_ >> (8 * i) & 0xFF);
    tx_.unpack(image);
  } else {
    tx_.pack(image);
  }
  esc_.publish(process_in_);
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
    if (const auto code = drive->take_emergency(); code && has_mailbox()) coe_->emergency(*code, *code != 0 ? 1 : 0);
    any_fault |= drive->faulted();
  }
  if (!drives_.empty()) error_register_->value = any_fault ? 1 : 0;
  fill_mailbox(at);
  supervise(at);
  if (!habits_.falls || state_ != AlState::Op || ++in_op_ != habits_.falls->after) return;
  fail(AlState::SafeOp, habits_.falls->code);
  if (habits_.falls->again) in_op_ = 0;
}

}  // namespace gantry::sim
