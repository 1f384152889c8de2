#include "motion/path/path_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "motion/path/cells.hpp"
#include "motion/path/lead.hpp"
#include "motion/profile/line_bounds.hpp"

namespace gantry::motion {
namespace {

// How the tolerance is shared: leaving out points, in two rounds, and such as jump, in two more; the rest is for
// rounding.
constexpr double kFineShare = 0.02, kCoarseShare = 0.06, kSmallShare = 0.25, kLargeShare = 0.5;
constexpr double kKept = 0.995;           ///< of the tolerance: the path between two bends is not looked at by itself
constexpr double kLeastRounding = 3e-4;   ///< mm: in a smaller tolerance a corner is passed so slowly that it is a rest
constexpr double kLeastTolerance = 1e-9;  ///< mm: what rounding of coordinates leaves of a straight line
constexpr int kMostTries = 6;             ///< to plan one window at full speed
constexpr int kGentlerTries = 6;          ///< and then slower, by this much each time:
constexpr double kGentler = 0.85;
constexpr int kHullFrom = 3;            ///< from this try on the speed is held down between nodes, too
constexpr std::size_t kMostJoints = 8;  ///< at which a new plan is tried to follow an old one
constexpr double kWindowStops = 6;      ///< a window is at least so many times as long as a stop
constexpr double kLongestWindow = 4;    ///< times the usual one
constexpr double kRoomForFade = 0.97, kLeastShare = 0.8;  ///< of the limits, for a plan that follows another hardly
/// What takes longer is divided, so that windows may end on it.
constexpr double kLongestLine_s = 0.25, kLongestBend_s = 0.5;

double total(const std::vector<TimePiece>& pieces) {
  double sum = 0;
  for (const TimePiece& p : pieces) sum += p.duration_s;
  return sum;
}

/// The greatest use of a limit in each cell, at least 1; one more cell at both ends.
std::vector<double> over_limits(std::size_t cells, const std::vector<PaceNode>& nodes, const Inspection& found) {
  std::vector<double> over(cells + 2, 1);
  std::size_t piece = 0;
  for (std::size_t k = 0; k < cells; ++k)
    for (std::size_t n = 0; n < pieces_between(nodes[k], nodes[k + 1]); ++n, ++piece)
      if (piece < found.piece_share.size()) over[k + 1] = std::max(over[k + 1], found.piece_share[piece]);
  return over;
}

/// Cells in which a limit was broken, and their neighbours, get less of it.
void tighten(std::vector<PaceCell>& cells, const std::vector<PaceNode>& nodes, const Inspection& found) {
  const std::vector<double> over = over_limits(cells.size(), nodes, found);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double most = over[k + 1], near = std::max(over[k], over[k + 2]);
    if (most > 1)
      cells[k].share /= std::min(1.5, most * 1.001);
    else if (near > 1)
      cells[k].share /= std::min(1.2, 0.75 + 0.25 * near);
  }
}

/// Where the search does not come below the limits by itself: much less of them, in more cells around each time.
void leave_more(std::vector<PaceCell>& cells, const std::vector<PaceNode>& nodes, const Inspection& found, int round) {
  std::vector<double> over = over_limits(cells.size(), nodes, found);
  std::size_t seen = 0;  // an inspection that came to no end has found its reason where it ended
  for (std::size_t piece = 0; seen < cells.size() && piece < found.piece_share.size(); ++seen)
    piece += pieces_between(nodes[seen], nodes[seen + 1]);
  if (seen < cells.size()) over[seen + 1] = 2;
  const std::size_t around = std::size_t{2} << round;
  std::size_t until = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (over[k + 1] <= 1) continue;
    for (std::size_t n = std::max(until, k > around ? k - around : 0); n < std::min(cells.size(), k + around + 1); ++n)
      cells[n].share *= kGentler;
    until = k + around + 1;
  }
}

/// " before point 12"; curves that are followed as they are have no points.
std::string up_to(std::size_t points) { return points > 0 ? " before point " + std::to_string(points) : ""; }

std::vector<Curve> first(const std::deque<Curve>& from, std::size_t count) {
  return {from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count)};
}

Stretch stretch_of(const std::deque<Curve>& waiting, std::size_t curves, const std::vector<PaceCell>& cells,
                   const std::vector<PaceNode>& nodes) {
  Stretch out;
  out.curves = first(waiting, curves);
  out.pieces = timed(cells, nodes);
  for (const Curve& g : out.curves) out.length_mm += g.length;
  out.duration_s = total(out.pieces);
  return out;
}

}  // namespace

Measure measure_of(const Limits& limits, const PathOptions& o) {
  Measure m;
  m.axes = limits.axes;
  bool any = false;
  for (std::size_t i = 0; i < limits.axes; ++i) any = any || limits.linear[i];
  const double weight = o.tolerance_mm > 0 ? o.tolerance_mm / o.tolerance_rad : 1;
  for (std::size_t i = 0; i < limits.axes; ++i) {
    m.along[i] = limits.linear[i] || !any;
    m.weight[i] = m.along[i] ? 1 : weight;
  }
  return m;
}

PathPlanner::PathPlanner(const Limits& limits, const PathOptions& options)
    : limits_(limits),
      options_(options),
      measure_(measure_of(limits, options)),
      fine_(measure_, std::max(kFineShare * options.tolerance_mm, kLeastTolerance)),
      coarse_(measure_, std::max(kCoarseShare * options.tolerance_mm, kLeastTolerance)),
      small_(measure_, options.tolerance_mm, kSmallShare),
      large_(measure_, options.tolerance_mm, kLargeShare),
      rounding_(measure_, options.tolerance_mm < kLeastRounding ? 0 : kKept * options.tolerance_mm, options.by_vertex) {
  options_.window_s = std::max(options_.window_s, kWindowStops * longest_stop_s(limits, options.speed_mm_s));
  next_window_s_ = options_.window_s;
}

Result<void> PathPlanner::add(const AxisVec& point) {
  if (points_ == 0 && (!(options_.speed_mm_s > 0) || !(options_.tolerance_mm >= 0) ||
                       !std::isfinite(options_.speed_mm_s + options_.tolerance_mm)))
    return fail(Fault::NoSolution, "a path needs a speed above 0 and a tolerance of 0 or more");
  ++points_;
  for (std::size_t i = 0; i < limits_.axes; ++i)
    if (!std::isfinite(point[i]))
      return fail(Fault::NoSolution, "point " + std::to_string(points_) + " of a path is not a number");
  if (points_ > 1) {
    AxisVec step{};
    for (std::size_t i = 0; i < limits_.axes; ++i) step[i] = point[i] - last_point_[i];
    if (along(measure_, step) < 1e-9 && aside(measure_, step) > 1e-9)
      return fail(Fault::NoSolution,
                  "point " + std::to_string(points_) +
                      " of a path turns an axis on the spot; spread the turn over some length, or split the path");
  }
  last_point_ = point;
  fine_out_.clear();
  fine_.add(point, 0, fine_out_);
  simplify(false);
  return outline_.empty() ? Result<void>{} : collect(false);
}

/// What has come out of the first pass goes through the others.
void PathPlanner::simplify(bool last) {
  coarse_out_.clear();
  for (const Vertex& v : fine_out_) coarse_.add(v.q, v.aside_mm, coarse_out_);
  if (last) coarse_.finish(coarse_out_);
  small_out_.clear();
  for (const Vertex& v : coarse_out_) small_.add(v, small_out_);
  if (last) small_.finish(small_out_);
  for (const Vertex& v : small_out_) large_.add(v, outline_);
  if (last) large_.finish(outline_);
}

Result<void> PathPlanner::finish() {
  fine_out_.clear();
  fine_.finish(fine_out_);
  simplify(true);
  return collect(true);
}

Result<void> PathPlanner::follow(std::vector<Curve> curves) {
  curves_out_ = std::move(curves);
  return collect(true);
}

PathPlanner::LeadLength PathPlanner::lead_length(const CurveJet& at, double speed_mm_s) const {
  constexpr double kRoom = 1.05;      // the plan uses a little less than the limits
  constexpr double kStraight = 1e-9;  // 1/mm, of a path that is not bent
  constexpr double kJerkShare = 0.5;  // for the change of curvature; the rest is for speeding up and braking
  constexpr double kLeastBent = 0.1;  // of the straight part
  constexpr double kMostRadii = 2;
  const Bounds b = line_bounds(limits_, at.d1);
  const double line_mm = kRoom * change_length(0, std::min(speed_mm_s, b.v), b.a, b.j);
  const double bend = bend_of(measure_, at);
  if (bend <= kStraight) return {line_mm, 0};
  double v = std::min(speed_mm_s, b.v), bent_mm = kLeastBent * line_mm;
  for (std::size_t i = 0; i < limits_.axes; ++i)
    if (at.d2[i] != 0) v = std::min(v, std::sqrt(limits_.axis[i].a_max / std::abs(at.d2[i])));
  for (std::size_t i = 0; i < limits_.axes; ++i)
    bent_mm = std::max(bent_mm, std::abs(at.d2[i]) * v * v * v / (kJerkShare * limits_.axis[i].j_max));
  bent_mm = bent_over_mm(bend, kMostRadii, bent_mm);
  return {line_mm + bent_mm, bent_mm};
}

void PathPlanner::add_leads(bool last) {
  if (curves_out_.empty()) return;
  if (const double in_mm_s = std::min(options_.lead_in_mm_s, options_.speed_mm_s); !led_in_ && in_mm_s > 0) {
    const CurveJet begin = jet(curves_out_.front(), 0, kMaxAxes);
    const LeadLength length = lead_length(begin, in_mm_s);
    const std::vector<Curve> lead = lead_in(measure_, begin, length.all_mm, length.bent_mm);
    curves_out_.insert(curves_out_.begin(), lead.begin(), lead.end());
    lead_in_mm_ = length_of(lead);
  }
  led_in_ = true;
  if (!last) return;
  Curve& back = curves_out_.back();
  back.rest_after = false;
  const CurveJet end = jet(back, back.length, kMaxAxes);
  const LeadLength length = lead_length(end, options_.speed_mm_s);
  const std::vector<Curve> lead = lead_out(measure_, end, length.all_mm, length.bent_mm);
  curves_out_.insert(curves_out_.end(), lead.begin(), lead.end());
  curves_out_.back().rest_after = true;
  lead_out_mm_ = length_of(lead);
}

Result<void> PathPlanner::collect(bool last) {
  bool laid = true;
  for (const Vertex& v : outline_) laid = laid && rounding_.add(v, curves_out_);
  outline_.clear();
  if (last) laid = laid && rounding_.finish(curves_out_);
  counts_.corner_rests = rounding_.rests();
  if (!laid)
    return fail(Fault::NoSolution,
                "no curve within the tolerance was found for a path" + up_to(points_) + "; give it a larger tolerance");
  if (options_.leads) add_leads(last);
  for (const Curve& g : curves_out_) {
    const double seconds = rough_seconds(g, limits_, options_.speed_mm_s);
    const int parts = std::max(1, static_cast<int>(seconds / (g.straight ? kLongestLine_s : kLongestBend_s)));
    for (int n = 0; n < parts; ++n) {
      // A curve of many windows is not planned as one: work would grow with its square.
      if (waiting_s_ > next_window_s_ + kLongestWindow * options_.window_s)
        if (auto ok = look_ahead(false); !ok) return ok;
      waiting_s_ += seconds / parts;
      Curve& part = waiting_.emplace_back(g);
      if (parts == 1) break;
      if (g.straight) {
        part.length = g.length / parts;
        for (std::size_t i = 0; i < limits_.axes; ++i) {
          part.c[0][i] = g.c[0][i] + g.c[1][i] * n / parts;
          part.c[1][i] = g.c[1][i] / parts;
        }
      } else {
        part = part_of(g, g.length * n / parts, n + 1 == parts ? g.length : g.length * (n + 1) / parts);
      }
      part.rest_after = g.rest_after && n + 1 == parts;
    }
    ++counts_.curves;
    counts_.most_waiting = std::max(counts_.most_waiting, waiting_.size());
    if (g.rest_after) {
      if (auto ok = look_ahead(true); !ok) return ok;
    } else if (waiting_s_ > next_window_s_) {
      if (auto ok = look_ahead(false); !ok) return ok;
    }
  }
  curves_out_.clear();
  if (last && !waiting_.empty()) return look_ahead(true);
  return {};
}

bool PathPlanner::sound(const Plan& plan, const State& from, std::string& reason) const {
  const Inspection found =
      inspect(stretch_of(waiting_, plan.curve_end.size(), plan.cells, plan.nodes), limits_, options_.speed_mm_s, from);
  if (!found.sound) reason = found.reason;
  return found.sound;
}

// Over all waiting curves, from rest or from a start that is free. Where the inspection finds more than the limits, the
// cells around get a smaller share. share: what is used of the limits at most, 1 or less.
Result<PathPlanner::Plan> PathPlanner::plan_alone(double share) {
  const std::vector<Curve> curves = first(waiting_, waiting_.size());
  CellGrid grid = divide(curves, limits_, options_.speed_mm_s, at_.v);
  for (PaceCell& c : grid.cells) c.share = share;
  PaceProblem problem{std::move(grid.cells), limits_, options_.speed_mm_s, at_.v <= 0, false};
  ++counts_.windows;
  counts_.cells += problem.cells.size();
  Pace pace;
  std::string reason = "no speed was found";
  for (int round = 0; round < kMostTries + kGentlerTries; ++round) {
    problem.hull = problem.hull || round >= kHullFrom;
    Pace next = fastest(problem, round > 0 && round < kMostTries ? &pace : nullptr);
    counts_.steps += static_cast<std::size_t>(next.steps);
    counts_.second_tries += round > 0;
    if (!next.solved) {
      for (PaceCell& c : problem.cells) c.share *= 0.95;
      continue;
    }
    pace = std::move(next);
    const State from = at_.v <= 0 ? State{} : State{0, pace.nodes.front().v, pace.nodes.front().a};
    const Inspection found =
        inspect(stretch_of(waiting_, curves.size(), problem.cells, pace.nodes), limits_, options_.speed_mm_s, from);
    if (found.sound) return Plan{std::move(problem.cells), std::move(pace.nodes), std::move(grid.curve_end)};
    reason = found.reason;
    if (found.only_speed && !problem.hull)
      problem.hull = true;  // not a smaller share, with which the whole neighbourhood would be slower
    else if (round + 1 < kMostTries)
      tighten(problem.cells, pace.nodes, found);
    else
      leave_more(problem.cells, pace.nodes, found, round + 1 - kMostTries);
  }
  return fail(Fault::NoSolution, "no speed within the limits was found for a path" + up_to(points_) + " (" + reason +
                                     "); lower its speed");
}

// Both plans are the fastest, the one with a rest at its end, the other without a past; in between they meet. At the
// joint of curves where they differ least the old one ends and the new one begins, and what is left of the difference
// fades out.
bool PathPlanner::join(const Plan& next) {
  struct Candidate {
    std::size_t curves;
    double off;
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < plan_.curve_end.size(); ++k) {
    const PaceNode x = k == 0 ? PaceNode{at_.v, at_.a} : plan_.nodes[plan_.curve_end[k - 1]];
    const PaceNode y = next.nodes[k == 0 ? 0 : next.curve_end[k - 1]];
    candidates.push_back({k, (std::abs(x.v - y.v) + 0.01 * std::abs(x.a - y.a)) / std::max(x.v, 1e-9)});
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.off < b.off; });
  // The best ones, and the best of each part of the window: what spoils one place spoils those around it, too.
  std::array<bool, kMostJoints> part_taken{};
  std::size_t kept = std::min(kMostJoints, candidates.size());
  for (std::size_t n = kept; n < candidates.size(); ++n)
    if (bool& taken = part_taken[candidates[n].curves * kMostJoints / plan_.curve_end.size()]; !taken)
      taken = true, candidates[kept++] = candidates[n];
  candidates.resize(kept);
  std::string reason;
  for (const double fade_s : {0.03, 0.1, 0.01, 0.003, 0.3})
    for (const Candidate& c : candidates) {
      const std::size_t old_cells = c.curves == 0 ? 0 : plan_.curve_end[c.curves - 1];
      const std::size_t new_cells = c.curves == 0 ? 0 : next.curve_end[c.curves - 1];
      Plan joined;
      joined.cells.assign(plan_.cells.begin(), plan_.cells.begin() + static_cast<std::ptrdiff_t>(old_cells));
      joined.nodes.assign(plan_.nodes.begin(), plan_.nodes.begin() + static_cast<std::ptrdiff_t>(old_cells));
      joined.curve_end.assign(plan_.curve_end.begin(), plan_.curve_end.begin() + static_cast<std::ptrdiff_t>(c.curves));
      const PaceNode here = old_cells == 0 ? PaceNode{at_.v, at_.a} : plan_.nodes[old_cells];
      const double b_off = here.v * here.v - next.nodes[new_cells].v * next.nodes[new_cells].v;
      const double a_off = here.a - next.nodes[new_cells].a;
      const double fade = std::max(fade_s * here.v, 1e-9);
      double s = 0;
      for (std::size_t n = new_cells; n < next.nodes.size(); ++n) {
        PaceNode x = next.nodes[n];
        if (const double r = s / fade; r < 1 && x.v > 0) {
          // Quintic fades of a value and of a slope; a = (v^2)'/2.
          const double value = 1 - r * r * r * (10 - r * (15 - 6 * r)), value_slope = -30 * r * r * (1 - r) * (1 - r);
          const double slope = r * (1 - r * r * (6 - r * (8 - 3 * r)));
          const double slope_slope = 1 - r * r * (18 - r * (32 - 15 * r));
          const double b = x.v * x.v + b_off * value + 2 * a_off * fade * slope;
          if (!(b > 0)) break;
          x.v = std::sqrt(b);
          x.a += 0.5 * b_off * value_slope / fade + a_off * slope_slope;
        }
        joined.nodes.push_back(x);
        if (n < next.cells.size()) s += next.cells[n].length;
      }
      joined.cells.insert(joined.cells.end(), next.cells.begin() + static_cast<std::ptrdiff_t>(new_cells),
                          next.cells.end());
      for (std::size_t k = c.curves; k < next.curve_end.size(); ++k)
        joined.curve_end.push_back(next.curve_end[k] - new_cells + old_cells);
      if (joined.nodes.size() != joined.cells.size() + 1 || !sound(joined, at_, reason)) continue;
      plan_ = std::move(joined);
      return true;
    }
  return false;
}

Result<void> PathPlanner::look_ahead(bool all) {
  Result<Plan> next = plan_alone(1);
  if (!next) return rest_between(all, next.error());
  bool joined = at_.v <= 0 || join(*next);
  if (!joined && !all && waiting_s_ < kLongestWindow * options_.window_s) {
    next_window_s_ = waiting_s_ + 0.3 * options_.window_s;
    return {};
  }
  // A new plan that uses all of the limits leaves no room for what is to fade: a slower one does.
  for (double share = kRoomForFade; !joined && share > kLeastShare; share *= kRoomForFade)
    if (next = plan_alone(share); next) joined = join(*next);
  if (at_.v <= 0) {
    plan_ = std::move(*next);
  } else if (!joined) {
    // The old plan stands: it ends in a rest.
    ++counts_.forced_rests;
    hand_out(plan_.curve_end.size());
    at_ = {};
    plan_ = {};
    return waiting_.empty() ? Result<void>{} : look_ahead(all);
  }
  if (all) {
    if (options_.whole_ticks) to_whole_ticks();
    hand_out(plan_.curve_end.size());
    at_ = {};
    plan_ = {};
    waiting_s_ = 0;
    next_window_s_ = options_.window_s;
    return {};
  }
  // What is handed out lies before the last part, in which the tool comes to a rest that is only assumed.
  const std::vector<TimePiece> pieces = timed(plan_.cells, plan_.nodes);
  const double seconds = total(pieces), until = seconds - std::max(0.4 * seconds, 0.5 * options_.window_s);
  double t = 0;
  std::size_t piece = 0, cell = 0, curves = 0;
  for (std::size_t k = 0; k < plan_.curve_end.size(); ++k) {
    for (; cell < plan_.curve_end[k]; ++cell)
      for (std::size_t n = 0; n < pieces_between(plan_.nodes[cell], plan_.nodes[cell + 1]); ++n)
        t += pieces[piece++].duration_s;
    if (t <= until) curves = k + 1;
  }
  hand_out(curves);
  next_window_s_ = waiting_s_ + 0.5 * options_.window_s;
  return {};
}

// Where no speed is found over what waits, the tool stands in between: at the end of the plan that it follows, else
// in the middle of the curves.
Result<void> PathPlanner::rest_between(bool all, const Error& why) {
  if (at_.v > 0) {
    ++counts_.forced_rests;
    hand_out(plan_.curve_end.size());
    at_ = {}, plan_ = {};
    return waiting_.empty() ? Result<void>{} : look_ahead(all);
  }
  if (waiting_.size() < 2) return tl::unexpected(why);
  ++counts_.forced_rests;
  const auto half = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_.size() / 2);
  std::deque<Curve> later(half, waiting_.end());
  waiting_.erase(half, waiting_.end());
  waiting_.back().rest_after = true;
  if (auto ok = look_ahead(true); !ok) return ok;
  waiting_ = std::move(later);
  waiting_s_ = 0;
  for (const Curve& g : waiting_) waiting_s_ += rough_seconds(g, limits_, options_.speed_mm_s);
  return look_ahead(all);
}

// The plan times 1 - e where it has left its start: slower by less than a tick.
void PathPlanner::to_whole_ticks() {
  const double tick = limits_.tick_s, seconds = total(timed(plan_.cells, plan_.nodes));
  const double goal = std::ceil((elapsed_s_ + seconds) / tick - 1e-6) * tick - elapsed_s_;
  double length = 0;
  for (const PaceCell& c : plan_.cells) length += c.length;
  const double rise = at_.v > 0 ? 0.5 * length : 0;
  const auto slower = [&](double e) {
    Plan out = plan_;
    double s = 0;
    for (std::size_t n = 0; n < out.nodes.size(); ++n) {
      const double r = rise > 0 ? std::min(1.0, s / rise) : 1;
      const double part = r * r * r * (10 - r * (15 - 6 * r));
      const double slope = rise > 0 && r < 1 ? 30 * r * r * (1 - r) * (1 - r) / rise : 0;
      PaceNode& x = out.nodes[n];
      x.a = x.a * (1 - e * part) - 0.5 * e * slope * x.v * x.v;
      x.v *= std::sqrt(1 - e * part);
      if (n < out.cells.size()) s += out.cells[n].length;
    }
    return out;
  };
  // From rest all of it is slower alike, by 1 / sqrt(1 - e): what lasts less than half a tick may need more than a
  // half.
  double low = -1e-9, high = std::max(0.5, 1 - 0.999 * seconds * seconds / (goal * goal));
  for (int n = 0; n < 70; ++n) {
    const double middle = (low + high) / 2;
    const Plan trial = slower(middle);
    (total(timed(trial.cells, trial.nodes)) < goal ? low : high) = middle;
  }
  Plan best = slower(high);
  std::string reason;
  if (sound(best, at_, reason)) plan_ = std::move(best);
}

void PathPlanner::hand_out(std::size_t curves) {
  if (curves == 0) return;
  const std::size_t cells = plan_.curve_end[curves - 1];
  const auto end = static_cast<std::ptrdiff_t>(cells);
  const std::vector<PaceCell> some_cells(plan_.cells.begin(), plan_.cells.begin() + end);
  const std::vector<PaceNode> some_nodes(plan_.nodes.begin(), plan_.nodes.begin() + end + 1);
  Stretch out = stretch_of(waiting_, curves, some_cells, some_nodes);
  elapsed_s_ += out.duration_s;
  for (const Curve& g : out.curves) waiting_s_ -= rough_seconds(g, limits_, options_.speed_mm_s);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(curves));
  at_ = {0, plan_.nodes[cells].v, plan_.nodes[cells].a};
  plan_.cells.erase(plan_.cells.begin(), plan_.cells.begin() + end);
  plan_.nodes.erase(plan_.nodes.begin(), plan_.nodes.begin() + end);
  plan_.curve_end.erase(plan_.curve_end.begin(), plan_.curve_end.begin() + static_cast<std::ptrdiff_t>(curves));
  for (std::size_t& n : plan_.curve_end) n -= cells;
  ready_.push_back(std::move(out));
}

bool PathPlanner::take(Stretch& out) {
  if (ready_.empty()) return false;
  out = std::move(ready_.front());
  ready_.pop_front();
  return true;
}

void PathPlanner::take_all(Stretch& out) {
  for (Stretch& part : ready_) {
    for (TimePiece& p : part.pieces) p.s += out.length_mm;
    out.curves.insert(out.curves.end(), part.curves.begin(), part.curves.end());
    out.pieces.insert(out.pieces.end(), part.pieces.begin(), part.pieces.end());
    out.length_mm += part.length_mm, out.duration_s += part.duration_s;
  }
  ready_.clear();
}

}  // namespace gantry::motion
