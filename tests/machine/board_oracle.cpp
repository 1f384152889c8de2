#include "tests/machine/board_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

namespace gantry::test {
namespace {

constexpr double kSame_mm = 0.003;  // of a limit: nearer than that nobody can say
constexpr double kNear_mm = 3;      // as far as a board may lie off that nobody has looked at
constexpr std::size_t kWindow = 8;  // cycles over which a speed is taken

double from_line(Vec2 p, const std::vector<Vec2>& line) {
  double best = line.empty() ? 1e9 : norm(p - line.front());
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec2 along = line[i] - line[i - 1];
    const double square = dot(along, along), t = square > 0 ? dot(p - line[i - 1], along) / square : 0;
    best = std::min(best, norm(p - (line[i - 1] + along * std::clamp(t, 0.0, 1.0))));
  }
  return best;
}

std::vector<Vec2> flat(const std::vector<Vec3>& path) {
  std::vector<Vec2> out;
  for (const Vec3& p : path) out.push_back(flat(p));
  return out;
}

/// Path length up to each point.
std::vector<double> lengths(const std::vector<Vec3>& path) {
  std::vector<double> out{0};
  for (std::size_t i = 1; i < path.size(); ++i) out.push_back(out.back() + norm(flat(path[i]) - flat(path[i - 1])));
  return out;
}

double length_of(const std::vector<Vec2>& line) {
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += norm(line[i] - line[i - 1]);
  return sum;
}

/// Time in cycles at which a path has come so far: but for its ends it has a point a cycle.
double cycle_at(const std::vector<double>& to, double length) {
  const auto next = std::lower_bound(to.begin(), to.end(), length);
  if (next == to.begin()) return 0;
  if (next == to.end()) return static_cast<double>(to.size() - 1);
  const auto i = static_cast<std::size_t>(next - to.begin());
  return static_cast<double>(i - 1) + (length - to[i - 1]) / std::max(1e-12, to[i] - to[i - 1]);
}

class OfOne {
 public:
  Verdict verdict = Verdict::Good;
  std::string why;
  bool full = true;

  void limit(double value, double allowed, const char* what) {
    if (value <= allowed - kSame_mm) return;
    note(value <= allowed + kSame_mm ? Verdict::Near : Verdict::Spoilt,
         fmt::format("{} {:.4f} of {:.4f}", what, value, allowed));
  }
  void note(Verdict worse, std::string text) {
    if (verdict == Verdict::Spoilt) return;
    if (worse == Verdict::Spoilt || verdict == Verdict::Good) verdict = worse, why = std::move(text);
  }

  void dot(const Wanted& w, const RawShot& shot) {
    limit(norm(flat(shot.path.front()) - w.points.front()), w.tolerance_mm, "dot beside");
    limit(std::abs(shot.path.front().z - w.gap_mm), w.gap_tolerance_mm, "gap");
    const double lasted_s = static_cast<double>(shot.closed - shot.opened) * 1e-3;
    full = lasted_s >= (w.shot_s > 0 ? w.shot_s : w.dot_s) * 0.95 - 0.002;
    const double off_s = std::abs(lasted_s - w.dot_s);
    if (off_s > w.dot_s * 0.05 + 0.002)
      note(Verdict::Spoilt, fmt::format("a shot of {} s", lasted_s));
    else if (off_s > w.dot_s * 0.05 - 0.001)
      note(Verdict::Near, fmt::format("a shot of {} s", lasted_s));
  }

  void bead(const Wanted& w, const RawShot& shot, const RawShot* undisturbed) {
    const double allowed = w.tolerance_mm + w.corner_mm;
    const std::vector<Vec2> path = flat(shot.path);
    limit(norm(path.front() - w.points.front()), w.tolerance_mm, "start off");
    limit(norm(path.back() - w.points.back()), w.tolerance_mm, "end off");
    double beside = 0, bare = 0, gap = 0;
    for (const Vec3& p : shot.path)
      beside = std::max(beside, from_line(flat(p), w.points)), gap = std::max(gap, std::abs(p.z - w.gap_mm));
    for (std::size_t i = 1; i < w.points.size(); ++i) {
      const Vec2 along = w.points[i] - w.points[i - 1];
      const int steps = std::max(1, static_cast<int>(norm(along) / 0.5));
      for (int k = 0; k <= steps; ++k)
        bare = std::max(bare, from_line(w.points[i - 1] + along * (static_cast<double>(k) / steps), path));
    }
    limit(beside, allowed, "beside");
    limit(bare, allowed, "bare");
    limit(gap, w.gap_tolerance_mm, "gap");
    if (!w.flow_follows_speed) own_speed(w, lengths(shot.path));
    if (undisturbed == nullptr) return;
    const std::vector<double> now = lengths(shot.path), planned = lengths(undisturbed->path);
    // What a valve lays beyond the bead's ends, because its leads do not fit it, does not have to be there.
    const double due = planned.back() - beyond(w.points.front(), w.points[1], flat(undisturbed->path.front())) -
                       beyond(w.points.back(), w.points[w.points.size() - 2], flat(undisturbed->path.back()));
    full = now.back() >= std::min(due, length_of(w.points)) - w.tolerance_mm && !has_hole(w, path);
    if (!full || w.flow_follows_speed) return;
    speed(w, now, planned);
  }

 private:
  /// How far a path's end lies beyond that of a leg.
  static double beyond(Vec2 end, Vec2 within, Vec2 at) {
    const Vec2 out = end - within;
    return std::max(0.0, gantry::dot(at - end, out) / std::max(norm(out), 1e-9));
  }

  /// Where two shots were joined the path goes from the end of one to the start of the other in one step: forwards it
  /// is as long as what is missing.
  bool has_hole(const Wanted& w, const std::vector<Vec2>& path) {
    if (w.joins_mm.empty()) return false;
    double hole = 0;
    for (std::size_t i = 2; i < path.size(); ++i) {
      const Vec2 step = path[i] - path[i - 1], before = path[i - 1] - path[i - 2];
      if (gantry::dot(step, before) > 0 && norm(step) > 1.5 * w.speed_mm_s * 1e-3) hole = std::max(hole, norm(step));
    }
    limit(hole, w.tolerance_mm, "missing at a join");
    return hole > w.tolerance_mm;
  }

  /// By the recipe's speed alone: at least half of a bead is dispensed at it, and nowhere does the needle go on and on
  /// at another.
  void own_speed(const Wanted& w, const std::vector<double>& now) {
    double all_mm = 0, good_mm = 0, low = 0, high = 0;
    std::size_t run = 0, close = 0;  // cycles
    for (std::size_t i = 1; i + kWindow + 1 < now.size(); ++i) {
      const double ratio = (now[i + kWindow] - now[i]) / kWindow / (w.speed_mm_s * 1e-3), step_mm = now[i + 1] - now[i];
      all_mm += step_mm;
      if (std::abs(ratio - 1) <= 0.05) good_mm += step_mm;
      low = run == 0 ? ratio : std::min(low, ratio), high = run == 0 ? ratio : std::max(high, ratio);
      const bool goes_on = std::abs(ratio - 1) > 0.045 && high - low < 0.03 * high;
      run = goes_on ? run + 1 : 0;
      close = std::max(close, run);
      if (std::abs(ratio - 1) > 0.06 && high - low < 0.015 * high && run > 80)
        return note(Verdict::Spoilt, fmt::format("held at {:.2f} of its speed", ratio));
    }
    const double share = all_mm > 0 ? good_mm / all_mm : 1;
    if (share < 0.42)
      note(Verdict::Spoilt, fmt::format("{:.2f} of it at its speed", share));
    else if (share < 0.58 || close > 30)
      note(Verdict::Near, fmt::format("{:.2f} of it at its speed, {} cycles at another", share, close));
  }

  void speed(const Wanted& w, const std::vector<double>& now, const std::vector<double>& planned) {
    double worst = 0;
    for (std::size_t i = 1; i + 3 * kWindow < planned.size(); ++i) {
      const std::size_t from = i + kWindow, to = from + kWindow;  // steady before and behind, too
      bool steady = true;
      for (const std::size_t at : {i, from, to})
        steady = steady && std::abs((planned[at + kWindow] - planned[at]) / kWindow / (w.speed_mm_s * 1e-3) - 1) < 0.02;
      // That a join may be off: with what may be missing there, over which the needle goes in one step.
      const double slack_mm = w.speed_mm_s * 0.5e-3 + 0.02 + w.tolerance_mm;
      for (const double join : w.joins_mm)
        steady = steady && (planned[from] > join + slack_mm || planned[to] < join - slack_mm);
      if (!steady) continue;
      const double took = cycle_at(now, planned[to]) - cycle_at(now, planned[from]);
      worst = std::max(worst, std::abs(static_cast<double>(kWindow) / std::max(took, 1e-9) - 1));
    }
    if (worst > 0.12)
      note(Verdict::Spoilt, fmt::format("speed off by {:.0f} %", worst * 100));
    else if (worst > 0.03)
      note(Verdict::Near, fmt::format("speed off by {:.1f} %", worst * 100));
  }
};

OfOne judge(const Wanted& w, const RawShot& shot, const RawShot* undisturbed) {
  OfOne one;
  w.bead ? one.bead(w, shot, undisturbed) : one.dot(w, shot);
  return one;
}

}  // namespace

std::vector<RawShot> read_shots(const std::string& csv_file) {
  std::vector<RawShot> shots;
  std::ifstream in(csv_file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream rest(line.substr(line.rfind('"') + 2));  // behind the id
    std::string field[7];
    for (std::string& f : field) std::getline(rest, f, ',');
    RawShot shot{std::stoll(field[1]), std::stoll(field[2]), {}};
    std::istringstream points(field[6]);
    for (std::string point; std::getline(points, point, ';');) {
      std::istringstream numbers(point);
      Vec3 p;
      numbers >> p.x >> p.y >> p.z;
      shot.path.push_back(p);
    }
    shots.push_back(std::move(shot));
  }
  return shots;
}

Opinion opinion(const std::vector<Wanted>& wanted, const std::vector<RawShot>& shots,
                const std::vector<RawShot>& undisturbed) {
  Opinion out;
  const auto note = [&](const OfOne& one, std::size_t i) {
    if (one.verdict == Verdict::Good || out.verdict == Verdict::Spoilt) return;
    if (out.verdict == Verdict::Good || one.verdict == Verdict::Spoilt)
      out.verdict = one.verdict, out.why = fmt::format("feature {}: {}", i, one.why);
  };
  const auto planned = [&](std::size_t i) { return undisturbed.size() == wanted.size() ? &undisturbed[i] : nullptr; };
  // Where some are missing a shot is that of the feature that begins nearest to it, and of no other.
  const auto nearest = [&](const RawShot& shot) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < wanted.size(); ++i)
      if (norm(flat(shot.path.front()) - wanted[i].points.front()) <
          norm(flat(shot.path.front()) - wanted[best].points.front()))
        best = i;
    return best;
  };
  bool all_there = true;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    bool there = false;
    for (const RawShot& shot : shots) {
      const bool meant =
          shots.size() == wanted.size()
              ? &shot == &shots[i]
              : nearest(shot) == i && norm(flat(shot.path.front()) - wanted[i].points.front()) < kNear_mm;
      if (!meant) continue;
      const bool moves = norm(flat(shot.path.back()) - flat(shot.path.front())) > 0.2 || shot.path.size() > 3;
      there = there || (moves == wanted[i].bead && judge(wanted[i], shot, planned(i)).full);
    }
    all_there = all_there && there;
  }
  if (shots.size() == wanted.size())
    for (std::size_t i = 0; i < wanted.size(); ++i) note(judge(wanted[i], shots[i], planned(i)), i);
  else
    out.verdict = Verdict::Spoilt, out.why = fmt::format("{} shots for {} features", shots.size(), wanted.size());
  out.board = shots.empty() ? "untouched" : !all_there ? "begun" : out.verdict == Verdict::Good ? "whole" : "defects";
  return out;
}

}  // namespace gantry::test
