#include "app/run/runner.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/log.hpp"
#include "vision/annotate.hpp"
#include "vision/camera_model.hpp"
#include "vision/find.hpp"

namespace gantry::run {
namespace {

constexpr int kReportImageShrink = 2;
constexpr double kClampTimeout_s = 2;
constexpr Time kFrameTimeout = milliseconds(1000);

std::string at_line(const recipes::Recipe& recipe, recipes::Place place) {
  return fmt::format("{}:{}:{}", recipe.file, place.line, place.column);
}

template <class... F>
struct Match : F... {
  using F::operator()...;
};

}  // namespace

Runner::Runner(const Site& site, const recipes::Recipe& recipe, const recipes::Job& job, record::JobResult& result)
    : site_(site),
      recipe_(recipe),
      job_(job),
      result_(result),
      planned_path_(site.machine),
      planner_(site.machine, recipe) {
  result_.drawing.tip_of_block.clear();
}

Result<void> Runner::run() {
  auto done = play_blocks();
  result_.planned = planned_path_.points();
  return done;
}

Result<void> Runner::play_blocks() {
  at_ = site_.control.latest().target;
  const std::uint32_t clamp = config::bit(config::Output::Clamp), closed = config::bit(config::Input::ClampClosed);
  if (auto r = site_.control.command({.kind = cycle::CommandKind::SetOutputs, .mask = clamp, .bits = clamp}, 1); !r)
    return r;
  if (site_.machine.inputs[static_cast<std::size_t>(config::Input::ClampClosed)])
    if (auto r = site_.control.wait([&] { return (site_.control.latest().inputs & closed) != 0; }, kClampTimeout_s,
                                    Error{Fault::ClampOpen, "the clamp did not close", "input clamp_closed"});
        !r)
      return r;

  if (const auto rise = planner_.rise(block_ + 1, at_)) {
    doing_ = "raising the head";
    next_block("needle");
    if (auto r = play(*rise); !r) return tl::unexpected(r.error());
  }
  for (const recipes::Block& block : job_.blocks) {
    if (recipes::needs_offset(block) && !offset_settled_)
      if (auto r = settle_offset(); !r) return r;
    if (recipes::needs_surface(block) && !surface_settled_)
      if (auto r = settle_surface(); !r) return r;
    auto done =
        std::visit(Match{[&](const recipes::LookAtMark& b) { return look(b.mark); },
                         [&](const recipes::Touch& b) { return touch(b.touch); },
                         [&](const recipes::Dispense& b) -> Result<void> {
                           doing_ = "dispensing";
                           if (auto played = play(planner_.dispense(next_block("needle"), at_, b.features)); !played)
                             return tl::unexpected(played.error());
                           return {};
                         },
                         [&](const recipes::Park&) -> Result<void> {
                           doing_ = "parking";
                           if (auto played = play(planner_.park(next_block("needle"), at_)); !played)
                             return tl::unexpected(played.error());
                           return {};
                         }},
                   block.what);
    if (!done) return done;
    ++result_.blocks_done;
  }
  doing_ = "done";
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

Result<Played> Runner::play(const Result<job::PlannedBlock>& planned) {
  if (!planned) return tl::unexpected(planned.error());
  result_.predicted_s += planned->duration_s;
  result_.motions_certified += planned->motions;
  result_.minimum_clearance_mm = result_.motions_certified == planned->motions
                                     ? planned->minimum_clearance_mm
                                     : std::min(result_.minimum_clearance_mm, planned->minimum_clearance_mm);
  planned_path_.add(planned->segments);
  auto played = site_.control.play(block_, planned->segments);
  at_ = site_.control.latest().target;
  return played;
}

// ---- marks ----

Result<void> Runner::look(std::size_t mark) {
  const recipes::MarkDef& def = recipe_.marks[mark];
  doing_ = "mark " + def.name;
  if (site_.camera == nullptr)
    return fail(Fault::CameraTimeout, "the recipe has marks, but no camera is connected", at_line(recipe_, def.place));
  record::MarkResult found;
  for (int attempt = 1; attempt <= std::max(1, recipe_.mark_rules.attempts); ++attempt) {
    const std::uint64_t shown_before = site_.camera->latest();
    auto played = play(planner_.look_at_mark(next_block("camera"), at_, mark));
    if (!played) return tl::unexpected(played.error());
    const auto judged = judge(mark, site_.control.latest().actual, shown_before);
    if (!judged) return tl::unexpected(judged.error());
    found = *judged;
    found.attempts = attempt;
    // The answer takes effect a fixed time after the exposure, so that runs repeat whatever the host does meanwhile.
    const auto latency = site_.control.cycles(site_.machine.camera.answer_latency_s);
    const CycleIndex due = played->end + latency;
    if (site_.control.latest().cycle > due) log::warn("{}: the image took longer than the configured latency", doing_);
    if (auto r = site_.control.wait([&] { return site_.control.latest().cycle >= due; }, 60, {}); !r) return r;
    if (found.found) break;
  }
  result_.marks.push_back(found);
  if (!found.found)
    return fail(Fault::MarkNotFound, fmt::format("mark '{}' was not found: {}", def.name, found.reason),
                at_line(recipe_, def.place));
  marks_.push_back({def.name, def.at, found.measured});
  guess_from_marks();
  return {};
}

/// Fetches the frame of the exposure that the block triggered and finds the mark in it. A mark that is not there is an
/// answer, not an error.
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
  }
  if (auto png = vision::annotated_png(frame->image, model, expected, seen ? &*seen : nullptr, kReportImageShrink))
    result.png = std::move(*png);
  return result;
}

/// Where the next mark is likely to be: the first found mark tells the shift, two tell the turn as well.
void Runner::guess_from_marks() {
  if (marks_.size() == 1) {
    planner_.guess({marks_[0].found_mm - marks_[0].nominal_mm, 0});
  } else {
    const vision::OffsetFit fit = vision::fit_rigid(marks_);
    planner_.guess({fit.shift_mm, fit.rotation_rad});
  }
}

Result<void> Runner::settle_offset() {
  offset_settled_ = true;
  if (!recipe_.marks.empty()) {
    const auto fit = vision::fit_offset(marks_, {.max_residual_mm = recipe_.mark_rules.max_residual_mm,
                                                 .max_shift_mm = recipe_.mark_rules.max_shift_mm,
                                                 .max_rotation_rad = recipe_.mark_rules.max_rotation_rad});
    const vision::OffsetFit shown = fit ? *fit : vision::fit_rigid(marks_);
    for (std::size_t i = 0; i < result_.marks.size() && i < shown.residuals.size(); ++i)
      result_.marks[i].residual_mm = norm(shown.residuals[i].residual_mm);
    if (!fit) {
      Error e = fit.error();
      if (e.where.empty()) e.where = at_line(recipe_, recipe_.marks.front().place);
      return tl::unexpected(std::move(e));
    }
    offset_ = {fit->shift_mm, fit->rotation_rad};
    result_.offset = offset_;
    result_.offset_rms_mm = fit->rms_mm;
    result_.has_offset = true;
  }
  planner_.know(offset_, surface_, recipe_.touches.empty());
  return {};
}

// ---- surface ----

Result<void> Runner::touch(std::size_t index) {
  const recipes::TouchPoint& point = recipe_.touches[index];
  doing_ = "touch " + point.name;
  if (auto r = site_.control.command({.kind = cycle::CommandKind::ArmProbe}, 2); !r) return r;
  auto played = play(planner_.touch(next_block("probe"), at_, index));
  if (!played) return tl::unexpected(played.error());
  if (!played->touched)
    return fail(Fault::ProbeNeverTriggered,
                fmt::format("touch '{}': the probe met nothing within its travel", point.name),
                at_line(recipe_, point.place));
  if (auto free = play(planner_.retract(next_block("probe"), at_)); !free) return tl::unexpected(free.error());
  const config::Tool& probe = *config::find_tool(site_.machine, "probe");
  const double height =
      played->touched_at + probe.tip.z - recipes::to_machine(recipe_, site_.machine, {}, {}, point.at, 0).z;
  heights_.push_back({point.name, point.at, height});
  result_.touches.push_back({point.name, point.at, height, 0});
  if (std::abs(height) > recipe_.touch_rules.window_mm)
    return fail(Fault::ProbeImplausible,
                fmt::format("touch '{}': the surface was met {:.3f} mm from its nominal height; {:.3f} mm is allowed",
                            point.name, height, recipe_.touch_rules.window_mm),
                at_line(recipe_, point.place));
  return {};
}

Result<void> Runner::settle_surface() {
  surface_settled_ = true;
  if (!recipe_.touches.empty()) {
    const auto fit = vision::fit_surface(heights_, {.max_residual_mm = recipe_.touch_rules.max_residual_mm});
    if (!fit) {
      Error e = fit.error();
      if (e.where.empty()) e.where = at_line(recipe_, recipe_.touches.front().place);
      return tl::unexpected(std::move(e));
    }
    for (std::size_t i = 0; i < result_.touches.size() && i < fit->residuals.size(); ++i)
      result_.touches[i].residual_mm = fit->residuals[i].residual_mm;
    surface_ = {fit->z0_mm, fit->slope};
    result_.surface = surface_;
  }
  planner_.know(offset_, surface_, true);
  return {};
}

}  // namespace gantry::run
