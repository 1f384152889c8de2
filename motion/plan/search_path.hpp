// A path among what stands, found as well as proved: straight; over what is between at the lowest Z; the shortest path
// through what several random trees (RRTConnect) find; each of them shortened, and the shortest wins. Where none of
// these finds any: cells (cells.hpp), which also prove that there is none. The same question has the same answer in
// every run and process: what chance decides is seeded by scene and question, and budgets count iterations.
//   SearchAnswer found = search_path(scene, from, to, margins);
#pragma once
#include <optional>
#include <vector>

#include "motion/plan/cells.hpp"
#include "motion/plan/lift_over.hpp"
#include "motion/plan/sweep.hpp"

namespace gantry::motion {

enum class PathKind { Standstill, Straight, LiftOver, Detour };
enum class SearchStatus : std::uint8_t { Ok, StartCollides, GoalCollides, NoPath, Budget };

struct SearchBudget {
  int random_trees = 8;  ///< what they find is joined, and the shortest path through that is taken
  int random_iterations = 400;
  std::size_t cuts = 120000;
};

struct SearchAnswer {
  SearchStatus status = SearchStatus::Budget;
  ClosedIn closed_in = ClosedIn::Neither;
  PathKind kind = PathKind::Straight;
  std::vector<AxisVec> points;  ///< of a path, both ends included
  double length_mm = 0;
  std::size_t cuts = 0;               ///< of cells, where they were asked
  std::optional<Hit> hit;             ///< of an end that collides
  std::optional<std::size_t> beyond;  ///< the axis whose limits an end is outside
};

/// X, Y and Z move, all other axes as one: as high as the higher of both ends has the lift. Where bodies turn with C,
/// it turns before the path and after it, else on it; then `no_path` is never said, for it is proved of one position of
/// C.
SearchAnswer search_path(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                         const SearchBudget& budget = {});

/// The same where the straight line is not free and both ends are, which the caller has seen; `over`: a lift-over that
/// is free, null: there is none.
SearchAnswer search_around(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                           const SearchBudget& budget, const LiftOver* over);

inline constexpr double kLimitRounding = 1e-9;  ///< places of a job are turned and shifted with its board
/// The axis whose limits `q` is outside of by more than `rounding`.
std::optional<std::size_t> beyond_limits(const Scene& scene, const AxisVec& q, double rounding = 0);

}  // namespace gantry::motion
