// The owner with its door: orders that take time are carried out here one at a time, the others are answered between
// two cycles.
//   Desk desk(machine, owner, door, interrupted);   owner.on_step([&] { desk.poll(); });   desk.serve();
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "app/desk/order_socket.hpp"
#include "app/run/owner.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::desk {

class Desk {
 public:
  /// `interrupted`: the program was asked to end (a signal).
  Desk(const config::Machine& machine, run::Owner& owner, OrderSocket& door, std::function<bool()> interrupted)
      : machine_(machine), owner_(owner), door_(door), interrupted_(std::move(interrupted)) {}

  /// Called in every step of the run thread.
  void poll();
  /// Until it is asked to end. Fault::LoopDied when the machine cannot be served any more.
  Result<void> serve();

 private:
  using Json = nlohmann::ordered_json;
  struct Waiting {
    std::uint64_t client = 0;
    run::Order order;
  };

  void end();
  Json answer_now(const run::Order& order);
  [[nodiscard]] Json status() const;
  Json carry_out(const run::Order& order);
  Json jog(const job::JogWords& words);
  Json run_job(const run::Order& order);

  const config::Machine& machine_;
  run::Owner& owner_;
  OrderSocket& door_;
  std::function<bool()> interrupted_;
  std::optional<Waiting> waiting_;
  bool busy_ = false, stop_ = false;
};

}  // namespace gantry::desk
