// Runs one job on a machine that is enabled and referenced: looks at the marks, touches the surface, dispenses, parks.
// What comes next is JobState's to say (app/job/job_state.hpp); the runner does it and asks the world. Every wait may
// end with a fault or an order, and then state and result say how far it came.
//   Runner runner(site, recipe, job, result);   auto ended = runner.run();
//   each snapshot meanwhile: runner.see(snapshot);
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/job/block_plan.hpp"
#include "app/job/feature_watch.hpp"
#include "app/job/job_state.hpp"
#include "app/job/surroundings.hpp"
#include "app/record/job_result.hpp"
#include "app/record/planned_path.hpp"
#include "app/run/control.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "vision/camera.hpp"

namespace gantry::run {

/// What a job needs of the machine.
struct Site {
  const config::Machine& machine;
  Control& control;
  vision::Camera* camera = nullptr;  ///< null: a recipe with marks fails
  /// Where the last job has found its board and parts, for the first motion up from it; null: only the machine's own
  /// bodies are known.
  const job::Surroundings* around = nullptr;
  Breath breath{};  ///< asked while motions are planned; no: the job ends with Fault::Aborted
};

class Runner {
 public:
  Runner(const Site& site, const recipes::Recipe& recipe, const recipes::Job& job, record::JobResult& result);

  Result<void> run();
  /// What the loop has shown of one cycle.
  void see(const cycle::Snapshot& snapshot);
  [[nodiscard]] const job::JobState& state() const { return state_; }
  /// What it does now, for people: "mark M2", "touch T1", "dispensing".
  [[nodiscard]] const std::string& doing() const { return doing_; }
  /// What stands around the head, by what the job has measured so far.
  [[nodiscard]] const std::shared_ptr<const job::Surroundings>& surroundings() const { return planner_.surroundings(); }

 private:
  Result<void> close_clamp();
  Result<void> rise();

  /// Does one step of the job, and gives the state after it.
  Result<job::JobState> take(const recipes::LookAtMark& step);
  Result<job::JobState> take(const job::SettleOffset& step);
  Result<job::JobState> take(const recipes::Touch& step);
  Result<job::JobState> take(const job::Retract& step);
  Result<job::JobState> take(const job::SettleSurface& step);
  Result<job::JobState> take(const recipes::Dispense& step);
  Result<job::JobState> take(const recipes::Park& step);

  /// Arms the probe and plays; Z where it touched.
  Result<double> touch_down(const recipes::TouchPoint& point, const std::function<Result<job::ProvenBlock>()>& plan);
  Result<record::MarkResult> judge(std::size_t mark, const AxisVec& head, std::uint64_t shown_before);
  /// The number of the block that is planned next; the report draws its tool.
  std::uint32_t next_block(std::string_view tool_name);
  Result<Played> play(Result<job::ProvenBlock> planned);

  Site site_;
  const recipes::Recipe& recipe_;
  const recipes::Job& job_;
  record::JobResult& result_;
  record::PlannedPath planned_path_;
  job::BlockPlanner planner_;
  AxisVec at_{};             ///< where the axes stand
  std::uint32_t block_ = 0;  ///< number of the block that plays
  job::JobState state_;
  job::FeatureWatch watch_;
  std::string doing_;
};

}  // namespace gantry::run
