// Runs one job on a machine that is enabled and referenced: looks at the marks, touches the surface, dispenses, parks.
// What comes next is JobState's to say (app/job/job_state.hpp); the runner does it and asks the world. Every wait may
// end with a fault or an order, and then state and result say how far it came.
//   Runner runner(site, recipe, job, result);   auto ended = runner.run();
//   each snapshot meanwhile: runner.see(snapshot);
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/job/block_plan.hpp"
#include "app/job/cut_bead.hpp"
#include "app/job/feature_watch.hpp"
#include "app/job/job_state.hpp"
#include "app/job/job_times.hpp"
#include "app/job/speed_watch.hpp"
#include "app/job/surroundings.hpp"
#include "app/record/job_result.hpp"
#include "app/record/motion_file.hpp"
#include "app/record/planned_path.hpp"
#include "app/run/control.hpp"
#include "app/run/foresight.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "vision/camera.hpp"

namespace gantry::run {

/// What a job needs of the machine.
struct Site {
  const config::Machine& machine;
  Control& control;
  vision::Camera* camera = nullptr;  ///< null: the job looks at no mark
  /// Where the last job has found its board and parts, for the first motion up from it; null: only the machine's own
  /// bodies are known.
  const job::Surroundings* around = nullptr;
  Breath breath{};                          ///< asked while motions are planned; no: the job ends with Fault::Aborted
  motion::Opinion opinion{};                ///< asked of each motion besides the proof; empty: nobody is
  const job::Forecast* forecast = nullptr;  ///< of the job; null: there is none
  Foresight::Thread foresight = Foresight::Thread::Callers;  ///< who proves ahead; its own in real time alone
  record::MotionFile* motions = nullptr;  ///< where the motions that are played are listed; null: nowhere
  /// Runs to its end what waits for the camera, while the machine is served; it touches nothing that a step touches. An
  /// error: meanwhile something has come that ends the job.
  std::function<Result<void>(const std::function<void()>&)> aside = [](const std::function<void()>& work) {
    work();
    return Result<void>{};
  };
};

/// The feature that is dispensed, and when the tool stands that a hold lets end it; of the purge, how long its shot
/// takes at most.
struct Ahead {
  std::string feature;  ///< empty: the purge
  double left_s = 0;

  /// For people: where a hold finds the tool now, and when it stands where it waits.
  [[nodiscard]] std::string in() const { return feature.empty() ? "in the purge" : "on '" + feature + "'"; }
  [[nodiscard]] std::string after() const {
    return feature.empty() ? "after this shot in the purge, within" : "after '" + feature + "', in";
  }
};

class Runner {
 public:
  Runner(const Site& site, const recipes::Recipe& recipe, const recipes::Job& job, record::JobResult& result);

  Result<void> run();
  /// What the loop has shown of one cycle.
  void see(const cycle::Snapshot& snapshot);
  [[nodiscard]] const job::JobState& state() const { return state_; }
  /// Nothing while the valve is shut.
  [[nodiscard]] std::optional<Ahead> ahead() const;
  /// The feature that is dispensed next in the motion that plays; empty: none is. Asked again and again it looks at
  /// each segment once.
  [[nodiscard]] std::string heads_for();
  /// The same, or the feature that is dispensed now.
  [[nodiscard]] std::string feature();
  /// Beads that were dispensed at another speed than the recipe's.
  [[nodiscard]] std::vector<job::OffSpeed> off_speed() const { return speed_watch_.off_speed(); }
  /// Up to which override its materials allow more than the machine does; 1 is the recipe's speed.
  [[nodiscard]] double override_max() const { return recipes::override_max(recipe_); }
  /// What it does now, for people: "mark M2", "touch T1", "dispensing".
  [[nodiscard]] const std::string& doing() const { return doing_; }
  /// About how long the job will still take at an override of 100 %; nothing without a forecast.
  [[nodiscard]] std::optional<double> left_s() const { return times_.left_s(); }
  /// What stands around the head, by what the job has measured so far.
  [[nodiscard]] const std::shared_ptr<const job::Surroundings>& surroundings() const { return planner_.surroundings(); }

 private:
  Result<void> begin();
  /// The job goes on behind a reset and a resume.
  [[nodiscard]] bool outlives(const Error& error) const;
  Result<void> close_clamp();
  /// `begins`: the job's first block comes next.
  Result<void> rise(const job::Surroundings& around, bool begins = false);

  /// Does one step of the job, and gives the state after it.
  Result<job::JobState> take(const recipes::LookAtMark& step);
  Result<job::JobState> take(const job::SettleOffset& step);
  Result<job::JobState> take(const recipes::Touch& step);
  Result<job::JobState> take(const job::Retract& step);
  Result<job::JobState> take(const job::SettleSurface& step);
  Result<job::JobState> take(const recipes::PurgeNeedle& step);
  Result<job::JobState> take(const recipes::Dispense& step);
  Result<job::JobState> take(const recipes::Park& step);

  /// The block that has got its number last, from where the axes stand: foreseen, or planned now.
  Result<job::ProvenBlock> prove(job::BlockStep step);
  /// What comes next will begin there, in this state of the job.
  void foresee(const job::JobState& after, const AxisVec& from);
  /// The same when the block has ended as planned.
  void foresee(const job::JobState& after, const Result<job::ProvenBlock>& block);
  /// A valve of which nothing is known may have been shut for any time.
  [[nodiscard]] bool purge_is_due() const;
  /// Plans, arms the probe and plays; Z where it touched.
  Result<double> touch_down(const recipes::TouchPoint& point, const std::function<Result<job::ProvenBlock>()>& plan);
  [[nodiscard]] bool disturbs(const cycle::Snapshot& s) const;
  Result<record::MarkResult> judge(std::size_t mark, const AxisVec& head, std::uint64_t shown_before);
  /// How a bead begins whose run-up is blocked; once, unless it comes to begin otherwise.
  void tell(const job::RunUp& begun);
  /// The number of the block that is planned next; the report draws its tool.
  std::uint32_t next_block(std::string_view tool_name);
  enum class When { Released, OnHold, Armed };
  Result<Played> play(Result<job::ProvenBlock> planned, When when = When::Released);
  Result<Played> play_through(const job::ProvenBlock& block, When when);
  /// Arms the probe when nothing waits any more: whatever touches it meanwhile would be its touch.
  Result<void> arm();
  /// A hold has stopped on this feature: the needle lifts and waits for the operator to resume.
  Result<void> hold_off(std::size_t feature);
  /// A fault that a job outlives has stopped it: nothing moves until somebody has reset and resumed; then up to the
  /// safe height.
  Result<void> sit_out();
  /// The same, and then what was stopped is done again; of a bead that was cut, what is missing.
  Result<job::JobState> go_on_after_stop();
  /// Until the resume, or until the part may not lie where it lay.
  Result<void> wait_for_resume();
  /// A bead that was cut is open again from there on.
  Result<job::JobState> join(std::size_t feature);
  /// The joined bead's valve has opened again.
  void note_joined(const cycle::Snapshot& s);
  /// Of a job that stands on hold between two blocks, where the loop looks at neither.
  void watch_part(const cycle::Snapshot& s);
  void note_cut(const std::vector<job::FeatureState>& before, const std::deque<motion::Segment>& segments);

  Site site_;
  const recipes::Recipe& recipe_;
  const recipes::Job& job_;
  record::JobResult& result_;
  record::PlannedPath planned_path_;
  job::BlockPlanner planner_;
  Foresight foresight_;
  AxisVec at_{};             ///< where the axes stand
  std::uint32_t block_ = 0;  ///< number of the block that plays
  job::JobState state_;
  job::FeatureWatch watch_;
  job::SpeedWatch speed_watch_;
  job::CutWatch cut_watch_;
  job::JobTimes times_;
  const std::deque<motion::Segment>* playing_ = nullptr;  ///< the segments of the block that plays
  /// How far heads_for() has looked: the segments before this one lie behind the tool.
  struct Looked {
    std::uint32_t block = 0;
    std::size_t segment = 0;
    double begins_mm = 0;  ///< along the block
  };
  Looked looked_;
  std::optional<std::size_t> cut_;  ///< the feature that a hold or a stop has cut in this step
  std::optional<job::Laid> laid_;   ///< of it, where it is a bead
  /// The bead that is on its way to be joined.
  struct Joining {
    std::size_t feature = 0;
    record::Joined told;
    std::int64_t shut_ns = 0;  ///< when its valve shut
  };
  std::optional<Joining> joining_;
  bool standing_by_ = false;
  std::optional<Error> part_lost_;                ///< while it stood by
  bool purging_ = false;                          ///< the valve opens for no feature
  bool purge_cut_ = false;                        ///< a purge was begun, and not all of its shots came
  std::map<std::uint32_t, std::string> told_of_;  ///< by feature: how people were told that it begins
  std::string doing_;
};

}  // namespace gantry::run
