// Why an order is refused, for whoever gave it: what was asked for, what the machine is doing, and what may be done
// instead. One place for the desk, the owner and the machine's buttons.
//   fail(Fault::Refused, refusal(OrderKind::Hold, {.state = state, .undertaking = Undertaking::Home}));
//   -> "'hold' is refused: the machine is busy with 'home' (homing), which cannot be held; `abort` ends it"
// Pure words: whether an order is refused is decided by app/cycle/machine_state.hpp and by what is under way.
#pragma once
#include <string>

#include "app/cycle/machine_state.hpp"
#include "app/run/order.hpp"
#include "app/run/undertaking.hpp"

namespace gantry::run {

/// The machine as an order comes in.
struct Standing {
  cycle::State state = cycle::State::Offline;  ///< as people are told it (Owner::state())
  Undertaking undertaking = Undertaking::None;
  bool on_bus = true;     ///< false: the bus is still to come up
  bool held = false;      ///< what is under way stands on hold, or is on the way there
  bool stopped = false;   ///< a fault has stopped the job, which outlives it
  bool aborting = false;  ///< an abort ends what is under way
};

/// "'ORDER' is refused: what the machine does; what may be done". An order in backticks is taken now, or behind the one
/// before it.
std::string refusal(OrderKind order, const Standing& now);
/// The same for what an owner is asked to do, which may be no order.
std::string refusal(Undertaking asked, const Standing& now);

}  // namespace gantry::run
