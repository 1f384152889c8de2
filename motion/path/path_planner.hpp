// A path at full speed inside a tolerance: points go in, finished stretches of timed path come out.
//   PathPlanner plan(limits, {.tolerance_mm = 0.05, .speed_mm_s = 50});
//   plan.add(p) ...; plan.finish();  while (plan.take(stretch)) ...          // take() at any time in between
// The path starts and ends at rest. A stretch is handed out when what follows it is known far enough to stop on;
// memory does not grow with the path. Off the RT side; stretches become segments in run.hpp.
#pragma once
#include <deque>

#include "core/error.hpp"
#include "motion/path/jitter.hpp"
#include "motion/path/moves.hpp"
#include "motion/path/outline.hpp"
#include "motion/path/rounding.hpp"
#include "motion/path/timing.hpp"

namespace gantry::motion {

struct PathOptions {
  double tolerance_mm = 0;       ///< how far the path may leave the points' polyline; 0: it rests in every corner
  bool by_vertex = false;        ///< a sharp corner's vertex may be sqrt(2) times as far off, and nothing else counts
  double speed_mm_s = 0;         ///< of the tool, at most
  double tolerance_rad = 1e-3;   ///< the same for rotary axes that follow along
  double window_s = 2;           ///< how far ahead of what is handed out the speed is planned, about
  bool whole_ticks = true;       ///< the last stretch is slowed down so that the path takes whole ticks
  bool leads = false;            ///< before the first and after the last point (lead.hpp), for speeding up and braking
  double lead_in_mm_s = kNoCap;  ///< the first of them is for speeding up to this at most; 0: there is none
};

/// Lengths along the linear axes (the others where there is none); tolerances over all.
[[nodiscard]] Measure measure_of(const Limits& limits, const PathOptions& options);

class PathPlanner {
 public:
  /// Counts of what happened, for tests and reports.
  struct Counts {
    std::size_t curves = 0, windows = 0, second_tries = 0, forced_rests = 0, cells = 0, steps = 0;
    std::size_t corner_rests = 0;  ///< vertices in which it stands because no curve stayed within the tolerance
    std::size_t most_waiting = 0;  ///< curves that waited at once
  };

  PathPlanner(const Limits& limits, const PathOptions& options);

  /// Fault::NoSolution where options or point are no numbers, or the plan cannot be made; the message names the place.
  Result<void> add(const AxisVec& point);
  /// The last point ends the path; a path of no length gives no stretch.
  Result<void> finish();
  /// Instead of points: a path along these curves, which join smoothly, from the first one's begin to the last one's
  /// end.
  Result<void> follow(std::vector<Curve> curves);
  [[nodiscard]] bool take(Stretch& out);
  /// All that is ready, after what `out` holds already.
  void take_all(Stretch& out);

  [[nodiscard]] const Counts& counts() const { return counts_; }
  /// Lengths of the leads: known when the first stretch has come, and when the last one has.
  [[nodiscard]] double lead_in_mm() const { return lead_in_mm_; }
  [[nodiscard]] double lead_out_mm() const { return lead_out_mm_; }

 private:
  /// Speeds over the first of the waiting curves, down to a rest at their end.
  struct Plan {
    std::vector<PaceCell> cells;
    std::vector<PaceNode> nodes;         ///< cells + 1
    std::vector<std::size_t> curve_end;  ///< number of cells up to the end of each curve
  };
  void simplify(bool last);
  Result<void> collect(bool last);
  void add_leads(bool last);
  /// How long a lead has to be for this speed at the path's end, and over how much of it it is bent.
  struct LeadLength {
    double all_mm = 0, bent_mm = 0;
  };
  [[nodiscard]] LeadLength lead_length(const CurveJet& at, double speed_mm_s) const;
  Result<void> look_ahead(bool all);
  Result<void> rest_between(bool all, const Error& why);
  Result<Plan> plan_alone(double share);
  bool join(const Plan& next);
  [[nodiscard]] bool sound(const Plan& plan, const State& from, std::string& reason) const;
  void to_whole_ticks();
  void hand_out(std::size_t curves);

  Limits limits_;
  PathOptions options_;
  Measure measure_;
  Outline fine_, coarse_;
  Jitter small_, large_;
  Rounding rounding_;
  std::vector<Vertex> fine_out_, coarse_out_, small_out_, outline_;
  std::vector<Curve> curves_out_;
  std::deque<Curve> waiting_;
  double waiting_s_ = 0;  ///< rough duration of what waits
  double next_window_s_ = 0;
  State at_{};  ///< speed and acceleration where the waiting curves begin
  Plan plan_;
  double elapsed_s_ = 0;  ///< duration of what has been handed out
  std::size_t points_ = 0;
  AxisVec last_point_{};
  std::deque<Stretch> ready_;
  double lead_in_mm_ = 0, lead_out_mm_ = 0;
  bool led_in_ = false;
  Counts counts_;
};

}  // namespace gantry::motion
