// Orders as text: one JSON object a line, as they come over the local socket.
//   {"order": "run", "recipe": "/jobs/board.yaml"}    {"order": "override", "value": 0.5}    {"order": "status"}
//   {"order": "jog", "by": {"X": "10 mm", "Z": "-2 mm"}, "speed": "20 mm/s"}
#pragma once
#include <string>
#include <string_view>

#include "app/run/order.hpp"
#include "core/error.hpp"

namespace gantry::desk {

/// One line of JSON. Fault::Refused naming what is wrong and the orders that exist.
Result<run::Order> parse_order(std::string_view line);
std::string to_line(const run::Order& order);

}  // namespace gantry::desk
