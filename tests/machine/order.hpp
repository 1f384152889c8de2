// An order of an operator's, and what the valve is told in a cycle.
//   owner.order(order(OrderKind::Override, 0.5));   valve_open(owner.latest())
#pragma once
#include "app/cycle/channels.hpp"
#include "app/run/order.hpp"
#include "config/machine.hpp"

namespace gantry::test {

inline run::Order order(run::OrderKind kind, double value = 1) { return {.kind = kind, .value = value}; }
inline bool valve_open(const cycle::Snapshot& s) { return (s.outputs & config::bit(config::Output::Valve)) != 0; }

}  // namespace gantry::test
