// What a hold or a stop has cut: where it was cut, the needle off it, and what is left of a bead joined to what lies.
#include <algorithm>
#include <fmt/format.h>
#include <span>
#include <utility>

#include "app/job/hold_ahead.hpp"
#include "app/job/limits.hpp"
#include "app/job/stop_ahead.hpp"
#include "app/run/runner.hpp"
#include "config/inputs.hpp"
#include "core/log.hpp"
#include "motion/profile/speed_profile.hpp"
#include "recipes/valve_leads.hpp"

namespace gantry::run {
namespace {

// What is missing at a bead's end, and is not gone back for: no more than a join may miss or double, and a part of the
// end tolerance.
constexpr double kJoinError_s = 0.5e-3, kJoinError_mm = 0.02, kOfTolerance = 0.5;
constexpr double kShortest_s = 0.005;  // that a valve can be open for what is left
constexpr double kLonger = 2;          // times that for what would be shorter, which is laid more slowly

double spared_mm_of(const recipes::Material& m) {
  return std::min(m.speed * kJoinError_s + kJoinError_mm, kOfTolerance * m.tolerance_mm);
}

/// Until the valve is told to open, at an override of 100 %: a slow bead's run-up takes long, too.
double return_s(const job::ProvenBlock& block) {
  double back_s = 0;
  for (const motion::Segment& s : block.segments()) {
    for (const motion::OutputEvent& e : s.events)
      if (e.dispense) return back_s + motion::time_at(s.nominal, e.at_s);
    back_s += motion::duration(std::span(&s, 1));
  }
  return back_s;
}

}  // namespace

std::optional<Ahead> Runner::ahead() const {
  const cycle::Snapshot& s = site_.control.latest();
  if (playing_ == nullptr || s.block != block_ || !site_.control.valve_open()) return std::nullopt;
  if (purging_) {  // its shots are told apart by nothing that the loop shows
    const recipes::Material& m = *recipes::find_material(recipe_, recipe_.purge->material);
    return Ahead{"", m.dot_time};  // it is a dwell, which no override makes longer
  }
  std::uint32_t feature = s.feature;
  double begin_mm = 0;
  // The valve opens ahead of its feature.
  for (const motion::Segment& segment : *playing_) {
    if (feature != motion::kTravel) break;
    begin_mm += job::path_mm(segment);
    if (begin_mm >= s.along_block_mm) feature = segment.feature;
  }
  if (feature >= recipe_.features.size()) return std::nullopt;
  return Ahead{recipes::id_of(recipe_.features[feature]),
               job::stands_in_s(*playing_, {s.along_block_mm, cut_watch_.stands_s()}, feature,
                                std::min(1.0, s.override_factor), job::limits_of(site_.machine))};
}

std::string Runner::heads_for() {
  const cycle::Snapshot& s = site_.control.latest();
  if (playing_ == nullptr || s.block != block_) return "";
  if (looked_.block != block_) looked_ = {.block = block_};
  const auto& segments = *playing_;
  while (looked_.segment < segments.size() &&
         looked_.begins_mm + job::path_mm(segments[looked_.segment]) < s.along_block_mm)
    looked_.begins_mm += job::path_mm(segments[looked_.segment++]);
  for (std::size_t i = looked_.segment; i < segments.size(); ++i) {
    const bool opens = std::any_of(segments[i].events.begin(), segments[i].events.end(),
                                   [](const auto& event) { return event.dispense; });
    if (opens && segments[i].feature < recipe_.features.size())
      return recipes::id_of(recipe_.features[segments[i].feature]);
  }
  return "";
}

std::string Runner::feature() {
  const cycle::Snapshot& s = site_.control.latest();
  if (s.block == block_ && s.feature < recipe_.features.size()) return recipes::id_of(recipe_.features[s.feature]);
  return heads_for();
}

void Runner::note_cut(const std::vector<job::FeatureState>& before, const std::deque<motion::Segment>& segments) {
  watch_ = job::FeatureWatch(recipes::dispensed_by(job_));
  std::optional<std::size_t> cut, done;
  for (std::size_t f = 0; f < state_.features.size() && !cut; ++f) {
    if (state_.features[f] == before[f]) continue;
    if (state_.features[f] == job::FeatureState::Interrupted) cut = f;
    if (state_.features[f] == job::FeatureState::Done) done = f;
  }
  const auto material = [&](std::size_t f) -> const recipes::Material& {
    return std::visit(
        [&](const auto& each) -> const auto& { return *recipes::find_material(recipe_, each.material); },
        recipe_.features[f]);
  };
  const auto laid = [&](std::size_t f) -> std::optional<job::Laid> {
    if (!std::holds_alternative<recipes::Bead>(recipe_.features[f])) return std::nullopt;
    const auto shut = cut_watch_.shut_at(material(f).valve_close_lead);
    return shut ? job::laid_part(segments, job::laid_of(state_.laid, f), *shut) : std::nullopt;
  };
  // Its valve was told to shut as planned, and the tool did not come to its end any more.
  if (!cut && done)
    if (const auto part = laid(*done); part && part->all_mm - part->mm > spared_mm_of(material(*done)))
      cut = done, state_.features[*done] = job::FeatureState::Interrupted;
  // A dot of which nothing lies yet was not begun, and one of which as much lies as is asked for is done.
  if (cut && std::holds_alternative<recipes::Dot>(recipe_.features[*cut])) {
    const recipes::Material& m = material(*cut);
    const auto flowed_s = cut_watch_.flowed_s(m.valve_open_lead, m.valve_close_lead);
    if (flowed_s && *flowed_s <= 0)
      state_.features[*std::exchange(cut, std::nullopt)] = job::FeatureState::Open;
    else if (flowed_s && *flowed_s >= m.dot_time - recipes::dot_time_tolerance_s(m, seconds(site_.machine.bus.cycle)))
      state_.features[*std::exchange(cut, std::nullopt)] = job::FeatureState::Done;
  }
  if (!cut) return;  // what was cut before in this step is as it was, and what lies of it
  cut_ = cut;
  laid_ = laid(*cut_);
  joining_.reset();
}

Result<void> Runner::hold_off(std::size_t feature) {
  doing_ = fmt::format("on hold, on '{}'", recipes::id_of(recipe_.features[feature]));
  if (auto up = planner_.lift(next_block("needle"), at_, feature); !up)
    log::warn("the needle stays on what it dispenses: {}", up.error().message);
  else if (auto lifted = play(std::move(up), When::OnHold); !lifted)
    return tl::unexpected(lifted.error());
  return wait_for_resume();
}

Result<void> Runner::sit_out() {
  for (;;) {
    doing_ = cut_ ? fmt::format("stopped, on '{}'", recipes::id_of(recipe_.features[*cut_])) : "stopped";
    if (auto stood = wait_for_resume(); !stood) return stood;
    auto up = rise(*planner_.surroundings());
    if (up || !outlives(up.error())) return up;
  }
}

Result<job::JobState> Runner::go_on_after_stop() {
  if (auto up = sit_out(); !up) return tl::unexpected(up.error());
  if (cut_) return join(*cut_);
  return joining_ ? join(joining_->feature) : Result<job::JobState>(state_);
}

Result<void> Runner::wait_for_resume() {
  standing_by_ = true;
  part_lost_.reset();
  const auto stood = site_.control.wait_for_resume([this] { return part_lost_.has_value(); });
  standing_by_ = false;
  if (stood && part_lost_) return tl::unexpected(*part_lost_);
  return stood;
}

void Runner::watch_part(const cycle::Snapshot& s) {
  const auto low = [&](config::Input input) { return config::is_low(site_.machine, s.inputs, input); };
  const auto lost = [&](Fault fault) { part_lost_ = Error{fault, std::string(info(fault).text), ""}; };
  if (part_lost_) return;
  if (low(config::Input::ClampClosed)) lost(Fault::ClampOpen);
  if (low(config::Input::Mode)) lost(Fault::ModeChanged);
}

void Runner::note_joined(const cycle::Snapshot& s) {
  if (!joining_ || state_.features[joining_->feature] != job::FeatureState::Begun) return;
  joining_->told.after_s = static_cast<double>(s.time_ns - joining_->shut_ns) * 1e-9;
  result_.joined.push_back(joining_->told);
  joining_.reset();
}

/// Joined is what can be joined; what cannot stays cut, and the job goes on with the next feature.
Result<job::JobState> Runner::join(std::size_t feature) {
  const std::string& id = recipes::id_of(recipe_.features[feature]);
  joining_.reset();
  const auto* bead = std::get_if<recipes::Bead>(&recipe_.features[feature]);
  const double left_mm = laid_ ? laid_->all_mm - laid_->mm : 0;
  const auto as_it_is = [&](const std::string& why) {
    log::info("'{}' is done as it is, {:.3f} mm short of its end: {}", id, left_mm, why);
    job::JobState whole = state_;
    whole.features[feature] = job::FeatureState::Done;
    return whole;
  };
  const auto stays_cut = [&](const std::string& why) {
    if (bead != nullptr && laid_ && laid_->mm > left_mm &&
        left_mm <= recipes::find_material(recipe_, bead->material)->tolerance_mm)
      return as_it_is(why);
    log::warn("'{}' stays cut: {}", id, why);
    result_.stays_cut[id] = why;
    job::JobState cut = state_;
    cut.features[feature] = job::FeatureState::Interrupted;
    return cut;
  };
  if (bead == nullptr) return stays_cut("a dot cannot be joined");
  if (!laid_) return stays_cut("nobody saw where its valve shut");
  const recipes::Material& m = *recipes::find_material(recipe_, bead->material);
  if (const double spared_mm = spared_mm_of(m); laid_->mm > 0 && left_mm <= spared_mm)
    return as_it_is(fmt::format("up to {:.3f} mm are not gone back for", spared_mm));
  const double shut_s = site_.control.valve_shut_s().value_or(0);
  if (shut_s > m.rejoin_within_s)
    return stays_cut(
        fmt::format("its valve has been shut for {:.1f} s, and material '{}' is to be joined within {:.6g} s "
                    "('rejoin_within')",
                    shut_s, m.name, m.rejoin_within_s));
  job::LaidPart part{feature, laid_->mm, laid_->stood_s, 0};
  if (const double least_s = std::max(kShortest_s, m.valve_close_lead - m.valve_open_lead);
      left_mm / m.speed <= least_s) {
    part.slow_mm_s = left_mm / (kLonger * least_s);
    if (part.slow_mm_s < m.min_speed)
      return stays_cut(
          fmt::format("the {:.3f} mm that are left are too short for the valve at the material's "
                      "'min_speed', {:.6g} mm/s",
                      left_mm, m.min_speed));
  }
  const auto tried = planner_.dispense(block_, at_, {feature}, {part});
  if (!tried) {
    if (tried.error().fault == Fault::Aborted) return tl::unexpected(tried.error());
    return stays_cut(tried.error().message);
  }
  const double set_out_s = site_.control.valve_shut_s().value_or(shut_s);  // planning takes its time
  const double joined_s = set_out_s + return_s(*tried) / std::min(site_.control.ordered_override(), 1.0);
  if (joined_s > m.rejoin_within_s)
    return stays_cut(
        fmt::format("its valve would have been shut for {:.1f} s when the needle is back, and material '{}' is to be "
                    "joined within {:.6g} s ('rejoin_within')",
                    joined_s, m.name, m.rejoin_within_s));
  log::info(
      "'{}' is joined {:.2f} mm from its start, about {:.1f} s after it was cut{}", id, part.mm, joined_s,
      part.slow_mm_s > 0
          ? fmt::format("; the {:.3f} mm that are left are too short for the valve at {:.6g} mm/s, and are laid at "
                        "{:.3g} mm/s",
                        left_mm, m.speed, part.slow_mm_s)
          : std::string());
  joining_ = Joining{
      feature, {id, part.mm, set_out_s}, site_.control.latest().time_ns - static_cast<std::int64_t>(set_out_s * 1e9)};
  return job::after_cut(state_, part);
}

}  // namespace gantry::run
