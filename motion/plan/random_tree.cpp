#include "motion/plan/random_tree.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <functional>
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

template <std::size_t N>
using Point = std::array<double, N>;
template <std::size_t N>
using ClearPoints = std::function<bool(const Point<N>&, const Point<N>&)>;

template <std::size_t N>
Point<N> position(const ob::State* state) {
  const auto* s = state->as<Space::StateType>();
  Point<N> p;
  std::copy_n(s->values, N, p.begin());
  return p;
}
template <std::size_t N>
void set(ob::State* state, const Point<N>& p) {
  std::copy(p.begin(), p.end(), state->as<Space::StateType>()->values);
}

/// OMPL seeds its own samplers from a sequence of the whole process; this one knows only its query's seed (splitmix64,
/// Steele, Lea, Flood 2014).
class Sampler : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, std::uint64_t seed) : ob::StateSampler(space), state_(seed) {}
  void sampleUniform(ob::State* state) override {
    const auto& bounds = space_->as<Space>()->getBounds();
    auto* s = state->as<Space::StateType>();
    for (unsigned i = 0; i < bounds.low.size(); ++i)
      s->values[i] = bounds.low[i] + (bounds.high[i] - bounds.low[i]) * next();
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

template <std::size_t N>
class Validator : public ob::MotionValidator {
 public:
  Validator(ob::SpaceInformation* si, const ClearPoints<N>& clear) : ob::MotionValidator(si), clear_(clear) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return clear_(position<N>(a), position<N>(b));
  }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last) const override {
    last.second = 0;
    return checkMotion(a, b);
  }

 private:
  const ClearPoints<N>& clear_;
};

template <std::size_t N>
std::vector<Point<N>> grown(const ClearPoints<N>& clear, const Point<N>& low, const Point<N>& high,
                            const Point<N>& from, const Point<N>& to, std::uint64_t seed, int iterations) try {
  static const bool quiet = (ompl::msg::noOutputHandler(), true);
  (void)quiet;
  const auto space = std::make_shared<Space>(static_cast<unsigned>(N));
  ob::RealVectorBounds bounds(static_cast<unsigned>(N));
  bounds.low.assign(low.begin(), low.end()), bounds.high.assign(high.begin(), high.end());
  for (std::size_t i = 0; i < N; ++i)  // OMPL wants room in each dimension
    if (bounds.high[i] - bounds.low[i] < 1e-9) bounds.high[i] = bounds.low[i] + 1e-9;
  space->setBounds(bounds);
  space->setStateSamplerAllocator([seed](const ob::StateSpace* s) { return std::make_shared<Sampler>(s, seed); });
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  si->setStateValidityChecker([](const ob::State*) { return true; });  // the sweeps look at both ends
  si->setMotionValidator(std::make_shared<Validator<N>>(si.get(), clear));
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
  std::vector<Point<N>> out;
  for (const ob::State* s : problem->getSolutionPath()->as<og::PathGeometric>()->getStates())
    out.push_back(position<N>(s));
  return out;
} catch (const std::exception&) {
  return {};  // no path is claimed; the other methods of planning go on
}

}  // namespace

std::vector<Vec3> random_tree(const Clear& clear, Vec3 low, Vec3 high, Vec3 from, Vec3 to, std::uint64_t seed,
                              int iterations) {
  const auto point = [](Vec3 p) { return Point<3>{p.x, p.y, p.z}; };
  const auto place = [](const Point<3>& p) { return Vec3{p[0], p[1], p[2]}; };
  const ClearPoints<3> clear_points = [&](const Point<3>& a, const Point<3>& b) { return clear(place(a), place(b)); };
  std::vector<Vec3> out;
  for (const Point<3>& p : grown<3>(clear_points, point(low), point(high), point(from), point(to), seed, iterations))
    out.push_back(place(p));
  return out;
}

std::vector<Turned> random_turning_tree(const ClearTurned& clear, const Turned& low, const Turned& high,
                                        const Turned& from, const Turned& to, std::uint64_t seed, int iterations) {
  return grown<4>(clear, low, high, from, to, seed, iterations);
}

}  // namespace gantry::motion
