#include "sim/world/deposits.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>

#include "core/new_file.hpp"
#include "recipes/asked_speed.hpp"
#include "sim/world/deposit_speed.hpp"
#include "sim/world/near_line.hpp"

namespace gantry::sim {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// The largest distance of any point from a line, seen from above.
double farthest(std::span<const Vec3> points, const NearLine& line, double at_most = kFar) {
  double worst = 0;
  std::size_t near = 0;
  for (std::size_t i = 0; i < points.size() && worst <= at_most; ++i)
    worst = std::max(worst, line.foot(flat(points[i]), near).distance_mm);
  return worst;
}

double extent(const Shot& shot) {
  double out = 0;
  for (const Vec3& p : shot.path) out = std::max(out, norm(flat(p) - flat(shot.path.front())));
  return out;
}

/// How badly a shot fits a feature: where it begins, and how far it strays. A bead that was cut short fits its own.
double misfit(const Shot& shot, const BoardPlan::Feature& feature, double at_most) {
  const double off = norm(flat(shot.path.front()) - flat(feature.points.front()));
  return off > at_most ? off : std::max(off, farthest(shot.path, NearLine(feature.points), at_most));
}

struct Match {
  int feature = -1;
  double misfit = kFar;
};

/// A shot's own kind decides between features that fit equally well (a dot on the start of a bead).
constexpr double kWrongKind_mm = 0.05;
/// A free feature this much farther away than one that is taken is not meant: the shot is a second one on the same.
constexpr double kSecondShot_mm = 0.2;
/// A bead that ends so near to its end is whole, and what begins there is another one, unless it goes on to that end.
constexpr double kWhole_mm = 0.05;
/// A shot that begins so near to where a bead was cut may go on with it.
constexpr double kJoin_mm = 1;
/// Over so much of a path its direction is taken.
constexpr double kDirection_mm = 0.01;

/// The better fit; of equal ones the first in the recipe.
void keep_better(Match& best, int feature, double misfit) {
  if (misfit < best.misfit || (misfit == best.misfit && feature < best.feature)) best = {feature, misfit};
}

Match match(const BoardPlan& plan, const Starts& starts, const Shot& shot, const std::vector<bool>& taken) {
  const bool moved = extent(shot) > kDotExtent_mm;
  const Vec2 begin = flat(shot.path.front());
  Match free, any;
  starts.nearest_first(begin, kMatch_mm, [&](std::size_t i, double at_least_mm) {
    if (at_least_mm > free.misfit) return false;  // nothing fits better than it begins
    const BoardPlan::Feature& f = plan.features[i];
    if (norm(begin - flat(f.points.front())) > kMatch_mm) return true;
    double fit = misfit(shot, f, kMatch_mm);
    if (fit > kMatch_mm) return true;
    if (f.bead != moved) fit += kWrongKind_mm;
    keep_better(any, static_cast<int>(i), fit);
    if (!taken[i]) keep_better(free, static_cast<int>(i), fit);
    return true;
  });
  if (free.feature >= 0 && free.misfit > any.misfit + kSecondShot_mm) return {};
  return free;
}

/// 0 of one that is still open.
double open_s(const Shot& shot) { return shot.closed_cycle != 0 ? seconds(shot.closed - shot.opened) : 0; }

Deposit deposit_of(const Shot& shot) {
  Deposit d;
  d.kind = extent(shot) > kDotExtent_mm ? "bead" : "dot";
  d.board_mm = shot.path;
  d.opened_cycle = shot.opened_cycle;
  d.closed_cycle = shot.closed_cycle;
  d.gap_mm = shot.path.front().z;
  d.open_s = open_s(shot);
  return d;
}

/// A bead that another shot may go on with.
struct CutBead {
  std::size_t deposit = 0, feature = 0;  ///< indices
  bool whole = false;                    ///< it ends within kWhole_mm of its end
};

/// A closed bead that has hardly begun ends where it is to end, too.
bool ends_short(const Deposit& d, const BoardPlan::Feature& f) {
  return f.bead && (norm(flat(d.board_mm.back()) - flat(f.points.back())) > kWhole_mm ||
                    length_of(d.board_mm) < length_of(f.points) / 2);
}

/// How badly a shot fits as what goes on where this bead was cut.
double misfit_of_join(const Shot& shot, const Deposit& cut, const BoardPlan::Feature& feature) {
  const double apart = norm(flat(shot.path.front()) - flat(cut.board_mm.back()));
  return apart > kJoin_mm ? kFar : std::max(apart, farthest(shot.path, NearLine(feature.points), kMatch_mm));
}

constexpr double kMoves_mm = 0.005;  ///< a dot stands
constexpr double kCrawls_mm = 0.0001;

/// What little was missing of a bead that counts as whole, or a part of that: a shot that moves little, at its height,
/// from where that ended on towards its end, and takes about as long as the bead would. One that all but stands does
/// so, too, where no feature asks for it and it is short: it was cut as soon as it had begun.
bool finishes(const Shot& shot, const Deposit& almost, const BoardPlan::Feature& feature, bool asked_for) {
  constexpr double kHeight_mm = 0.1, kValve_s = 0.05, kCutAtOnce_s = 0.02;
  const double mm = length_of(shot.path);
  const Vec2 end = flat(feature.points.back()), ended = flat(almost.board_mm.back());
  const double was_mm = norm(end - ended), is_mm = norm(end - flat(shot.path.back()));
  const bool moves = mm >= kMoves_mm && was_mm >= kMoves_mm;
  if (mm < kCrawls_mm || mm > 2 * kWhole_mm || (!moves && (asked_for || open_s(shot) > kCutAtOnce_s))) return false;
  return norm(flat(shot.path.front()) - ended) <= kWhole_mm && is_mm < was_mm &&
         std::abs(shot.path.front().z - almost.board_mm.back().z) <= kHeight_mm &&
         (feature.speed_mm_s <= 0 || open_s(shot) <= 2 * mm / feature.speed_mm_s + kValve_s);
}

/// From the end of the first to the start of the second, along the first; negative: the second lies over it.
double missing_mm(const std::vector<Vec3>& first, const std::vector<Vec3>& second) {
  const Vec2 end = flat(first.back());
  const auto before =
      std::find_if(first.rbegin(), first.rend(), [&](const Vec3& p) { return norm(end - flat(p)) > kDirection_mm; });
  const Vec2 step = end - flat(before != first.rend() ? *before : first.front());
  const double length = norm(step);
  const Vec2 apart = flat(second.front()) - end;
  return length > 0 ? dot(apart, step) / length : norm(apart);
}

/// The same of a bead. What lies in front of its start is no part of it: it is from there on that something is missing.
double missing_mm(const Deposit& d, const Shot& shot, const BoardPlan::Feature& f) {
  const Vec2 start = flat(f.points.front());
  const auto next = std::find_if(f.points.begin(), f.points.end(),
                                 [&](const Vec3& p) { return norm(flat(p) - start) > kDirection_mm; });
  if (next == f.points.end()) return missing_mm(d.board_mm, shot.path);
  const auto along_mm = [&](const Vec3& p) {
    return dot(flat(p) - start, flat(*next) - start) / norm(flat(*next) - start);
  };
  const bool in_front = std::all_of(d.board_mm.begin(), d.board_mm.end(), [&](const Vec3& p) {
    return along_mm(p) <= 0 && norm(flat(p) - start) <= kJoin_mm;
  });
  return in_front ? along_mm(shot.path.front()) : missing_mm(d.board_mm, shot.path);
}

void measure(Deposit& d, const BoardPlan::Feature& f) {
  d.error_mm = path_error(d.board_mm, f.points);
  d.gap_mm = f.gap_mm + gap_error(d.board_mm, f.points, f.gap_mm);
}

void join(Deposit& d, const Shot& shot, const BoardPlan::Feature& f) {
  d.joins_mm.push_back(missing_mm(d, shot, f));
  d.board_mm.insert(d.board_mm.end(), shot.path.begin(), shot.path.end());
  d.closed_cycle = shot.closed_cycle;
  d.open_s = shot.closed_cycle != 0 ? d.open_s + open_s(shot) : 0;
  measure(d, f);
}

std::string text(std::span<const Vec3> points) {
  std::string out;
  for (const Vec3& p : points) out += fmt::format("{}{:.6f} {:.6f} {:.6f}", out.empty() ? "" : ";", p.x, p.y, p.z);
  return out;
}

/// The height of a polyline where somebody has come to who goes along it: it may lead over one place twice, at two
/// heights.
class HeightAlong {
 public:
  explicit HeightAlong(std::span<const Vec3> nominal) : line_(nominal), begins_mm_{0} {
    for (std::size_t i = 0; i + 1 < nominal.size(); ++i)
      begins_mm_.push_back(begins_mm_.back() + norm(nominal[i + 1] - nominal[i]));
  }

  /// Where the next point of the path is, which is to be `gap_mm` over it: of the places that are about as near as any,
  /// from above, the one that is as far along the line as the path has gone. Never back, as from behind a turn onto the
  /// leg before it.
  double at(const Vec3& p, double gap_mm) {
    const double ahead_mm = here_mm_ + (last_ ? norm(p - *last_) : 0), least_mm = farthest_mm_ - kBack_mm;
    last_ = p;
    places_.clear();
    std::size_t i = here_;
    while (i > 0 && begins_mm_[i] > least_mm) --i;
    for (; i + 1 < line_.points().size() && begins_mm_[i] <= ahead_mm + kAround_mm; ++i) {
      const NearLine::Foot foot = foot_on(i, flat(p), p.z - gap_mm);
      if (begins_mm_[i] + foot.along_mm >= least_mm) places_.push_back({foot, begins_mm_[i] + foot.along_mm});
    }
    const NearLine::Foot nearest = line_.foot(flat(p), near_);
    double near_mm = nearest.distance_mm + kStrays_mm;
    for (const Place& each : places_) near_mm = std::min(near_mm, each.foot.distance_mm);
    std::optional<Place> best;
    for (const Place& each : places_)
      if (each.foot.distance_mm <= near_mm + kAsNear_mm &&
          (!best || std::abs(each.along_mm - ahead_mm) < std::abs(best->along_mm - ahead_mm)))
        best = each;
    if (!best) best = Place{nearest, begins_mm_[nearest.segment] + nearest.along_mm}, farthest_mm_ = 0;
    here_ = best->foot.segment, here_mm_ = best->along_mm;
    farthest_mm_ = std::max(farthest_mm_, here_mm_);
    return best->foot.z;
  }

 private:
  struct Place {
    NearLine::Foot foot;
    double along_mm = 0;  ///< from the line's begin
  };
  static constexpr double kAround_mm = 3, kBack_mm = 0.1, kAsNear_mm = 0.02;
  static constexpr double kStrays_mm = 0.5;  ///< another pass of the line may be nearer by so much

  /// Of a segment straight up or down the height that is meant, where it has that.
  [[nodiscard]] NearLine::Foot foot_on(std::size_t i, Vec2 p, double height_mm) const {
    NearLine::Foot foot = line_.foot_on(i, p);
    const Vec3 &a = line_.points()[i], &b = line_.points()[i + 1];
    if (flat(a) == flat(b)) {
      foot.z = std::clamp(height_mm, std::min(a.z, b.z), std::max(a.z, b.z));
      foot.along_mm = std::abs(foot.z - a.z);
    }
    return foot;
  }

  NearLine line_;
  std::vector<double> begins_mm_;  ///< of each segment, from the line's begin
  std::optional<Vec3> last_;
  std::size_t near_ = 0, here_ = 0;
  double here_mm_ = 0, farthest_mm_ = 0;
  std::vector<Place> places_;
};

}  // namespace

double path_error(std::span<const Vec3> path, std::span<const Vec3> nominal) {
  return std::max({norm(flat(path.front()) - flat(nominal.front())), norm(flat(path.back()) - flat(nominal.back())),
                   farthest(path, NearLine(nominal)), farthest(nominal, NearLine(path))});
}

double gap_error(std::span<const Vec3> path, std::span<const Vec3> nominal, double gap_mm) {
  HeightAlong line(nominal);
  double worst = 0;
  for (const Vec3& p : path)
    if (const double off = p.z - line.at(p, gap_mm) - gap_mm; std::abs(off) > std::abs(worst)) worst = off;
  return worst;
}

std::vector<Deposit> judge(const BoardPlan& plan, std::span<const std::shared_ptr<const Shot>> shots,
                           std::optional<Vec2> purge_at, const config::Machine* machine) {
  std::vector<bool> taken(plan.features.size(), false);
  const Starts starts = starts_of(plan);
  std::vector<Deposit> out;
  std::vector<CutBead> cuts;
  std::vector<std::vector<const Shot*>> beads;  // by index in `out`: what makes it up
  std::vector<AskedSpeed> asked;                // by the same; 0: no bead's
  for (const auto& shot : shots) {
    if (shot->path.empty()) continue;
    Deposit d = deposit_of(*shot);
    const double from_purge = purge_at && d.kind == "dot" ? norm(flat(shot->path.front()) - *purge_at) : kFar;
    const Match m = match(plan, starts, *shot, taken);
    Match onto;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const BoardPlan::Feature& f = plan.features[cuts[i].feature];
      const Deposit& first = out[cuts[i].deposit];
      if (!cuts[i].whole || finishes(*shot, first, f, m.feature >= 0))
        keep_better(onto, static_cast<int>(i), misfit_of_join(*shot, first, f));
    }
    if (onto.misfit < kMatch_mm && onto.misfit <= m.misfit) {
      const auto cut = cuts.begin() + onto.feature;
      const BoardPlan::Feature& f = plan.features[cut->feature];
      Deposit& first = out[cut->deposit];
      join(first, *shot, f);
      beads[cut->deposit].push_back(shot.get());
      cut->whole = !ends_short(first, f);
      continue;
    }
    if (from_purge < std::min(m.misfit, kMatch_mm)) {
      d.id = d.kind = kPurgeKind;
    } else if (m.feature >= 0) {
      const BoardPlan::Feature& f = plan.features[static_cast<std::size_t>(m.feature)];
      taken[static_cast<std::size_t>(m.feature)] = true;
      d.id = f.id;
      d.kind = f.bead ? "bead" : "dot";
      for (const Vec3& p : f.points) d.nominal_mm.push_back(p + Vec3{0, 0, f.gap_mm});
      d.asked_gap_mm = f.gap_mm;
      measure(d, f);
      if (f.bead) cuts.push_back({out.size(), static_cast<std::size_t>(m.feature), !ends_short(d, f)});
    }
    if (d.kind == "dot") d.board_mm.resize(1);
    const bool bead = d.kind == "bead" && m.feature >= 0;
    beads.push_back({shot.get()});
    const BoardPlan::Feature* f = bead ? &plan.features[static_cast<std::size_t>(m.feature)] : nullptr;
    asked.push_back(f == nullptr ? AskedSpeed{}
                    : machine == nullptr
                        ? AskedSpeed{f->speed_mm_s, f->speed_tolerance}
                        : recipes::asked_speed(*machine, f->points, f->speed_mm_s, f->speed_tolerance));
    out.push_back(std::move(d));
  }
  const double sync_s = machine != nullptr ? seconds(machine->bus.cycle) : 0.001;
  for (std::size_t i = 0; i < out.size(); ++i) out[i].speed = speed_of(beads[i], asked[i], sync_s);
  return out;
}

int feature_begun(const BoardPlan& plan, const Starts& starts, Vec2 at) {
  Match best{-1, kMatch_mm};
  starts.nearest_first(at, kMatch_mm, [&](std::size_t i, double at_least_mm) {
    if (at_least_mm > best.misfit) return false;
    keep_better(best, static_cast<int>(i), norm(at - flat(plan.features[i].points.front())));
    return true;
  });
  return best.feature;
}

Result<void> write_csv(std::span<const Deposit> deposits, const std::string& path) {
  std::string csv =
      "id,kind,opened_cycle,closed_cycle,error_mm,gap_mm,nominal_mm,board_mm,joins_mm,"
      "speed_min_mm_s,speed_max_mm_s,within_5_percent,volume_per_length,open_ms\n";
  for (const Deposit& d : deposits) {
    // Ids are the recipe's and may hold a comma or a quote: RFC 4180, 2.6 and 2.7.
    std::string id = d.id;
    for (std::size_t at = 0; (at = id.find('"', at)) != std::string::npos; at += 2) id.insert(at, 1, '"');
    const std::string error = std::isfinite(d.error_mm) ? fmt::format("{:.6f}", d.error_mm) : std::string();
    const std::string speed = d.speed
                                  ? fmt::format("{:.4f},{:.4f},{:.5f},{:.5f}", d.speed->least_mm_s, d.speed->most_mm_s,
                                                d.speed->within_5_percent, d.speed->volume_per_length)
                                  : std::string(",,,");
    csv += fmt::format("\"{}\",{},{},{},{},{:.6f},{},{},{:.6f},{},{:.6g}\n", id, d.kind, d.opened_cycle, d.closed_cycle,
                       error, d.gap_mm, text(d.nominal_mm), text(d.board_mm), fmt::join(d.joins_mm, ";"), speed,
                       d.open_s * 1e3);
  }
  return write_new_file(path, csv);
}

}  // namespace gantry::sim
