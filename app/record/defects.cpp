#include "app/record/defects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <string>
#include <unordered_map>
#include <variant>

#include "app/record/from_above.hpp"
#include "app/record/own_deposits.hpp"
#include "recipes/valve_leads.hpp"

namespace gantry::record {
namespace {

using job::FeatureState;
using Kind = Defect::Kind;

bool has_shut(const Deposit& shot) { return shot.closed_cycle != 0; }

constexpr const char* kStillOpen = "its shot was still open when the job ended";
constexpr std::array<std::string_view, 9> kKinds{"missing", "cut",   "beside",    "gap", "amount",
                                                 "speed",   "extra", "reference", "late"};

/// One job's features, one after the other.
class Judge {
 public:
  Judge(const JobResult& result, const recipes::Recipe& recipe, const Seen& seen, double cycle_s)
      : result_(result),
        recipe_(recipe),
        before_(seen.before),
        cycle_s_(cycle_s),
        own_(own_deposits(result, recipe, seen.features)) {
    for (const Deposit& d : result.deposits) laid_.push_back(&d);
    for (const Own& each : own_) laid_[each.index] = &each.deposit;
    for (const Deposit* d : laid_)
      if (on_feature(*d)) deposits_.emplace(d->id, d);
  }

  void feature(std::size_t index, FeatureState state) {
    if (state == FeatureState::LeftOut) return left_out(index);
    if (is_as_before(index, state)) return;
    std::visit([&](const auto& each) { judge(each, state); }, recipe_.features[index]);
  }

  void off_speed(const job::OffSpeed& seen) {
    const auto& bead = std::get<recipes::Bead>(recipe_.features[seen.feature]);
    if (seen.stands > 0)
      add(bead.id, Kind::Speed,
          job::standstill_in_words(seen.stands, seen.stands_at_mm, bead,
                                   *recipes::find_material(recipe_, bead.material)));
    if (seen.stands > 0 && seen.due_mm <= 0) return;
    add(bead.id, Kind::Speed,
        fmt::format("dispensed at {:.3g} mm/s instead of {:.3g} mm/s, {:.1f} mm of it off its speed", seen.worst_mm_s,
                    seen.asked_mm_s, seen.length_mm));
  }

  /// A speed that was left besides was told already.
  void slow(const job::SlowBead& seen) {
    if (seen.narrowly) return;  // as planned it is good; a world may see that it was not
    const std::string& id = recipes::id_of(recipe_.features[seen.feature]);
    if (!told(id, {Kind::Speed})) add(id, Kind::Speed, job::in_words(seen, recipe_));
  }

  /// By the world's log, whatever was planned; of a bead that was cut the rest says nothing.
  void speed_seen(std::size_t index) {
    const auto* bead = std::get_if<recipes::Bead>(&recipe_.features[index]);
    const recipes::Material* m = bead != nullptr ? recipes::find_material(recipe_, bead->material) : nullptr;
    if (m == nullptr || m->flow_follows_speed) return;
    const auto found = deposits_.find(bead->id);
    if (found == deposits_.end() || !found->second->speed) return;
    const sim::DepositSpeed& seen = *found->second->speed;
    const bool held = seen.held_mm_s && std::abs(*seen.held_mm_s - m->speed) > m->speed_tolerance * m->speed;
    if ((!held && !seen.sag && seen.within_tolerance >= SteadySpeed::kEnough) ||
        told(bead->id, {Kind::Speed, Kind::Cut}))
      return;
    if (held)
      add(bead->id, Kind::Speed,
          fmt::format("the needle went at {:.3g} mm/s instead of {:.3g} mm/s for 50 ms and more; {:.3g} % are allowed",
                      *seen.held_mm_s, m->speed, m->speed_tolerance * 100));
    else if (seen.sag)
      add(bead->id, Kind::Speed,
          fmt::format("the needle slowed down to {:.3g} mm/s instead of {:.3g} mm/s, and was too slow for {:.0f} ms, "
                      "longer than a corner takes; {:.3g} % are allowed",
                      seen.sag->low_mm_s, m->speed, seen.sag->lasts_s * 1e3, m->speed_tolerance * 100));
    else
      add(bead->id, Kind::Speed,
          fmt::format("the needle went at its {:.3g} mm/s, but for {:.3g} %, along {:.0f} % of its length", m->speed,
                      m->speed_tolerance * 100, seen.within_tolerance * 100));
  }

  /// By the world's log. What was cut and joined may have stood in two parts.
  void stand_seen(std::size_t index, double sets_out_s) {
    const auto* bead = std::get_if<recipes::Bead>(&recipe_.features[index]);
    const recipes::Material* m = bead != nullptr ? recipes::find_material(recipe_, bead->material) : nullptr;
    if (m == nullptr || m->start_dwell_s <= 0 || m->flow_follows_speed) return;
    const auto found = deposits_.find(bead->id);
    if (found == deposits_.end() || !found->second->speed || !found->second->joins_mm.empty()) return;
    const double stood_s = found->second->speed->stood_s;
    // Where it was when is known to a cycle, when its valve opened to another one.
    const double less_s = m->speed_tolerance * m->start_dwell_s + 2 * cycle_s_,
                 more_s = less_s + sets_out_s + sim::kSetOut_mm / m->speed;
    const bool good = stood_s >= m->start_dwell_s - less_s && stood_s <= m->start_dwell_s + more_s;
    if (good || told(bead->id, {Kind::Cut})) return;
    add(bead->id, Kind::Amount,
        fmt::format("the needle stood over its start for {:.3g} ms instead of {:.3g} ms with the valve open; {:.3g} % "
                    "are allowed",
                    stood_s * 1e3, m->start_dwell_s * 1e3, m->speed_tolerance * 100));
  }

  /// Whatever was meant when it was resumed: an override, and the planning, may have made the way to the join longer.
  void joined_late(std::size_t index) {
    const auto* bead = std::get_if<recipes::Bead>(&recipe_.features[index]);
    const recipes::Material* m = bead != nullptr ? recipes::find_material(recipe_, bead->material) : nullptr;
    if (m == nullptr) return;
    for (const Joined& join : result_.joined)
      if (join.feature == bead->id && join.after_s > m->rejoin_within_s)
        add(bead->id, Kind::Late,
            fmt::format("joined {:.2f} s after its valve had shut; material '{}' is to be joined within {:.6g} s "
                        "('rejoin_within')",
                        join.after_s, m->name, m->rejoin_within_s));
  }

  void extra() {
    for (const Deposit* d : laid_)
      if (d->id.empty() && !d->board_mm.empty() && used_.count(d) == 0) add_extra(*d);
  }

  void reference() {
    if (recipe_.marks.empty() && recipe_.placement != recipes::Placement::Fixture)
      add("", Kind::Reference,
          "nothing said where the board lay; give the recipe marks, or `placement: fixture` where a fixture holds it");
  }

  [[nodiscard]] std::vector<Defect> defects() && { return std::move(defects_); }

 private:
  /// It lies there whole by a job before, and this one, which was to dispense it once more, has not come to it.
  [[nodiscard]] bool is_as_before(std::size_t index, FeatureState state) const {
    const bool reached = state == FeatureState::Done || (state != FeatureState::Open && !result_.has_world);
    return !reached && before_.is_whole(index) && !deposits_.contains(recipes::id_of(recipe_.features[index]));
  }

  [[nodiscard]] bool told(const std::string& id, std::initializer_list<Kind> kinds) const {
    return std::any_of(defects_.begin(), defects_.end(), [&](const Defect& d) {
      return d.feature == id && std::find(kinds.begin(), kinds.end(), d.kind) != kinds.end();
    });
  }

  void add(const std::string& id, Kind kind, std::string message) {
    if (const auto why = result_.stays_cut.find(id); kind == Kind::Cut && why != result_.stays_cut.end())
      message += "; not joined: " + why->second;
    defects_.push_back({id, kind, std::move(message)});
  }

  /// What stands of a feature for sure; null: nothing, and it was told.
  const Deposit* deposit_of(const std::string& id, FeatureState state) {
    if (!result_.has_world) {
      if (state == FeatureState::Open) add(id, Kind::Missing, "not dispensed");
      if (state == FeatureState::Interrupted) add(id, Kind::Cut, "cut by a stop, or kept dry by it");
      if (state == FeatureState::Doubtful) add(id, Kind::Cut, "nobody saw how far it came");
      return nullptr;
    }
    const auto found = deposits_.find(id);
    if (found != deposits_.end()) return found->second;
    add(id, Kind::Missing, state == FeatureState::Open ? "not dispensed" : "nothing of it lies on the board");
    return nullptr;
  }

  /// What lies there of this job is one too many.
  void left_out(std::size_t index) {
    const std::string& id = recipes::id_of(recipe_.features[index]);
    if (const auto found = deposits_.find(id); found != deposits_.end())
      add(id, Kind::Extra, "dispensed by a job that leaves it out");
  }

  void judge(const recipes::Dot& dot, FeatureState state) {
    const Deposit* d = deposit_of(dot.id, state);
    const recipes::Material* m = recipes::find_material(recipe_, dot.material);
    if (d == nullptr || m == nullptr || d->nominal_mm.empty()) return;
    const auto full = [&](const Deposit& shot) {
      return has_shut(shot) && shot.open_s >= m->dot_time - recipes::dot_time_tolerance_s(*m, cycle_s_);
    };
    if (state != FeatureState::Done && !full(*d)) {
      const Vec3 at = d->nominal_mm.front();
      if (!given_again(
              [&](const Deposit& o) { return full(o) && from_above_mm(o.board_mm.front(), at) <= m->tolerance_mm; }))
        return add(dot.id, Kind::Cut,
                   has_shut(*d)
                       ? fmt::format("a shot of {:.3g} ms instead of {:.3g} ms", d->open_s * 1e3, m->dot_time * 1e3)
                       : std::string(kStillOpen));
      return add_extra(*d);
    }
    if (d->error_mm > m->tolerance_mm) add(dot.id, Kind::Beside, beside(d->error_mm, m->tolerance_mm));
    gap(dot.id, *d, *m);
    amount(dot.id, *d, *m);
  }

  void judge(const recipes::Bead& bead, FeatureState state) {
    const Deposit* d = deposit_of(bead.id, state);
    const recipes::Material* m = recipes::find_material(recipe_, bead.material);
    if (d == nullptr || m == nullptr || d->nominal_mm.empty() || d->board_mm.empty()) return;
    const Vec3 start = d->nominal_mm.front(), end = d->nominal_mm.back();
    const double start_off_mm = from_above_mm(d->board_mm.front(), start),
                 end_off_mm = from_above_mm(d->board_mm.back(), end),
                 allowed_mm = m->tolerance_mm + bead.corner_tolerance;
    // Where the valve shuts early, perhaps in mid curve, the needle is as near to its path as anywhere on it.
    const double end_allowed_mm = m->early_off > 0 ? allowed_mm : m->tolerance_mm;
    const bool ends = start_off_mm <= m->tolerance_mm && end_off_mm <= end_allowed_mm;
    if ((!ends || !(d->error_mm <= allowed_mm)) && state != FeatureState::Done) {
      const double nearly_all_mm =
          length_from_above_mm(d->nominal_mm) - 2 * allowed_mm * static_cast<double>(d->nominal_mm.size());
      if (!given_again([&](const Deposit& o) {
            return from_above_mm(o.board_mm.front(), start) <= m->tolerance_mm &&
                   from_above_mm(o.board_mm.back(), end) <= end_allowed_mm &&
                   length_from_above_mm(o.board_mm) >= nearly_all_mm;
          }))
        return add(
            bead.id, Kind::Cut,
            fmt::format("cut by a stop: {:.2f} of its {:.2f} mm lie; it starts {:.2f} mm from its start and ends "
                        "{:.2f} mm from its end, straight across",
                        length_from_above_mm(d->board_mm), length_from_above_mm(d->nominal_mm), start_off_mm,
                        end_off_mm));
      return add_extra(*d);
    }
    joins(bead.id, *d, *m);
    const auto joined = static_cast<std::size_t>(std::ranges::count(result_.joined, bead.id, &Joined::feature));
    // A valve that was told to shut before it had opened has laid nothing that the join goes on from.
    if (start_off_mm > m->tolerance_mm && joined > d->joins_mm.size())
      add(bead.id, Kind::Cut,
          fmt::format("{:.3f} mm are missing at its start: nothing lies before where it was cut and joined again",
                      start_off_mm));
    else if (!ends)
      add(bead.id, Kind::Beside,
          fmt::format(
              "its start lies {:.3f} mm, its end {:.3f} mm beside its place; {:.3g} mm and {:.3g} mm are allowed",
              start_off_mm, end_off_mm, m->tolerance_mm, end_allowed_mm));
    else if (!(d->error_mm <= allowed_mm))
      add(bead.id, Kind::Beside, beside(d->error_mm, allowed_mm));
    gap(bead.id, *d, *m);
  }

  /// A stop that took the valve's command back lets it be given again: then the whole of it lies over the drop that had
  /// come out.
  template <class Whole>
  bool given_again(Whole&& whole) {
    for (const Deposit* d : laid_)
      if (d->id.empty() && !d->board_mm.empty() && used_.count(d) == 0 && has_shut(*d) && whole(*d))
        return used_.insert(d).second;
    return false;
  }

  void add_extra(const Deposit& d) {
    add("", Kind::Extra,
        fmt::format("a {} at ({:.2f}, {:.2f}) mm that no feature asks for", d.kind, d.board_mm.front().x,
                    d.board_mm.front().y));
  }

  void joins(const std::string& id, const Deposit& d, const recipes::Material& m) {
    for (const double missing_mm : d.joins_mm)
      if (missing_mm > m.tolerance_mm)
        add(id, Kind::Cut, fmt::format("{:.3f} mm are missing where it was cut and joined again", missing_mm));
      else if (missing_mm < -m.tolerance_mm)
        add(id, Kind::Extra, fmt::format("{:.3f} mm lie twice where it was cut and joined again", -missing_mm));
  }

  void gap(const std::string& id, const Deposit& d, const recipes::Material& m) {
    if (std::abs(d.gap_mm - m.gap) <= m.gap_tolerance_mm) return;
    add(id, Kind::Gap,
        fmt::format("dispensed at a gap of {:.3f} mm instead of {:.3f} mm; {:.3g} mm are allowed", d.gap_mm, m.gap,
                    m.gap_tolerance_mm));
  }

  void amount(const std::string& id, const Deposit& d, const recipes::Material& m) {
    if (!has_shut(d)) return add(id, Kind::Amount, kStillOpen);
    if (std::abs(d.open_s - m.dot_time) <= recipes::dot_time_tolerance_s(m, cycle_s_)) return;
    const double more = d.open_s / m.dot_time - 1;
    add(id, Kind::Amount,
        fmt::format("a shot of {:.3g} ms instead of {:.3g} ms, {:.0f} % {}; {:.3g} % are allowed. Look at "
                    "`valve_open_lead` and `valve_close_lead` of '{}'",
                    d.open_s * 1e3, m.dot_time * 1e3, std::abs(more) * 100, more < 0 ? "less" : "more",
                    m.speed_tolerance * 100, m.name));
  }

  static std::string beside(double off_mm, double allowed_mm) {
    return fmt::format("{:.3f} mm beside its place; {:.3g} mm are allowed", off_mm, allowed_mm);
  }

  const JobResult& result_;
  const recipes::Recipe& recipe_;
  const OnBoard& before_;
  double cycle_s_;
  std::vector<Own> own_;
  std::vector<const Deposit*> laid_;  ///< in their order, each as the one of its feature
  std::vector<Defect> defects_;
  std::unordered_map<std::string, const Deposit*> deposits_;
  std::set<const Deposit*> used_;  ///< of those on no feature: given again
};

Defect of_a_job_before(Defect defect) {
  constexpr std::string_view kBefore = "by a job before: ";
  if (!defect.message.starts_with(kBefore)) defect.message.insert(0, kBefore);
  return defect;
}

}  // namespace

Judgement judge_board(const JobResult& result, const recipes::Recipe& recipe, const Seen& seen, double cycle_s) {
  const bool dispensed = std::any_of(result.deposits.begin(), result.deposits.end(),
                                     [](const Deposit& d) { return d.kind != sim::kPurgeKind; });
  // A valve that a stop shuts before it has moved lets nothing out: the world knows, and nobody else.
  const bool begun =
      dispensed || std::any_of(seen.features.begin(), seen.features.end(), [&](FeatureState s) {
        return s != FeatureState::Open && s != FeatureState::LeftOut && (s == FeatureState::Done || !result.has_world);
      });
  if (!begun && result.exit_code != ExitCode::Done) return {};
  Judge judge(result, recipe, seen, cycle_s);
  for (std::size_t i = 0; i < seen.features.size(); ++i) judge.feature(i, seen.features[i]);
  for (const job::OffSpeed& each : seen.off_speed) judge.off_speed(each);
  for (const job::SlowBead& each : seen.slow_beads)
    if (const FeatureState state = seen.features[each.feature];
        state != FeatureState::Open && state != FeatureState::LeftOut)
      judge.slow(each);
  for (std::size_t i = 0; i < seen.features.size(); ++i)
    if (seen.features[i] != FeatureState::LeftOut) {
      judge.speed_seen(i), judge.stand_seen(i, seen.sets_out_s);
      judge.joined_late(i);
    }
  judge.extra();
  judge.reference();
  std::vector<Defect> defects = std::move(judge).defects();
  bool lacks = std::any_of(defects.begin(), defects.end(), is_lacking);
  for (std::size_t i = 0; i < seen.features.size(); ++i)
    lacks = lacks || (seen.features[i] == FeatureState::LeftOut && !seen.before.is_whole(i));
  for (const Defect& old : seen.before.defects)
    if (std::none_of(defects.begin(), defects.end(),
                     [&](const Defect& d) { return d.feature == old.feature && d.kind == old.kind; }))
      defects.push_back(of_a_job_before(old));
  const bool good = defects.empty();
  return {!begun ? Board::Untouched : lacks ? Board::Begun : good ? Board::Whole : Board::Defects, std::move(defects)};
}

double sets_out_s(const config::Machine& machine) {
  double longest_s = 0;
  for (const config::Axis& axis : machine.axes) {
    if (axis.rotary || axis.kind != config::AxisKind::Streamed) continue;
    const double d = sim::kSetOut_mm + 1 / axis.counts_per_unit;
    const double from_rest_s = std::cbrt(6 * d / axis.j_max) + std::sqrt(2 * d / axis.a_max);
    longest_s = std::max(longest_s, from_rest_s + axis.response_delay_s);
  }
  return longest_s;
}

void add_judgement(JobResult& result, Judgement judgement) {
  result.board = judgement.board;
  result.defects = std::move(judgement.defects);
  if (result.exit_code == ExitCode::Done && !result.defects.empty()) result.exit_code = ExitCode::DoneWithDefects;
}

bool is_lacking(const Defect& defect) { return defect.kind == Kind::Missing || defect.kind == Kind::Cut; }

std::string_view name(Board board) {
  constexpr std::array<std::string_view, 4> kNames{"untouched", "begun", "whole", "defects"};
  return kNames[static_cast<std::size_t>(board)];
}

std::string_view name(Kind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::optional<Kind> kind_named(std::string_view name) {
  const auto found = std::find(kKinds.begin(), kKinds.end(), name);
  if (found == kKinds.end()) return std::nullopt;
  return static_cast<Kind>(found - kKinds.begin());
}

}  // namespace gantry::record
