// Judges what the planner certifies and refuses on random boards (random_board.hpp). A job is walked as the runner does
// it, with a world that knows where the board truly lies:
// - what is certified is replayed against the world's own collision watch (sim/world) in its fine steps, and against
// the
//   closed forms of tests/motion/plan/prism_distance.hpp at the true placement;
// - what is refused must name both bodies and the line, and by the same closed forms some pair must really come nearer
//   than the clearance on the path that had to be taken. What is refused is left out, and the job goes on.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "tests/app/job/random_board.hpp"

namespace gantry::test {

struct Verdict {
  std::size_t boards = 0, steps = 0, motions = 0, refused = 0, touched = 0, rises = 0, homings = 0;
  std::size_t blended = 0;         ///< pieces in which up, across and down overlap, between features
  std::size_t collisions = 0;      ///< by the world's watch
  std::size_t misread = 0;         ///< touches that met something else than the board
  std::size_t too_near = 0;        ///< certified, and nearer than the clearance by more than 1e-6 mm
  std::size_t unnamed = 0;         ///< refusals without both bodies or with another line
  std::size_t false_refusals = 0;  ///< nothing comes within clearance + 1e-6 mm
  std::size_t in_doubt = 0;        ///< refused because the board may be higher than its touches say
  std::size_t by_rules = 0;        ///< ended by another rule of the recipe than a collision
  std::vector<std::string> told;   ///< the first of what went wrong, for people
};

void try_board(const RandomBoard& board, std::uint64_t number, Verdict& verdict);

}  // namespace gantry::test
