// Runs one job on a machine that is enabled and referenced: looks at the marks, touches the surface, dispenses, parks.
// Reads from top to bottom as the machine does it; every wait may end with a fault or an order, and then the result
// says how far it came.
//   Runner runner(site, recipe, job, result);   auto ended = runner.run();
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/job/block_plan.hpp"
#include "app/record/job_result.hpp"
#include "app/record/planned_path.hpp"
#include "app/run/control.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "vision/camera.hpp"
#include "vision/fit_offset.hpp"
#include "vision/fit_surface.hpp"

namespace gantry::run {

/// What a job needs of the machine.
struct Site {
  const config::Machine& machine;
  Control& control;
  vision::Camera* camera = nullptr;  ///< null: a recipe with marks fails
};

class Runner {
 public:
  Runner(const Site& site, const recipes::Recipe& recipe, const recipes::Job& job, record::JobResult& result);

  Result<void> run();
  /// What it does now, for people: "mark M2", "touch T1", "dispensing".
  [[nodiscard]] const std::string& doing() const { return doing_; }
  /// What stands around the head, by what the job has measured so far.
  [[nodiscard]] const std::shared_ptr<const job::Surroundings>& surroundings() const { return planner_.surroundings(); }

 private:
  Result<void> play_blocks();
  Result<void> look(std::size_t mark);
  Result<record::MarkResult> judge(std::size_t mark, const AxisVec& head, std::uint64_t shown_before);
  Result<void> settle_offset();
  Result<void> touch(std::size_t index);
  Result<void> settle_surface();
  std::uint32_t next_block(std::string_view tool_name);
  Result<Played> play(const Result<job::PlannedBlock>& planned);
  void guess_from_marks();

  Site site_;
  const recipes::Recipe& recipe_;
  const recipes::Job& job_;
  record::JobResult& result_;
  record::PlannedPath planned_path_;
  job::BlockPlanner planner_;
  AxisVec at_{};             ///< where the axes stand
  std::uint32_t block_ = 0;  ///< number of the block that plays
  std::vector<vision::MarkPair> marks_;
  std::vector<vision::TouchedHeight> heights_;
  recipes::WorkOffset offset_;
  recipes::Surface surface_;
  bool offset_settled_ = false, surface_settled_ = false;
  std::string doing_;
};

}  // namespace gantry::run
