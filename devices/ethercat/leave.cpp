#include "devices/ethercat/leave.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "devices/ethercat/states.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

/// How long each state is waited for. Device descriptions without a time of their own mean 200 ms back to SAFE_OP, and
/// 5 s back to INIT (ETG.2000, StateMachine:Timeout); an operator who ends the program does not wait that long.
struct Step {
  AlState state;
  Time patience;
};
constexpr std::array kSteps{Step{AlState::SafeOp, milliseconds(200)}, Step{AlState::PreOp, milliseconds(200)},
                            Step{AlState::Init, milliseconds(1000)}};
static_assert(kSteps[0].patience + kSteps[1].patience + kSteps[2].patience == kLeaveAtMost);

constexpr int kDeadAfter = 3;                          // looks in a row that a station leaves unanswered
constexpr int kBusDeadAfter = 3;                       // the same of the whole bus; each takes Link's attempts
constexpr Time kBeforeAskingAgain = milliseconds(10);  // of a station that shows an error, or did not hear
constexpr std::size_t kAlBytes = 6;                    // 0130h, with the code in 0134h

/// How far up from INIT to OP. BOOT lies beside PRE_OP: only INIT leads out of it.
int height(AlState state) {
  switch (state) {
    case AlState::Op: return 3;
    case AlState::SafeOp: return 2;
    case AlState::PreOp:
    case AlState::Boot: return 1;
    default: return 0;
  }
}

struct Leaver {
  const StationRecord* station = nullptr;
  AlStatus status{.state = AlState::Op};
  int silent = 0;
  Time ask_at{};

  [[nodiscard]] bool dead() const { return silent >= kDeadAfter; }
  [[nodiscard]] bool is_down_to(AlState state) const { return height(status.state) <= height(state) && !status.error; }
  /// Never upward: one that is below already keeps its state, and only its error is acknowledged.
  [[nodiscard]] std::uint16_t request(AlState state) const {
    const AlState to = height(status.state) < height(state) ? status.state : state;
    return static_cast<std::uint16_t>(static_cast<std::uint16_t>(to) | (status.error ? kAlError : 0));
  }
};

class Descent {
 public:
  Descent(Link& link, std::span<const StationRecord> stations, Time cycle, const std::function<void()>& exchange)
      : link_(link), cycle_(cycle), exchange_(exchange) {
    for (const auto& s : stations) leavers_.push_back({.station = &s});
  }

  void run() {
    look();
    for (const Step& step : kSteps) {
      go_down_to(step);
      if (bus_dead()) return;
      if (step.state == AlState::PreOp) stop_sync0();
    }
    stop_sync0_everywhere();
  }

  [[nodiscard]] std::vector<std::string> left() const {
    std::vector<std::string> all;
    for (const Leaver& l : leavers_) {
      if (bus_dead() || l.dead())
        all.push_back(l.station->where + ": does not answer; in what state it was left is not known");
      else if (!l.is_down_to(AlState::Init))
        all.push_back(fmt::format("{}: stays in {}: AL status code {:04X}h, {}", l.station->where, name(l.status.state),
                                  l.status.code, al_status_text(l.status.code)));
    }
    return all;
  }

 private:
  [[nodiscard]] bool bus_dead() const { return failures_ >= kBusDeadAfter; }

  void go_down_to(const Step& step) {
    const Time deadline = link_.clock().now() + step.patience;
    for (Leaver& l : leavers_) l.ask_at = Time{};
    while (!bus_dead()) {
      ask(step.state);
      if (std::ranges::any_of(leavers_, [](const Leaver& l) { return !l.dead() && l.status.state == AlState::Op; }))
        exchange_();
      look();
      const bool done =
          std::ranges::all_of(leavers_, [&](const Leaver& l) { return l.dead() || l.is_down_to(step.state); });
      if (done || link_.clock().now() >= deadline) return;
      link_.pause(cycle_);
    }
  }

  /// Once for each state: asking again would make some stations begin anew. Again only after an error, or when the
  /// station did not hear it.
  void ask(AlState state) {
    const Time now = link_.clock().now();
    std::vector<std::array<std::byte, 2>> raw(leavers_.size());
    std::vector<Datagram> batch;
    std::vector<Leaver*> asked;
    for (std::size_t i = 0; i < leavers_.size(); ++i) {
      Leaver& l = leavers_[i];
      if (l.dead() || l.is_down_to(state) || now < l.ask_at) continue;
      put_le<std::uint16_t>(raw[i], 0, l.request(state));
      batch.push_back({Command::Fpwr, physical_address(l.station->address, reg::kAlControl), raw[i]});
      asked.push_back(&l);
    }
    if (!transact(batch)) return;
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const bool heard = batch[i].working_counter == kWkcWrite;
      asked[i]->ask_at = heard && !asked[i]->status.error ? kNever : now + kBeforeAskingAgain;
    }
  }

  /// A station that shows an error after it was asked is asked again, with the acknowledgement.
  void look() {
    std::vector<std::array<std::byte, kAlBytes>> raw(leavers_.size());
    std::vector<Datagram> batch;
    for (std::size_t i = 0; i < leavers_.size(); ++i)
      batch.push_back({Command::Fprd, physical_address(leavers_[i].station->address, reg::kAlStatus), raw[i]});
    if (!transact(batch)) return;
    for (std::size_t i = 0; i < leavers_.size(); ++i) {
      Leaver& l = leavers_[i];
      if (batch[i].working_counter != kWkcRead) {
        ++l.silent;
        continue;
      }
      l.silent = 0;
      const auto status = get_le<std::uint16_t>(raw[i], 0);
      l.status = {static_cast<AlState>(status & kAlStateMask), (status & kAlError) != 0,
                  get_le<std::uint16_t>(raw[i], 4)};
      if (l.status.error && l.ask_at == kNever) l.ask_at = link_.clock().now() + kBeforeAskingAgain;
    }
  }

  /// From PRE_OP on a station does not miss it.
  void stop_sync0() {
    std::vector<std::array<std::byte, 1>> off(leavers_.size());
    std::vector<Datagram> batch;
    for (std::size_t i = 0; i < leavers_.size(); ++i) {
      const Leaver& l = leavers_[i];
      if (l.station->sync0 && !l.dead() && height(l.status.state) <= height(AlState::PreOp))
        batch.push_back({Command::Fpwr, physical_address(l.station->address, reg::kDcActivation), off[i]});
    }
    transact(batch);
  }
  void stop_sync0_everywhere() {
    std::array<std::byte, 1> off{};
    Datagram all{Command::Bwr, physical_address(0, reg::kDcActivation), off};
    transact(std::span(&all, 1));
  }

  bool transact(std::span<Datagram> batch) {
    if (batch.empty()) return true;
    const bool ok = link_.transact(batch).has_value();
    failures_ = ok ? 0 : failures_ + 1;
    return ok;
  }

  Link& link_;
  Time cycle_;
  const std::function<void()>& exchange_;
  std::vector<Leaver> leavers_;
  int failures_ = 0;  ///< of the bus, in a row
};

}  // namespace

std::vector<std::string> leave_operation(Link& link, std::span<const StationRecord> stations, Time cycle,
                                         const std::function<void()>& exchange) {
  Descent descent(link, stations, cycle, exchange);
  descent.run();
  return descent.left();
}

}  // namespace gantry::devices
