// Whether a job that says "done" is done: what is wrong with its deposits, feature by feature, as far as the machine
// can know; where a world was asked, by what lies on its board.
//   add_judgement(result, judge_board(result, recipe, {state.features, watch.off_speed()}, cycle_s));
// Where a world knows, it decides where deposits lie and how much of them; what a stop has cut counts only where it
// shows.
#pragma once
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/job/job_state.hpp"
#include "app/job/slow_beads.hpp"
#include "app/job/speed_watch.hpp"
#include "app/record/job_result.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

/// What the controller has seen of its features.
struct Seen {
  std::span<const job::FeatureState> features;  ///< by index in Recipe::features
  std::vector<job::OffSpeed> off_speed;
  OnBoard before{};
  std::span<const job::SlowBead> slow_beads{};  ///< by plan
  double sets_out_s = 0;                        ///< of the machine
};

struct Judgement {
  Board board = Board::Untouched;
  std::vector<Defect> defects;
};

/// After the world was asked. It reads nothing of the result that may still grow while the machine is served.
[[nodiscard]] Judgement judge_board(const JobResult& result, const recipes::Recipe& recipe, const Seen& seen,
                                    double cycle_s);

/// The longest that a needle of this machine takes from rest until the world sees it off its start (sim::kSetOut_mm):
/// with the largest jerk (d = j t^3 / 6) and then the largest acceleration (d = a t^2 / 2) of its slowest axis, one
/// after the other, which is more than any mixture of both. What its speed leaves of it comes on top.
[[nodiscard]] double sets_out_s(const config::Machine& machine);

/// `defects`, `board` and `exit_code` of the result. An error's exit code stays.
void add_judgement(JobResult& result, Judgement judgement);

/// Something of the feature is not on the board.
bool is_lacking(const Defect& defect);

/// By its name; nothing: there is none.
std::optional<Defect::Kind> kind_named(std::string_view name);

std::string_view name(Board board);  ///< "untouched", "begun", "whole", "defects"
std::string_view name(
    Defect::Kind kind);  ///< "missing", "cut", "beside", "gap", "amount", "speed", "extra", "reference", "late"

}  // namespace gantry::record
