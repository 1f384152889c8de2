// The owner at the other end of a connection, and the order that this program has given it. Only whose order it is may
// end it: Ctrl-C and Ctrl-Z of a client act on its own order, and on no other one's (docs/operating.md).
//   OwnerElsewhere elsewhere(owner, run::OrderKind::Park);   Keys keys(elsewhere, Keys::Shows::Nothing);
//   elsewhere.say(order, id);   elsewhere.hear(answer to a status);
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "app/cli/operated.hpp"
#include "app/desk/order_client.hpp"
#include "app/run/order.hpp"
#include "core/clock.hpp"

namespace gantry::cli {

/// What Ctrl-C in the client that gave an order does.
enum class OnInterrupt {
  Leaves,  ///< the client ends, and what it has asked for but not got yet is taken back; the machine goes on
  Ends     ///< what it has ordered ends first
};
/// What Ctrl-Z there does.
enum class OnStopKey {
  Stops,  ///< the client is suspended as any program is: nothing moves by its order
  Ends,   ///< what cannot be held and would move unwatched ends, as with Ctrl-C
  Holds   ///< the motion is held first; when it stands, the client is suspended
};
struct ClientRow {
  run::OrderKind kind;
  OnInterrupt on_interrupt;
  OnStopKey on_stop_key;
};
/// One row for each order.
const ClientRow& client_row(run::OrderKind kind);

class OwnerElsewhere final : public Operated {
 public:
  /// What the client calls its orders.
  static constexpr int kTheOrder = 1, kLook = 2, kKey = 3, kHold = 4;

  OwnerElsewhere(desk::OrderClient& owner, run::OrderKind kind) : owner_(owner), row_(client_row(kind)) {}

  [[nodiscard]] JobSeen seen() const override { return seen_; }
  Result<void> order(const run::Order& order) override { return say(order, kKey); }
  void interrupt() override;
  Stands come_to_stand() override;
  void suspend() override;

  /// Fault::OwnerSilent when it takes nothing more.
  Result<void> say(const run::Order& order, int id);
  /// What is not carried out yet of this client's orders is not to be carried out any more.
  void take_back();
  /// Any answer.
  void hear(const nlohmann::ordered_json& answer);
  /// Ctrl-C in a client that only asks.
  [[nodiscard]] bool left() const { return left_; }
  /// Whether a look was sent that is not answered yet.
  [[nodiscard]] int looks_open() const { return looks_open_; }

 private:
  void look_at(const nlohmann::ordered_json& status);
  /// Who waits for what stands hears why it does, and what lets it go on; not what they have done themselves.
  void tell_hold(const nlohmann::ordered_json& status);
  void tell_override(double factor);

  desk::OrderClient& owner_;
  const ClientRow& row_;
  MonotonicClock clock_;
  JobSeen seen_;
  bool left_ = false;
  std::string hold_told_;  ///< in words; "": it does not stand
  int looks_open_ = 0;
  std::optional<Time> hold_asked_;  ///< for the shell, since it wished for its terminal
  bool hold_taken_ = false;
};

}  // namespace gantry::cli
