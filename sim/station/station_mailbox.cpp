// Station: the two mailboxes (ETG.1000.4, 5.6 and 6.7).
#include <algorithm>

#include "sim/station/station.hpp"

namespace gantry::sim {

using namespace devices::wire;

/// INIT stops the mailbox, and what was under way or could have been asked for again is gone.
void Station::forget_mailbox() noexcept {
  coe_->reset();
  last_mailbox_.clear();
  mailbox_due_ = kNever;
  if (has_mailbox()) esc_.acknowledge_repeat(mailbox_in_);
}

void Station::on_mailbox(Time now) noexcept {
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
  // A master that does not fetch its answers finds its next request not taken.
  if (esc_.mailbox_full(mailbox_out_) && coe_->room()) {
    coe_->take(esc_.area(mailbox_out_), state_ == AlState::PreOp);
    esc_.set_mailbox_full(mailbox_out_, false);
    if (habits_.mailbox_delay > Time{0}) mailbox_due_ = now + habits_.mailbox_delay;
  }
  fill_mailbox(now);
}

void Station::fill_mailbox(Time now) noexcept {
  if (mailbox_due_ != kNever && now < mailbox_due_) return;
  mailbox_due_ = kNever;
  if (!has_mailbox() || state_ == AlState::Init || !coe_->waiting() || esc_.mailbox_full(mailbox_in_)) return;
  const auto area = esc_.area(mailbox_in_);
  last_mailbox_ = coe_->next();
  if (area.size() < last_mailbox_.size()) return;
  std::copy(last_mailbox_.begin(), last_mailbox_.end(), area.begin());
  esc_.set_mailbox_full(mailbox_in_, true);
}

}  // namespace gantry::sim
