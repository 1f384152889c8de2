// The world's things as JSON: for its socket and for its log.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "core/error.hpp"
#include "sim/world/board.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::sim {

nlohmann::json to_json(const BoardPlan& plan);
nlohmann::json to_json(const BoardPlacement& placement);
nlohmann::json to_json(const Deposit& deposit);
nlohmann::json to_json(const Collision& collision);

// Fault::BadValue when the text is not what the functions above wrote.
Result<BoardPlan> plan_from_json(const nlohmann::json& json);
Result<BoardPlacement> placement_from_json(const nlohmann::json& json);
Result<Deposit> deposit_from_json(const nlohmann::json& json);
Result<Collision> collision_from_json(const nlohmann::json& json);

/// Never throws; Fault::BadValue.
Result<nlohmann::json> parse_json(std::string_view text);

}  // namespace gantry::sim
