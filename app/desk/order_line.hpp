// Orders as text: one JSON object a line, as they come over the local socket.
//   {"order": "run", "recipe": "/jobs/board.yaml"}    {"order": "override", "value": 0.5}    {"order": "status"}
//   {"order": "jog", "by": {"X": "10 mm", "Z": "-2 mm"}, "speed": "20 mm/s"}
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/run/order.hpp"
#include "core/error.hpp"

namespace gantry::desk {

inline constexpr std::size_t kLongestLine = 64 * 1024;  ///< bytes, without its newline

std::string to_line(const run::Order& order, const nlohmann::ordered_json& id = nullptr);

/// An order with what its client calls it: "id", any JSON of up to 100 bytes, comes back in the answer. An order that
/// stops something (abort, hold, quit) is taken whatever else its line holds, without an id where that is none.
struct Request {
  Result<run::Order> order;  ///< Fault::Refused naming what is wrong and the orders that exist
  nlohmann::ordered_json id{};
  std::optional<run::OrderKind> asked{};  ///< which order it is, also where something else of it is wrong
};
Request read_request(std::string_view line);

/// Orders that stop something, and so wait for nothing: abort, hold, quit. Which of them it is; nothing: another one.
inline constexpr unsigned kStopKinds = 3;
std::optional<unsigned> stop_kind(run::OrderKind kind);
/// Quick: a line for which this is false is no such order.
bool may_stop(std::string_view line);

/// An answer as its client gets it: with what it has asked for, with its id, and of `run` with how the board is left
/// (untouched where the answer does not say so).
nlohmann::ordered_json answer_to(const Request& request, nlohmann::ordered_json answer);

}  // namespace gantry::desk
