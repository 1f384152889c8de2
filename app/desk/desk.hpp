// The owner with its socket: orders that take time are carried out here one at a time, the others are answered between
// two cycles, and those that stop something wait for nothing.
//   Desk desk(machine, owner, door, clock, {.interrupted = ..., .identity = ...});
//   owner.on_step([&] { desk.poll(); });   desk.bring_up();   desk.serve();
// A job does not depend on the client that ordered it, a jog does: it ends when its client is silent
// (app/job/hold_to_run.hpp).
#pragma once
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/desk/begun_parts.hpp"
#include "app/desk/order_line.hpp"
#include "app/desk/order_socket.hpp"
#include "app/run/aside.hpp"
#include "app/run/owner.hpp"
#include "config/machine.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"

namespace gantry::desk {

class Desk {
 public:
  struct Options {
    std::function<bool()> interrupted;  ///< the program was asked to end (a signal)
    nlohmann::ordered_json identity{};  ///< what `status` says of this owner
    std::string recipe{};               ///< what the start button runs; "": nothing
    record::SameMachine same_machine{};
    BegunParts* parts = nullptr;  ///< those that were not finished; null: nothing is remembered of them
  };
  /// `clock` is that of the clients, also where the machine's time is virtual.
  Desk(const config::Machine& machine, run::Owner& owner, OrderSocket& door, const Clock& clock, Options options)
      : machine_(machine), owner_(owner), door_(door), clock_(clock), options_(std::move(options)) {}

  /// Called in every step of the run thread: one bounded turn of the socket.
  void poll();
  /// Owner::bring_up(), which a signal or `quit` ends early.
  Result<void> bring_up();
  /// Until it is asked to end. Fault::LoopDied when the machine cannot be served any more.
  Result<void> serve();

 private:
  using Json = nlohmann::ordered_json;
  static constexpr std::uint64_t kNobody = 0;  ///< no client has this number
  struct Waiting {
    std::uint64_t client = 0;
    Request request;
    std::optional<Time> unsure_since{};  ///< of a jog: it may be old, and begins when its client is heard after this
  };

  /// An order that has been given to the loop: its client hears of the state that it has led to.
  struct Told {
    Waiting to;
    Time due;
    std::string said;
  };

  /// Why what is under way stands.
  struct Hold {
    enum class By { Order, Override, Button, Terminal, Fault } by = By::Order;
    std::uint64_t client = kNobody;  ///< of an order
    std::optional<Error> stop{};     ///< of a fault
  };

  /// A hold counts for what came before it and has not begun, too.
  struct HeldBack {
    std::uint64_t number = 0;  ///< of the hold
    Hold hold{};
  };

  /// A press of the start button for which nothing was done.
  struct InVain {
    std::string folder, errors;
  };

  /// What an order has come to.
  struct Carried {
    Json answer{};       ///< null: all went well, and the answer is the status after it ...
    std::string said{};  ///< ... behind these words
  };

  void end();
  void take(const OrderSocket::Incoming& in);
  void reply(std::uint64_t client, const Request& request, Json answer);
  Json answer_now(std::uint64_t client, const run::Order& order);
  [[nodiscard]] Json hold_in_words(std::uint64_t client) const;
  void give(const OrderSocket::Incoming& in);
  void resume(const OrderSocket::Incoming& in);
  /// What waits to begin on hold begins when it is ready, and says so. Nothing: nothing waits so.
  std::optional<std::string> let_go();
  void hold(const OrderSocket::Incoming& in);
  /// To the owner: what it says of the order, and how far the tool goes on.
  Result<std::string> obey(const run::Order& order);
  /// Its client hears of the state that this has led to.
  void answer_soon(const OrderSocket::Incoming& in, std::string said);
  /// Holds what has not begun, which the owner does not know yet, and says so. Nothing: there is nothing of that kind.
  std::optional<std::string> hold_what_begins(const OrderSocket::Incoming& in);
  /// An order that moves axes and was not taken yet: one of those that are such.
  using IsSuch = std::function<bool(const OrderSocket::Incoming&)>;
  [[nodiscard]] std::optional<run::OrderKind> motion_in_line(const IsSuch& is_such) const;
  /// One that came before this hold; of its client alone where it is `mine`.
  [[nodiscard]] std::optional<run::OrderKind> motion_before(const OrderSocket::Incoming& hold) const;
  void hold_back(std::uint64_t whose, HeldBack back);
  /// The hold that came behind this order; null: none did, or a resume has ended it.
  [[nodiscard]] const HeldBack* held_back(const OrderSocket::Incoming& in) const;
  /// What is carried out, or is about to be; null: nothing.
  [[nodiscard]] const Waiting* at_work() const;
  /// Those of one client without ids (its next line has come), or whose time has come.
  void tell_given(std::optional<std::uint64_t> client);
  void tell(const Told& told);
  [[nodiscard]] bool is_answered_later(std::uint64_t client) const;
  /// What waits or is prepared ends here; what moves is the owner's.
  void abort_what_waits(std::uint64_t number);
  /// Ends what this client has ordered, whether it moves, is prepared, waits, or has not been looked at yet.
  void abort_own(std::uint64_t client, std::uint64_t number);
  /// It arrived before its client has taken back all that it had said.
  [[nodiscard]] bool taken_back(const OrderSocket::Incoming& in) const;
  void reset(std::uint64_t client, const Request& request);
  void watch_reset();
  void watch_start_button();
  void watch_hold_button();
  /// The last word to whoever asked for this; what the start button began is told in the log.
  void finish(const Waiting& done, Json answer);
  void keep_newest_in_vain(const Json& answer);
  void watch_jog();
  /// What waits begins now.
  [[nodiscard]] bool may_begin() const;
  /// Whoever it is that holds what is under way.
  void watch_hold();
  /// As this client is told it; kNobody: as any other one.
  [[nodiscard]] Json status(std::uint64_t client = kNobody) const;
  /// The machine's state, but that an owner with an order never reads as one that has none.
  [[nodiscard]] std::string_view state_word() const;
  Carried carry_out(const run::Order& order);
  [[nodiscard]] Json status_behind(const std::string& said) const;
  /// The abort, or the end of this program, that came before the job.
  [[nodiscard]] Error why_nothing_begins() const;
  /// How what is at work begins; a hold that was wished for is with the owner from here on.
  run::Begin begin();
  Json jog(const job::JogWords& words);
  Json run_job(const run::Order& order);
  /// What is known to lie on the part with this serial, "": on the one in the machine.
  std::string_view board_of(const std::string& serial);
  Carried part_removed(const run::Order& order);
  /// Runs `work` on another thread and serves the machine until it is done, in virtual time too: an order may end it.
  /// False when one came first: then the work goes on unheard.
  bool prepare_aside(std::function<void()> work);

  const config::Machine& machine_;
  run::Owner& owner_;
  OrderSocket& door_;
  const Clock& clock_;
  Options options_;
  std::optional<Waiting> waiting_, doing_, resetting_;
  std::vector<Told> given_;
  std::optional<Time> turned_;               ///< when the socket had its last turn
  Time gap_{};                               ///< from the turn before to that: so old may be what it has read
  std::vector<OrderSocket::Incoming> turn_;  ///< what arrived to be taken in this turn ...
  std::size_t taken_ = 0;                    ///< ... and how much of it was
  run::Aside aside_;
  std::map<std::uint64_t, std::uint64_t> taken_back_;  ///< by client: number of its last abort of its own orders
  std::map<std::uint64_t, HeldBack> held_back_;        ///< by client whose orders alone are meant; kNobody: everybody's
  std::uint64_t told_hung_up_ = 0;   ///< the last client of which people were told that it has hung up
  std::uint64_t aborted_up_to_ = 0;  ///< number of the last abort: what arrived before it does not begin any more
  std::string recipe_;               ///< of the job that is prepared or runs
  std::optional<Error> aborted_;     ///< why what is prepared does not begin
  bool preparing_ = false, bringing_up_ = false, stop_ = false;
  std::string in_vain_;  ///< folder of the last job when nothing was done for it; else ""
  std::optional<InVain> pressed_in_vain_;
  bool hold_wished_ = false;  ///< of what is at work and has not begun
  std::optional<Hold> hold_;  ///< since it was asked for, or seen
  bool stood_ = false;        ///< on hold, or on the way there
};

}  // namespace gantry::desk
