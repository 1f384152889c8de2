#include "app/run/runner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

#include "app/job/rise.hpp"
#include "app/job/settle.hpp"
#include "core/log.hpp"
#include "vision/annotate.hpp"
#include "vision/camera_model.hpp"
#include "vision/find.hpp"

namespace gantry::run {
namespace {

constexpr int kReportImageShrink = 2;
constexpr double kClampTimeout_s = 2;
constexpr Time kFrameTimeout = milliseconds(1000);

bool is_off(cycle::State s) { return s == cycle::State::Disabled || s == cycle::State::Offline; }

bool stopped(cycle::State s) {
  return s == cycle::State::Held || s == cycle::State::Stopping || s == cycle::State::Stopped || is_off(s);
}

}  // namespace

Runner::Runner(const Site& site, const recipes::Recipe& recipe, const recipes::Job& job, record::JobResult& result)
    : site_(site),
      recipe_(recipe),
      job_(job),
      result_(result),
      planned_path_(site.machine),
      planner_(site.machine, recipe, site.breath, site.opinion),
      // A second opinion is one thread's.
      foresight_(site.machine, recipe,
                 {.thread = site.opinion ? Foresight::Thread::Callers : site.foresight,
                  .breath = site.breath,
                  .opinion = site.opinion,
                  .ways = site.forecast != nullptr ? site.forecast->ways : nullptr,
                  .lists_motions = site.motions != nullptr}),
      state_(job::begin_state(recipe, job)),
      watch_(recipes::dispensed_by(job)),
      speed_watch_(recipe, seconds(site.machine.bus.cycle)),
      cut_watch_(site.machine),
      times_(site.forecast, recipe.features.size(), seconds(site.machine.bus.cycle)) {
  if (site_.motions != nullptr) planner_.list_motions();
  if (site.forecast != nullptr) planner_.know_ways(site.forecast->ways);
  result_.drawing.tip_of_block.clear();
  if (site.forecast != nullptr) result_.predicted_s = site.forecast->s;
}

Result<void> Runner::run() {
  at_ = site_.control.latest().target;
  auto done = begin();
  if (done)
    done = job::step_through(job_, state_, [this](const auto& step) -> Result<job::JobState> {
      cut_.reset();
      if (const std::string what = job::words_of(step, recipe_); !what.empty()) times_.begin(what);
      auto after = take(step);
      if (!after && outlives(after.error())) after = go_on_after_stop();
      if (!after) return after;
      if (after->block != state_.block || after->pressing != state_.pressing) times_.done();
      planner_.know(after->known);
      result_.features_done = job::count(*after, job::FeatureState::Done);
      result_.blocks_done = after->block;
      return after;
    });
  if (done) doing_ = "done";
  state_ = job::lost_sight(std::move(state_));
  result_.planned = planned_path_.take();
  result_.steps = times_.steps();
  result_.feature_times = times_.features();
  result_.images_s = times_.images_s();
  for (std::size_t i = 0; i < state_.features.size(); ++i)
    if (state_.features[i] == job::FeatureState::Interrupted || state_.features[i] == job::FeatureState::Doubtful ||
        (joining_ && joining_->feature == i))
      result_.interrupted.push_back(id_of(recipe_.features[i]));
  return done;
}

/// As it was seen from the job: a hold, an override, a stop on its path or between its motions.
bool Runner::disturbs(const cycle::Snapshot& s) const {
  using cycle::State;
  return site_.control.holds_next() || (s.block != 0 && s.override_factor != 1) || s.state == State::Holding ||
         s.state == State::Held || s.state == State::Stopping || s.state == State::Stopped;
}

void Runner::see(const cycle::Snapshot& s) {
  result_.disturbed = result_.disturbed || disturbs(s);
  if (standing_by_) watch_part(s);
  times_.see({.plays = s.block != 0 && s.block == block_,
              .feature = s.feature,
              .rate = s.override_factor,
              .stopped = stopped(s.state)});
  if (purging_) return;
  if (watch_.see(state_.features, {.block = s.block,
                                   .feature = s.feature,
                                   .valve_open = (s.outputs & config::bit(config::Output::Valve)) != 0,
                                   .stopped = s.valve_cut || is_off(s.state)}))
    result_.features_done = job::count(state_, job::FeatureState::Done);
  note_joined(s);
  if (s.block == block_)
    cut_watch_.see({.cycle = s.cycle,
                    .along_block_mm = s.along_block_mm,
                    .valve_cut = s.valve_cut,
                    .plays = s.state == cycle::State::Running,
                    .valve_open = (s.outputs & config::bit(config::Output::Valve)) != 0});
  else if (s.valve_cut && playing_ != nullptr)
    cut_watch_.see_cut(s.cycle);
  speed_watch_.see({.feature = s.block == block_ ? s.feature : motion::kTravel,
                    .valve_open = (s.outputs & config::bit(config::Output::Valve)) != 0,
                    .path_speed_mm_s = s.path_speed});
}

/// The clamp shut and the head up, among what the last job has left there.
Result<void> Runner::begin() {
  job::Surroundings bodies(site_.machine);
  bodies.tell_in(site_.machine, recipe_);
  const bool knows_board = site_.around != nullptr && site_.around->scene().board();
  for (;;) {
    if (!job::rises(site_.machine, at_)) foresee(state_, at_);
    auto done = close_clamp();
    if (done) done = rise(knows_board ? *site_.around : bodies, true);
    if (done || !outlives(done.error())) return done;
    doing_ = "stopped";
    if (auto stood = site_.control.wait_for_resume(); !stood) return stood;
  }
}

bool Runner::outlives(const Error& error) const {
  return site_.control.outlives_stops() && outlived(info(error.fault));
}

Result<void> Runner::close_clamp() {
  const std::uint32_t clamp = config::bit(config::Output::Clamp), closed = config::bit(config::Input::ClampClosed);
  if (auto r = site_.control.command({.kind = cycle::CommandKind::SetOutputs, .mask = clamp, .bits = clamp}, 1); !r)
    return r;
  if (!site_.machine.inputs[static_cast<std::size_t>(config::Input::ClampClosed)]) return {};
  return site_.control.wait([&] { return (site_.control.latest().inputs & closed) != 0; }, kClampTimeout_s,
                            Error{Fault::ClampOpen, "the clamp did not close", "input clamp_closed"});
}

Result<void> Runner::rise(const job::Surroundings& around, bool begins) {
  auto up = job::plan_rise(site_.machine, around, block_ + 1, at_, site_.opinion, planner_.rows());
  if (!up) return tl::unexpected(up.error());
  if (!*up) return {};
  doing_ = "raising the head";
  next_block("needle");
  if (begins) foresee(state_, (*up)->end());
  if (auto r = play(**std::move(up)); !r) return tl::unexpected(r.error());
  return {};
}

/// Blocks are numbered as they are played: a mark that is looked at twice takes two numbers.
std::uint32_t Runner::next_block(std::string_view tool_name) {
  const config::Tool* tool = config::find_tool(site_.machine, tool_name);
  auto& tips = result_.drawing.tip_of_block;
  tips.resize(++block_ + 1);
  if (tool != nullptr) tips[block_] = tool->tip - Vec3{0, 0, tool->lift_mm};
  return block_;
}

Result<job::ProvenBlock> Runner::prove(job::BlockStep step) {
  const job::BlockWanted wanted{std::move(step), block_, at_, state_.known, state_.laid};
  const auto since = std::chrono::steady_clock::now();
  auto foreseen = foresight_.take(wanted, [this] {
    site_.control.idle();
    return !site_.control.aborting();
  });
  if (foreseen) planner_.share(foresight_.planner());
  ++(foreseen ? result_.proofs.ahead : result_.proofs.at_the_moment);
  auto block = foreseen ? *std::move(foreseen) : job::plan(planner_, wanted);
  // In virtual time none passes while anybody thinks.
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - since).count();
  if (site_.foresight == Foresight::Thread::Own && s > seconds(site_.machine.bus.cycle))
    ++result_.proofs.waited, result_.proofs.waited_s += s;
  return block;
}

void Runner::foresee(const job::JobState& after, const AxisVec& from) {
  foresight_.begin(job::wanted_next(recipe_, job_, after, purge_is_due(), block_ + 1, from));
}

void Runner::foresee(const job::JobState& after, const Result<job::ProvenBlock>& block) {
  if (block) foresee(after, block->end());
}

/// However it ended, the block is freed in pieces.
Result<Played> Runner::play(Result<job::ProvenBlock> planned, When when) {
  if (!planned) return tl::unexpected(planned.error());
  auto played = play_through(*planned, when);
  playing_ = nullptr;
  job::discard(*std::move(planned), site_.breath);
  return played;
}

Result<Played> Runner::play_through(const job::ProvenBlock& block, When when) {
  constexpr std::size_t kPiece = 16;  // segments that are drawn between two breaths
  std::size_t drawn = 0;
  for (const motion::Segment& segment : block.segments()) {
    if (drawn++ % kPiece == 0 && !go_on(site_.breath)) return given_up();
    planned_path_.add({&segment, 1});
  }
  if (site_.motions != nullptr) site_.motions->add(block);
  result_.motions_certified += block.motions();
  result_.opinion_poses += block.poses();
  job::take_nearer(result_.minimum_clearance, block.nearest());
  const std::vector<job::FeatureState> before = state_.features;
  speed_watch_.begin(block.segments());
  cut_watch_.begin();
  playing_ = &block.segments();
  if (when != When::OnHold)
    if (auto ready = when == When::Armed ? arm() : wait_for_resume(); !ready) return tl::unexpected(ready.error());
  auto played = when == When::OnHold ? site_.control.play_on_hold(block) : site_.control.play(block);
  speed_watch_.end();
  at_ = site_.control.latest().target;
  const bool cut = played ? played->cut : outlives(played.error());
  if (cut) {
    times_.disturb();
    if (when != When::OnHold) note_cut(before, block.segments());
  }
  return played;
}

// ---- marks ----

Result<job::JobState> Runner::take(const recipes::LookAtMark& step) {
  const std::size_t mark = step.mark;
  const recipes::MarkDef& def = recipe_.marks[mark];
  doing_ = "mark " + def.name;
  record::MarkResult found;
  const int attempts = std::max(1, recipe_.mark_rules.attempts);
  for (int attempt = 1; attempt <= attempts; ++attempt) {
    std::uint64_t shown_before = 0;
    if (auto r = site_.aside([&] { shown_before = site_.camera->latest(); }); !r) return tl::unexpected(r.error());
    next_block("camera");
    auto played = play(prove(step));
    if (!played) return tl::unexpected(played.error());
    Result<record::MarkResult> judged;
    const auto look = [&, head = site_.control.latest().actual] { judged = judge(mark, head, shown_before); };
    if (auto r = site_.aside(look); !r) return tl::unexpected(r.error());
    if (!judged) {
      // The trigger is one short pulse: what it has not reached is asked once more (R65).
      if (attempt == attempts) return tl::unexpected(judged.error());
      log::warn("{}: {}; it is taken once more", doing_, judged.error().message);
      times_.disturb();
      continue;
    }
    found = *judged;
    found.attempts = attempt;
    foresee(found.found ? job::after_mark(recipe_, state_, mark, found.measured) : state_, at_);
    // The answer takes effect a fixed time after the exposure, so that runs repeat whatever the host does meanwhile.
    const auto latency = site_.control.cycles(site_.machine.camera.answer_latency_s);
    const CycleIndex due = played->end + latency;
    if (site_.control.latest().cycle > due)
      log::report(Error{Fault::AnswerLate, std::string(info(Fault::AnswerLate).text), doing_});
    if (auto r = site_.control.wait([&] { return site_.control.latest().cycle >= due; }, 60, {}); !r)
      return tl::unexpected(r.error());
    times_.image(site_.machine.camera.answer_latency_s);
    if (found.found) break;
    times_.disturb();
  }
  result_.marks.push_back(found);
  if (!found.found)
    return fail(found.fault, fmt::format("mark '{}' was not found: {}", def.name, found.reason),
                job::at_line(recipe_, def.location));
  return job::after_mark(recipe_, state_, mark, found.measured);
}

/// Fetches the frame of the exposure that the block triggered and finds the mark in it. A mark that is not there is an
/// answer, not an error. It may run on another thread.
Result<record::MarkResult> Runner::judge(std::size_t mark, const AxisVec& head, std::uint64_t shown_before) {
  const recipes::MarkDef& def = recipe_.marks[mark];
  auto frame = site_.camera->fetch(shown_before, kFrameTimeout);
  if (!frame) return tl::unexpected(frame.error());
  if (frame->counter == shown_before)
    return fail(Fault::CameraFrozen, "the camera shows the frame before again", "mark " + def.name);

  const vision::CameraModel camera(site_.machine.camera);
  const vision::MarkModel model{.shape = vision::Disc{camera.length_px(def.diameter)}, .bright = def.bright};
  const Vec2 expected = camera.centre_px();
  const auto seen = vision::find_mark(frame->image, model, expected, camera.length_px(site_.machine.camera.search_mm),
                                      {.mm_per_px = camera.mm_per_px()});

  record::MarkResult result;
  result.name = def.name;
  result.found = seen.has_value();
  result.nominal = def.at;
  if (seen) {
    const config::Tool& tool = *config::find_tool(site_.machine, "camera");
    const Vec2 off = camera.to_mm(seen->at_px);
    const Vec3 nominal = recipes::to_machine(recipe_, site_.machine, {}, {}, {0, 0}, 0);
    result.measured = {head[site_.machine.x.value] + tool.tip.x + off.x - nominal.x,
                       head[site_.machine.y.value] + tool.tip.y + off.y - nominal.y};
  } else {
    result.reason = seen.error().message;
    result.fault = seen.error().fault;
  }
  if (auto png = vision::annotated_png(frame->image, model, expected, seen ? &*seen : nullptr, kReportImageShrink))
    result.png = std::move(*png);
  return result;
}

Result<job::JobState> Runner::take(const job::SettleOffset&) {
  if (recipe_.marks.empty()) return job::after_offset(state_, {});
  const auto fit = job::settle_offset(recipe_, state_.known.marks);
  const vision::OffsetFit shown = fit ? *fit : job::fit_marks(recipe_, state_.known.marks);
  for (std::size_t i = 0; i < result_.marks.size() && i < shown.residuals.size(); ++i)
    result_.marks[i].residual_mm = norm(shown.residuals[i].residual_mm);
  if (!fit) return tl::unexpected(fit.error());
  result_.offset = {fit->shift_mm, fit->rotation_rad};
  result_.offset_rms_mm = fit->rms_mm;
  result_.has_offset = true;
  result_.length_only = state_.known.marks.size() == 2;
  return job::after_offset(state_, result_.offset);
}

// ---- surface ----

Result<void> Runner::arm() {
  do {
    if (auto stood = wait_for_resume(); !stood) return stood;
    if (auto armed = site_.control.command({.kind = cycle::CommandKind::ArmProbe}, 2); !armed) return armed;
  } while (site_.control.holds_next());  // a hold that came meanwhile
  return {};
}

Result<double> Runner::touch_down(const recipes::TouchPoint& point,
                                  const std::function<Result<job::ProvenBlock>()>& plan) {
  const auto of_this_touch = [&](Error error) {
    const int number = static_cast<int>(error.fault);
    if (number < static_cast<int>(Fault::ProbeNeverTriggered) || number > static_cast<int>(Fault::ProbeStale))
      return tl::unexpected(std::move(error));
    error.message = fmt::format("touch '{}': {}", point.name, error.message);
    if (error.where.empty()) error.where = job::at_line(recipe_, point.location);
    return tl::unexpected(std::move(error));
  };
  const auto played = play(plan(), When::Armed);
  if (!played) return of_this_touch(played.error());
  if (!played->touched)
    return fail(Fault::ProbeNeverTriggered,
                fmt::format("touch '{}': the probe met nothing within its travel", point.name),
                job::at_line(recipe_, point.location));
  return played->touched_at;
}

/// Fast to the surface, up, and slowly down again, where the machine has a fast touch; the slow one counts.
Result<job::JobState> Runner::take(const recipes::Touch& step) {
  constexpr double kAgree_mm = 0.1;
  const recipes::TouchPoint& point = recipe_.touches[step.touch];
  doing_ = "touch " + point.name;
  auto met = touch_down(point, [&] {
    next_block("probe");
    return prove(step);
  });
  if (met && site_.machine.probe.fast_mm_s > 0) {
    const double first = *met;
    next_block("probe");
    auto up = prove(job::BackOff{step.touch});
    if (up)
      foresight_.begin(job::BlockWanted{job::TouchAgain{step.touch}, block_ + 1, up->end(), state_.known, state_.laid});
    if (auto free = play(std::move(up)); !free) return tl::unexpected(free.error());
    met = touch_down(point, [&] {
      next_block("probe");
      return prove(job::TouchAgain{step.touch});
    });
    if (met && std::abs(*met - first) > kAgree_mm)
      return fail(Fault::ProbeImplausible,
                  fmt::format("touch '{}': the fast and the slow touch are {:.3f} mm apart; {:.3f} mm is allowed",
                              point.name, std::abs(*met - first), kAgree_mm),
                  job::at_line(recipe_, point.location));
  }
  if (!met) return tl::unexpected(met.error());
  const config::Tool& probe = *config::find_tool(site_.machine, "probe");
  const double nominal_mm = recipes::to_machine(recipe_, site_.machine, {}, {}, point.at, 0).z;
  return job::after_touch(state_, step.touch, *met + probe.tip.z - nominal_mm);
}

/// The height is judged once the probe is free.
Result<job::JobState> Runner::take(const job::Retract& step) {
  const recipes::TouchPoint& point = recipe_.touches[step.touch];
  next_block("probe");
  auto up = prove(step);
  foresee(job::after_retract(state_), up);
  if (auto free = play(std::move(up)); !free) return tl::unexpected(free.error());
  const double height_mm = state_.known.heights.back().height_mm;
  result_.touches.push_back({point.name, point.at, height_mm, 0});
  if (std::abs(height_mm) > recipe_.touch_rules.window_mm)
    return fail(Fault::ProbeImplausible,
                fmt::format("touch '{}': the surface was met {:.3f} mm from its nominal height; {:.3f} mm is allowed",
                            point.name, height_mm, recipe_.touch_rules.window_mm),
                job::at_line(recipe_, point.location));
  return job::after_retract(state_);
}

Result<job::JobState> Runner::take(const job::SettleSurface&) {
  if (recipe_.touches.empty()) return job::after_surface(state_, {});
  const auto fit = job::settle_surface(recipe_, state_.known.heights);
  if (!fit) return tl::unexpected(fit.error());
  for (std::size_t i = 0; i < result_.touches.size() && i < fit->residuals.size(); ++i)
    result_.touches[i].residual_mm = fit->residuals[i].residual_mm;
  result_.surface = {fit->z0_mm, fit->slope};
  result_.has_surface = true;
  return job::after_surface(state_, result_.surface);
}

// ---- features ----

bool Runner::purge_is_due() const {
  const std::optional<double> shut_s = site_.control.valve_shut_s();
  return recipe_.purge && (!shut_s || *shut_s > recipe_.purge->after_s || purge_cut_);
}

Result<job::JobState> Runner::take(const recipes::PurgeNeedle& step) {
  if (!purge_is_due()) return job::after_block(state_);
  doing_ = "purging";
  purging_ = purge_cut_ = true;
  next_block("needle");
  auto shots = prove(step);
  foresee(job::after_block(state_), shots);
  const auto played = play(std::move(shots));
  purging_ = false;
  if (!played) return tl::unexpected(played.error());
  if (played->cut) {
    log::info("the purge was stopped; all of its shots come again");
    return state_;
  }
  purge_cut_ = false;
  result_.purge_shots += static_cast<std::size_t>(recipe_.purge->shots);
  return job::after_block(state_);
}

Result<job::JobState> Runner::take(const recipes::Dispense& step) {
  doing_ = "dispensing";
  next_block("needle");
  auto planned = prove(step);
  foresee(job::after_block(state_), planned);
  if (planned) {
    std::vector<job::FeatureTime> times(recipe_.features.size());
    job::add_times(times, *planned, site_.breath);
    times_.plan(times);
    for (const job::RunUp& begun : planned->run_ups()) tell(begun);
  }
  const auto played = play(std::move(planned));
  if (!played) return tl::unexpected(played.error());
  if (!played->cut) return job::after_block(state_);
  if (played->on == motion::kTravel && !cut_) return state_;
  const std::size_t feature = cut_.value_or(played->on);
  if (auto stood = hold_off(feature); !stood) return tl::unexpected(stood.error());
  return cut_ || joining_ ? join(feature) : state_;
}

void Runner::tell(const job::RunUp& begun) {
  const auto& bead = std::get<recipes::Bead>(recipe_.features[begun.feature]);
  std::string words =
      fmt::format("bead '{}' {}", bead.id, job::in_words(begun, *recipes::find_material(recipe_, bead.material)));
  // What is left after a hold is planned anew, and begins as it would have.
  if (std::string& told = told_of_[begun.feature]; told != words) {
    log::info("{}", words);
    told = std::move(words);
  }
}

Result<job::JobState> Runner::take(const recipes::Park& step) {
  doing_ = "parking";
  next_block("needle");
  const auto played = play(prove(step));
  if (!played) return tl::unexpected(played.error());
  return job::after_block(state_);
}

}  // namespace gantry::run
