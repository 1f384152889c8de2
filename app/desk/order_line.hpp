// Orders as text: one JSON object a line, as they come over the local socket.
//   {"order": "run", "recipe": "/jobs/board.yaml"}    {"order": "override", "value": 0.5}    {"order": "status"}
//   {"order": "jog", "by": {"X": "10 mm", "Z": "-2 mm"}, "speed": "20 mm/s"}
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/run/order.hpp"
#include "core/error.hpp"

namespace gantry::desk {

/// One line of JSON. Fault::Refused naming what is wrong and the orders that exist.
Result<run::Order> parse_order(std::string_view line);
std::string to_line(const run::Order& order, const nlohmann::ordered_json& id = nullptr);

/// An order with what its client calls it: "id", any JSON of up to 100 bytes, comes back in the answer. An order that
/// stops something (abort, hold, quit) is taken whatever else its line holds, without an id where that is none.
struct Request {
  Result<run::Order> order;
  nlohmann::ordered_json id{};
};
Request read_request(std::string_view line);

/// Whether the line is an order that stops something, and so waits for nothing: abort, hold, quit. Quick: only a line
/// that holds one of these words is read as JSON.
bool is_urgent(std::string_view line);

}  // namespace gantry::desk
