// Entries of a world script that can never happen, because the board has no such mark, feature or obstacle.
//   const std::vector<Error> misfits = misfits_of(entries, board->plan, obstacles);   // empty: all may happen
#pragma once
#include <span>
#include <string>

#include "core/error.hpp"
#include "sim/script/world_event.hpp"
#include "sim/world/board.hpp"

namespace gantry::sim {

/// `obstacles`: names of those that stand already; what the entries add counts too. Fault::UnknownReference at each
/// such entry, with the nearest word.
std::vector<Error> misfits_of(std::span<const ScriptEntry> entries, const BoardPlan& plan,
                              std::vector<std::string> obstacles);

}  // namespace gantry::sim
