#include "bench/plan/fcl_planner.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

namespace gantry::bench {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Space = ob::RealVectorStateSpace;

Vec3 position(const ob::State* state) {
  const auto* s = state->as<Space::StateType>();
  return {s->values[0], s->values[1], s->values[2]};
}

class Sampled : public ob::MotionValidator {
 public:
  Sampled(ob::SpaceInformation* si, FclScene& scene) : ob::MotionValidator(si), scene_(scene) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return scene_.line_is_free(position(a), position(b));
  }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last) const override {
    last.second = 0;
    return checkMotion(a, b);
  }

 private:
  FclScene& scene_;
};

}  // namespace

std::vector<Vec3> fcl_plan(FclScene& scene, Vec3 low, Vec3 high, Vec3 from, Vec3 to) {
  ompl::msg::noOutputHandler();
  const auto space = std::make_shared<Space>(3);
  ob::RealVectorBounds bounds(3);
  bounds.low = {low.x, low.y, low.z}, bounds.high = {high.x, high.y, high.z};
  space->setBounds(bounds);
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  si->setStateValidityChecker([&](const ob::State* s) { return !scene.collides(position(s)); });
  si->setMotionValidator(std::make_shared<Sampled>(si.get(), scene));
  si->setup();
  const auto problem = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<Space> start(space), goal(space);
  start[0] = from.x, start[1] = from.y, start[2] = from.z;
  goal[0] = to.x, goal[1] = to.y, goal[2] = to.z;
  problem->setStartAndGoalStates(start, goal);
  og::RRTConnect planner(si);
  planner.setProblemDefinition(problem);
  planner.setup();
  planner.ob::Planner::solve(1.0);
  if (!problem->hasExactSolution()) return {};
  auto path = *problem->getSolutionPath()->as<og::PathGeometric>();
  og::PathSimplifier(si).simplifyMax(path);
  std::vector<Vec3> out;
  for (const ob::State* s : path.getStates()) out.push_back(position(s));
  return out;
}

}  // namespace gantry::bench
