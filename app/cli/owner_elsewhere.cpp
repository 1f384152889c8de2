#include "app/cli/owner_elsewhere.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/cli/signals.hpp"
#include "app/cycle/machine_state.hpp"
#include "app/desk/answer.hpp"
#include "app/desk/order_line.hpp"
#include "core/each_in_order.hpp"
#include "core/log.hpp"

namespace gantry::cli {
namespace {

using desk::Json;
using run::OrderKind;

constexpr Time kAskAgain = milliseconds(100);

constexpr std::array kRows{
    ClientRow{OrderKind::Status, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Enable, OnInterrupt::Ends, OnStopKey::Stops},
    ClientRow{OrderKind::Disable, OnInterrupt::Ends, OnStopKey::Stops},
    ClientRow{OrderKind::Home, OnInterrupt::Ends, OnStopKey::Ends},
    ClientRow{OrderKind::Jog, OnInterrupt::Ends, OnStopKey::Ends},
    ClientRow{OrderKind::Park, OnInterrupt::Ends, OnStopKey::Holds},
    ClientRow{OrderKind::Run, OnInterrupt::Ends, OnStopKey::Holds},
    ClientRow{OrderKind::PartRemoved, OnInterrupt::Ends, OnStopKey::Stops},
    ClientRow{OrderKind::Hold, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Resume, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Abort, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Override, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Reset, OnInterrupt::Leaves, OnStopKey::Stops},
    ClientRow{OrderKind::Quit, OnInterrupt::Leaves, OnStopKey::Stops},
};
static_assert(each_in_order(kRows, &ClientRow::kind, OrderKind::Quit));

}  // namespace

const ClientRow& client_row(OrderKind kind) { return kRows[static_cast<std::size_t>(kind)]; }

Result<void> OwnerElsewhere::say(const run::Order& order, int id) {
  if (!owner_.send(desk::to_line(order, id))) return fail(Fault::OwnerSilent, "the owner takes no more orders");
  looks_open_ += id == kLook;
  return {};
}

void OwnerElsewhere::take_back() {
  if (row_.kind != OrderKind::Status) static_cast<void>(say({.kind = OrderKind::Abort, .mine = true}, kKey));
}

void OwnerElsewhere::interrupt() {
  if (terminal_lost()) return;  // a job does not depend on its client
  take_back();
  left_ = row_.on_interrupt == OnInterrupt::Leaves;
}

/// What homes or is prepared comes to it first. A hold that is refused (an abort is under way, the order is not taken
/// yet) is asked for again, until the order is answered.
Operated::Stands OwnerElsewhere::come_to_stand() {
  if (row_.on_stop_key == OnStopKey::Ends) {
    log::info("Ctrl-Z: '{}' cannot be held, and is ended", run::name(row_.kind));
    take_back();
    return Stands::Ended;
  }
  if (!hold_taken_ && (!hold_asked_ || clock_.now() - *hold_asked_ >= kAskAgain)) {
    if (!hold_asked_ && seen_.state == "homing")
      log::info(
          "Ctrl-Z: the axes that home come to their end first; then the job is held, and the shell has its terminal");
    hold_asked_ = clock_.now();
    static_cast<void>(say({.kind = OrderKind::Hold, .now = true, .mine = true}, kHold));
  }
  const bool stands = seen_.held && (seen_.state == "held" || seen_.state == "stopped");
  return hold_taken_ && stands ? Stands::Yes : Stands::NotYet;
}

/// This process takes no 1 ms loop with it, so that it needs no front as a verb that holds the machine does.
void OwnerElsewhere::suspend() {
  hold_taken_ = false;
  hold_asked_.reset();
  log::info(
      "held; the owner keeps it while the shell has the terminal; `gantry resume` goes on, `gantry abort` ends it");
  stop_for_shell();  // until `fg`
}

void OwnerElsewhere::hear(const Json& answer) {
  const Json id = answer.value("id", Json());
  if (id == kLook) looks_open_ = std::max(0, looks_open_ - 1);
  if (!answer.value("ok", false)) return;
  look_at(answer);
  if (hold_asked_ && id == kHold) hold_taken_ = true;
}

void OwnerElsewhere::tell_hold(const Json& status) {
  if (row_.on_interrupt == OnInterrupt::Leaves) return;
  const auto text = [](const Json& of, const char* key) { return of.value(key, std::string()); };
  const Json hold = status.value("held_by", Json());
  const std::string words = hold.is_object() ? text(hold, "words") : "";
  if (words == hold_told_) return;
  hold_told_ = words;
  if (!hold.is_object()) {
    if (text(status, "state") != cycle::name(cycle::State::Stopping)) log::info("no longer on hold");
    return;
  }
  if (hold.value("yours", false)) return;
  const bool of_another = text(hold, "by") == "order" || text(hold, "by") == "override";
  log::warn("{}{}; {}", words, of_another ? " of another client" : "", text(hold, "next"));
}

/// What a job's line on a terminal shows.
void OwnerElsewhere::tell_override(double factor) {
  if (row_.kind != OrderKind::Run || factor == seen_.override_factor) return;
  if (factor == 1)
    log::info("the override is 100 % again");
  else
    log::warn("an override of {:.0f} % is in force", factor * 100);
}

void OwnerElsewhere::look_at(const Json& status) {
  tell_hold(status);
  tell_override(status.value("override", 1.0));
  seen_.state = status.value("state", "");
  seen_.held = status.value("held", false);
  seen_.cycle = status.value("cycle", CycleIndex{});
  seen_.override_factor = status.value("override", 1.0);
  seen_.progress = {.features_done = status.value("features_done", std::size_t{}),
                    .features_total = status.value("features_total", std::size_t{}),
                    .doing = status.value("doing", ""),
                    .feature = status.value("feature", Json()).is_string() ? status["feature"].get<std::string>() : "",
                    .elapsed_s = status.value("elapsed_s", 0.0)};
  const auto left = status.find("remaining_s");
  seen_.progress.remaining_s =
      left != status.end() && left->is_number() ? std::optional(left->get<double>()) : std::nullopt;
}

}  // namespace gantry::cli
