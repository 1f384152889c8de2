// How near bodies come to each other in proved motions, for people and programs: the pair, the motion and the line of
// the recipe that asks for it. Pairs that are near by design (a needle over the board) are told apart from all others.
//   Clearances all;   take_nearer(all, block.nearest());
#pragma once
#include <optional>
#include <string>

#include "core/axis_vec.hpp"
#include "core/vec.hpp"

namespace gantry::job {

struct Nearest {
  double distance_mm = 0;        ///< below 0: an allowed overlap (a touch is planned to the window's lower end)
  std::string head, standing;    ///< the two bodies
  std::string motion;            ///< "down to dot 'd[0][1]'"
  std::string where;             ///< "board.yaml:61:5"; empty where no line of a recipe asks for the motion
  Vec3 machine_mm;               ///< on the standing body, machine frame
  std::optional<Vec3> board_mm;  ///< the same in the board's coordinates, where a board is known
  AxisVec axes{};                ///< where the axes stand then
};

/// Nothing where no such pair was near enough to be looked at: no motion, or no body.
struct Clearances {
  std::optional<Nearest> by_design, others;
};

/// "1.50 mm, needle and relay, down to dot 'd[0][1]' (board.yaml:61:5), at (12.00, 8.00, 3.00) mm [machine 192.00,
/// ...]"; "no such pair".
std::string to_text(const std::optional<Nearest>& nearest);

inline void take_nearer(Clearances& all, const Clearances& more) {
  const auto take = [](std::optional<Nearest>& to, const std::optional<Nearest>& from) {
    if (from && (!to || from->distance_mm < to->distance_mm)) to = from;
  };
  take(all.by_design, more.by_design);
  take(all.others, more.others);
}

}  // namespace gantry::job
