// Entries of a world script that can never happen, because the board has no such mark, feature or obstacle.
//   if (auto fits = fits_board(entries, board->plan, obstacles); !fits) return fits;
#pragma once
#include <span>
#include <string>

#include "core/error.hpp"
#include "sim/script/world_event.hpp"
#include "sim/world/board.hpp"

namespace gantry::sim {

/// `obstacles`: names of those that stand already; what the entries add counts too. Fault::UnknownReference at the
/// first such entry, which names the nearest word; the message holds the others.
Result<void> fits_board(std::span<const ScriptEntry> entries, const BoardPlan& plan,
                        std::vector<std::string> obstacles);

}  // namespace gantry::sim
