#include "app/job/prove.hpp"

#include <algorithm>
#include <functional>

#include "app/job/block_wanted.hpp"
#include "app/job/park.hpp"

namespace gantry::job {
namespace {

/// Goes through the job as the runner does. Where the runner asks the world, the answer here is that all is nominal.
class Prover {
 public:
  Prover(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job, const Breath& breath,
         const motion::Opinion& opinion, std::function<void()> count)
      : machine_(machine),
        recipe_(recipe),
        breath_(breath),
        planner_(machine, recipe, breath, opinion),
        state_(begin_state(recipe, job)) {
    planner_.count(std::move(count));
    proof_.forecast.features.resize(recipe.features.size());
    proof_.forecast.ways = std::make_shared<motion::KnownWays>();
    planner_.keep_ways(proof_.forecast.ways);
    at_ = parked(machine, at_);
  }

  Result<NominalProof> prove(const recipes::Job& job) {
    const auto proved = step_through(job, state_, [this](const auto& step) -> Result<JobState> {
      proof_.steps.emplace_back(step);
      const double before_s = proof_.forecast.s;
      auto after = take(step);
      if (std::string what = words_of(step, recipe_); !what.empty())
        proof_.forecast.steps.push_back({std::move(what), proof_.forecast.s - before_s});
      return after;
    });
    if (!proved) return tl::unexpected(proved.error());
    return std::move(proof_);
  }

 private:
  Result<JobState> take(const SettleOffset&) { return know(after_offset(state_, {})); }
  Result<JobState> take(const SettleSurface&) { return know(after_surface(state_, {})); }
  Result<JobState> take(const recipes::LookAtMark& step) {
    if (auto r = add(step); !r) return tl::unexpected(r.error());
    proof_.forecast.s += machine_.camera.answer_latency_s;
    return know(after_mark(recipe_, state_, step.mark, recipe_.marks[step.mark].at));
  }
  Result<JobState> take(const recipes::Touch& step) {
    const AxisVec surface = planner_.probe_at(step.touch, 0);
    if (auto r = add(step, &surface); !r) return tl::unexpected(r.error());
    if (machine_.probe.fast_mm_s > 0) {
      if (auto r = add(BackOff{step.touch}); !r) return tl::unexpected(r.error());
      if (auto r = add(TouchAgain{step.touch}, &surface); !r) return tl::unexpected(r.error());
    }
    return after_touch(state_, step.touch, 0);
  }
  Result<JobState> take(const Retract& step) {
    if (auto r = add(step); !r) return tl::unexpected(r.error());
    return after_retract(state_);
  }
  /// Whether the job will purge is not known yet: it is proved as if it did.
  Result<JobState> take(const recipes::PurgeNeedle& step) {
    const AxisVec from = at_;
    if (auto r = add(step); !r) return tl::unexpected(r.error());
    proof_.forecast.purge = PurgeStep{proof_.forecast.steps.size(), from, at_};
    return after_block(state_);
  }
  Result<JobState> take(const recipes::Dispense& step) {
    if (auto r = add(step); !r) return tl::unexpected(r.error());
    return after_block(state_);
  }
  Result<JobState> take(const recipes::Park& step) {
    if (auto r = add(step); !r) return tl::unexpected(r.error());
    return after_block(state_);
  }

  JobState know(JobState state) {
    planner_.know(state.known);
    return state;
  }

  /// `surface`: the block ends where the probe latches, with the axes there.
  Result<void> add(BlockStep step, const AxisVec* surface = nullptr) {
    auto planned = plan(planner_, {std::move(step), ++block_, at_, state_.known});
    if (!planned) return tl::unexpected(planned.error());
    proof_.motions += planned->motions();
    proof_.poses += planned->poses();
    take_nearer(proof_.nearest, planned->nearest());
    const BlockEnd end =
        surface != nullptr ? touched(machine_, *planned, *surface) : BlockEnd{planned->duration_s(), planned->end()};
    proof_.forecast.s += end.s;
    add_times(proof_.forecast.features, *planned, breath_);
    proof_.run_ups.insert(proof_.run_ups.end(), planned->run_ups().begin(), planned->run_ups().end());
    add_slow_beads(proof_.slow_beads, recipe_, planned->segments(), machine_, breath_);
    at_ = end.at;
    discard(*std::move(planned), breath_);
    return {};
  }

  const config::Machine& machine_;
  const recipes::Recipe& recipe_;
  const Breath& breath_;
  BlockPlanner planner_;
  JobState state_;
  AxisVec at_{};
  std::uint32_t block_ = 0;
  NominalProof proof_;
};

}  // namespace

Result<NominalProof> prove_nominal(const config::Machine& machine, const recipes::Recipe& recipe,
                                   const recipes::Job& job, const Breath& breath, const motion::Opinion& opinion,
                                   const Progress& progress) {
  const std::size_t total = recipes::dispensed_by(job).size() * (asks_wherever(recipe) ? 2 : 1);
  std::size_t done = 0;
  const auto count = [&] {
    if (progress) progress(std::min(++done, total), total);
  };
  auto proof = Prover(machine, recipe, job, breath, opinion, count).prove(job);
  if (!proof) return proof;
  auto named = only_when_placed(machine, recipe, job, breath, count);
  if (!named) return tl::unexpected(named.error());
  proof->only_when_placed = *std::move(named);
  return proof;
}

}  // namespace gantry::job
