// Whether a board is good, from the world's deposits.csv and the recipe's author alone: no id, error or kind that the
// program gives is read. A good board has as many shots as features, one on each in their order, each whole.
//   const auto shots = read_shots("deposits.csv");   const Opinion o = opinion(wanted, shots, undisturbed);
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/vec.hpp"

namespace gantry::test {

/// A feature as its author meant it.
struct Wanted {
  bool bead = false;
  std::vector<Vec2> points;  ///< one of a dot; a closed bead goes back to its first
  double corner_mm = 0, speed_mm_s = 0, gap_mm = 0, dot_s = 0;
  double tolerance_mm = 0.1, gap_tolerance_mm = 0.1;
  bool flow_follows_speed = false;
  double shot_s = 0;               ///< of a dot: what the author's leads make of dot_s on this valve; 0: all of it
  std::vector<double> joins_mm{};  ///< where two shots were joined, along it: there is no speed across a join
};

struct RawShot {
  std::int64_t opened = 0, closed = 0;  ///< cycles of 1 ms; closed 0: still open
  std::vector<Vec3> path;               ///< of a dot its first point alone
};
std::vector<RawShot> read_shots(const std::string& csv_file);

enum class Verdict { Good, Spoilt, Near };  ///< Near: too close to a limit for two ways of measuring to agree

struct Opinion {
  Verdict verdict = Verdict::Good;
  std::string board;  ///< "untouched", "begun", "whole" or "defects"
  std::string why;
};

/// A bead is to be dispensed at its author's speed whatever was planned; corners may slow it down.
/// `undisturbed`: the same features by a job in which nothing happened; it has the speeds that were planned.
Opinion opinion(const std::vector<Wanted>& wanted, const std::vector<RawShot>& shots,
                const std::vector<RawShot>& undisturbed);

}  // namespace gantry::test
