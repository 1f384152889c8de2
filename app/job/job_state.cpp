#include "app/job/job_state.hpp"

#include <algorithm>
#include <utility>

#include "app/job/settle.hpp"

namespace gantry::job {
namespace {

template <class... F>
struct Match : F... {
  using F::operator()...;
};
template <class... F>
Match(F...) -> Match<F...>;

}  // namespace

Next next(const recipes::Job& job, const JobState& state) {
  if (state.block >= job.blocks.size()) return Ended{};
  const recipes::Block& block = job.blocks[state.block];
  if (recipes::needs_offset(block) && !state.known.offset) return SettleOffset{};
  if (recipes::needs_surface(block) && !state.known.surface) return SettleSurface{};
  return std::visit(Match{[&](const recipes::Touch& touch) -> Next {
                            if (state.pressing) return Retract{touch.touch};
                            return touch;
                          },
                          [&](const recipes::Dispense& all) -> Next {
                            recipes::Dispense open;
                            std::copy_if(all.features.begin(), all.features.end(), std::back_inserter(open.features),
                                         [&](std::size_t f) { return state.features[f] == FeatureState::Open; });
                            return open;
                          },
                          [](const auto& as_it_is) -> Next { return as_it_is; }},
                    block.what);
}

JobState begin_state(const recipes::Recipe& recipe, const recipes::Job& job) {
  JobState state;
  state.features.assign(recipe.features.size(), FeatureState::LeftOut);
  for (const std::size_t f : recipes::dispensed_by(job)) state.features[f] = FeatureState::Open;
  return state;
}

JobState after_mark(const recipes::Recipe& recipe, JobState state, std::size_t mark, Vec2 at_mm) {
  state.known.marks.push_back({mark, at_mm});
  state.known.guess = guess_offset(recipe, state.known.marks);
  ++state.block;
  return state;
}

LaidPart laid_of(const std::vector<LaidPart>& laid, std::size_t feature) {
  const auto found =
      std::find_if(laid.begin(), laid.end(), [&](const LaidPart& each) { return each.feature == feature; });
  return found == laid.end() ? LaidPart{feature, 0, 0, 0} : *found;
}

JobState after_cut(JobState state, const LaidPart& part) {
  state.features[part.feature] = FeatureState::Open;
  const auto known = std::find_if(state.laid.begin(), state.laid.end(),
                                  [&](const LaidPart& each) { return each.feature == part.feature; });
  if (known == state.laid.end())
    state.laid.push_back(part);
  else
    *known = part;
  return state;
}

JobState after_offset(JobState state, const recipes::WorkOffset& offset) {
  state.known.offset = state.known.guess = offset;
  return state;
}

JobState after_touch(JobState state, std::size_t touch, double height_mm) {
  state.known.heights.push_back({touch, height_mm});
  state.pressing = true;
  return state;
}

JobState after_retract(JobState state) {
  state.pressing = false;
  ++state.block;
  return state;
}

JobState after_surface(JobState state, const recipes::Surface& surface) {
  state.known.surface = surface;
  return state;
}

JobState after_block(JobState state) {
  ++state.block;
  return state;
}

JobState lost_sight(JobState state) {
  std::replace(state.features.begin(), state.features.end(), FeatureState::Begun, FeatureState::Doubtful);
  return state;
}

std::size_t count(const JobState& state, FeatureState what) {
  return static_cast<std::size_t>(std::count(state.features.begin(), state.features.end(), what));
}

}  // namespace gantry::job
