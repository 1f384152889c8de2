#include "app/job/block_wanted.hpp"

#include <fmt/format.h>

#include "app/job/proofs_ahead.hpp"
#include "app/job/settle.hpp"

namespace gantry::job {
namespace {

struct Plan {
  const BlockPlanner& planner;
  const BlockWanted& wanted;

  Result<ProvenBlock> operator()(const recipes::LookAtMark& step) const {
    return planner.look_at_mark(wanted.number, wanted.from, step.mark);
  }
  Result<ProvenBlock> operator()(const recipes::Touch& step) const {
    return planner.touch(wanted.number, wanted.from, step.touch);
  }
  Result<ProvenBlock> operator()(const BackOff& step) const {
    return planner.back_off(wanted.number, wanted.from, step.touch);
  }
  Result<ProvenBlock> operator()(const TouchAgain& step) const {
    return planner.touch_again(wanted.number, wanted.from, step.touch);
  }
  Result<ProvenBlock> operator()(const Retract& step) const {
    return planner.retract(wanted.number, wanted.from, step.touch);
  }
  Result<ProvenBlock> operator()(const recipes::PurgeNeedle&) const {
    return planner.purge(wanted.number, wanted.from);
  }
  Result<ProvenBlock> operator()(const recipes::Dispense& step) const {
    return planner.dispense(wanted.number, wanted.from, step.features, wanted.laid);
  }
  Result<ProvenBlock> operator()(const recipes::Park&) const { return planner.park(wanted.number, wanted.from); }
};

/// What needs no motion is done; nothing where it cannot be.
std::optional<JobState> without_motion(const recipes::Recipe& recipe, const Next& step, JobState state, bool purges) {
  if (std::holds_alternative<SettleOffset>(step)) {
    if (recipe.marks.empty()) return after_offset(std::move(state), {});
    const auto fit = settle_offset(recipe, state.known.marks);
    if (!fit) return std::nullopt;
    return after_offset(std::move(state), {fit->shift_mm, fit->rotation_rad});
  }
  if (std::holds_alternative<SettleSurface>(step)) {
    if (recipe.touches.empty()) return after_surface(std::move(state), {});
    const auto fit = settle_surface(recipe, state.known.heights);
    if (!fit) return std::nullopt;
    return after_surface(std::move(state), {fit->z0_mm, fit->slope});
  }
  if (std::holds_alternative<recipes::PurgeNeedle>(step) && !purges) return after_block(std::move(state));
  return std::nullopt;
}

}  // namespace

std::string to_text(const ProofsAhead& p) {
  return fmt::format("{} of {} blocks ahead, {} at the moment; the machine waited for {}", p.ahead,
                     p.ahead + p.at_the_moment, p.at_the_moment,
                     p.waited == 0 ? "none" : fmt::format("{}, {:.1f} ms in all", p.waited, 1e3 * p.waited_s));
}

Result<ProvenBlock> plan(const BlockPlanner& planner, const BlockWanted& wanted) {
  return std::visit(Plan{planner, wanted}, wanted.step);
}

std::optional<BlockWanted> wanted_next(const recipes::Recipe& recipe, const recipes::Job& job, JobState state,
                                       bool purges, std::uint32_t number, const AxisVec& from) {
  for (;;) {
    const Next step = next(job, state);
    if (auto after = without_motion(recipe, step, state, purges)) {
      state = *std::move(after);
      continue;
    }
    return std::visit(
        [&](const auto& what) -> std::optional<BlockWanted> {
          using What = std::decay_t<decltype(what)>;
          if constexpr (std::is_constructible_v<BlockStep, What>)
            return BlockWanted{what, number, from, state.known, state.laid};
          else
            return std::nullopt;
        },
        step);
  }
}

}  // namespace gantry::job
