#include "motion/plan/random_tree.hpp"

#include <exception>
#include <memory>
#include <ompl/base/MotionValidator.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

namespace gantry::motion {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Space = ob::RealVectorStateSpace;

constexpr double kStep = 0.35;  // of the box's diagonal that a tree grows by at most

Vec3 position(const ob::State* state) {
  const auto* s = state->as<Space::StateType>();
  return {s->values[0], s->values[1], s->values[2]};
}
void set(ob::State* state, Vec3 p) {
  auto* s = state->as<Space::StateType>();
  s->values[0] = p.x, s->values[1] = p.y, s->values[2] = p.z;
}

/// OMPL seeds its own samplers from a sequence of the whole process; this one knows only its query's seed (splitmix64,
/// Steele, Lea, Flood 2014).
class Sampler : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, std::uint64_t seed) : ob::StateSampler(space), state_(seed) {}
  void sampleUniform(ob::State* state) override {
    const auto& bounds = space_->as<Space>()->getBounds();
    auto* s = state->as<Space::StateType>();
    for (unsigned i = 0; i < 3; ++i) s->values[i] = bounds.low[i] + (bounds.high[i] - bounds.low[i]) * next();
  }
  void sampleUniformNear(ob::State* state, const ob::State*, double) override { sampleUniform(state); }
  void sampleGaussian(ob::State* state, const ob::State*, double) override { sampleUniform(state); }

 private:
  double next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  std::uint64_t state_;
};

class Validator : public ob::MotionValidator {
 public:
  Validator(ob::SpaceInformation* si, const Clear& clear) : ob::MotionValidator(si), clear_(clear) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override { return clear_(position(a), position(b)); }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last) const override {
    last.second = 0;
    return checkMotion(a, b);
  }

 private:
  const Clear& clear_;
};

}  // namespace

std::vector<Vec3> random_tree(const Clear& clear, Vec3 low, Vec3 high, Vec3 from, Vec3 to, std::uint64_t seed,
                              int iterations) try {
  static const bool quiet = (ompl::msg::noOutputHandler(), true);
  (void)quiet;
  const auto space = std::make_shared<Space>(3);
  ob::RealVectorBounds bounds(3);
  bounds.low = {low.x, low.y, low.z}, bounds.high = {high.x, high.y, high.z};
  for (unsigned i = 0; i < 3; ++i)  // OMPL wants room in each dimension
    if (bounds.high[i] - bounds.low[i] < 1e-9) bounds.high[i] = bounds.low[i] + 1e-9;
  space->setBounds(bounds);
  space->setStateSamplerAllocator([seed](const ob::StateSpace* s) { return std::make_shared<Sampler>(s, seed); });
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  si->setStateValidityChecker([](const ob::State*) { return true; });  // the sweeps look at both ends
  si->setMotionValidator(std::make_shared<Validator>(si.get(), clear));
  si->setup();
  const auto problem = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<Space> start(space), goal(space);
  set(start.get(), from), set(goal.get(), to);
  problem->setStartAndGoalStates(start, goal);
  og::RRTConnect planner(si);
  planner.setProblemDefinition(problem);
  planner.setRange(kStep * space->getMaximumExtent());
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();  // the others draw from the sequence of the process
  planner.setup();
  int left = iterations;
  planner.solve(ob::PlannerTerminationCondition([&left] { return left-- <= 0; }));
  if (!problem->hasExactSolution()) return {};
  std::vector<Vec3> out;
  for (const ob::State* s : problem->getSolutionPath()->as<og::PathGeometric>()->getStates())
    out.push_back(position(s));
  return out;
} catch (const std::exception&) {
  return {};  // no path is claimed; the other methods of planning go on
}

}  // namespace gantry::motion
