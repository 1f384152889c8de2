// What people may ask of the owner of a machine, from keys, from the command line and over the local socket: one JSON
// object a line.
//   {"order": "run", "recipe": "/jobs/board.yaml"}    {"order": "override", "value": 0.5}    {"order": "status"}
//   {"order": "jog", "by": {"X": "10 mm", "Z": "-2 mm"}, "speed": "20 mm/s"}
// Hold, resume, abort, override and status are answered at once; home, jog, run and enable when they are done.
#pragma once
#include <map>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace gantry::run {

enum class OrderKind { Status, Enable, Disable, Home, Jog, Run, Hold, Resume, Abort, Override, Reset, Quit };

/// What a jog is asked for (jog.hpp).
struct JogWords {
  std::map<std::string, std::string> by{};  ///< axis: "10 mm", "-15 deg"
  std::string speed{};                      ///< "20 mm/s", or "20 deg/s" where only rotary axes move; "" takes these
};

struct Order {
  OrderKind kind = OrderKind::Status;
  std::string recipe{};  ///< Run: path
  std::string out{};     ///< Run: folder for the results
  JogWords jog{};        ///< Jog
  double value = 1;      ///< Override: 1 is 100 %, 0.1 .. 2
};

/// Whether the order takes machine time; only one such order runs at a time.
constexpr bool takes_time(OrderKind k) {
  return k == OrderKind::Enable || k == OrderKind::Disable || k == OrderKind::Home || k == OrderKind::Jog ||
         k == OrderKind::Run;
}

std::string_view name(OrderKind kind);

/// One line of JSON. Fault::Refused naming what is wrong and the orders that exist.
Result<Order> parse_order(std::string_view line);
std::string to_line(const Order& order);

}  // namespace gantry::run
