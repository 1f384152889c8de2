// What people may ask of the owner of a machine, from keys, from the command line and over the local socket: one JSON
// object a line.
//   {"order": "run", "recipe": "/jobs/board.yaml"}    {"order": "override", "value": 0.5}    {"order": "status"}
// Hold, resume, abort, override and status are answered at once; home, run and enable when they are done.
#pragma once
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace gantry::run {

enum class OrderKind { Status, Enable, Disable, Home, Run, Hold, Resume, Abort, Override, Reset, Quit };

struct Order {
  OrderKind kind = OrderKind::Status;
  std::string recipe{};  ///< Run: path
  std::string out{};     ///< Run: folder for the results
  double value = 1;      ///< Override: 1 is 100 %, 0.1 .. 2
};

/// Whether the order takes machine time; only one such order runs at a time.
constexpr bool takes_time(OrderKind k) {
  return k == OrderKind::Enable || k == OrderKind::Disable || k == OrderKind::Home || k == OrderKind::Run;
}

std::string_view name(OrderKind kind);

/// One line of JSON. Fault::Refused naming what is wrong and the orders that exist.
Result<Order> parse_order(std::string_view line);
std::string to_line(const Order& order);

}  // namespace gantry::run
