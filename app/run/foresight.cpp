#include "app/run/foresight.hpp"

#include <chrono>
#include <utility>

#include "core/background.hpp"

namespace gantry::run {

Foresight::Foresight(const config::Machine& machine, const recipes::Recipe& recipe, Options options)
    : machine_(machine), recipe_(recipe), options_(std::move(options)) {}

Foresight::~Foresight() { given_up_ = true; }

std::unique_ptr<job::BlockPlanner> Foresight::new_planner(Breath breath) const {
  auto planner = std::make_unique<job::BlockPlanner>(machine_, recipe_, std::move(breath), options_.opinion);
  if (options_.lists_motions) planner->list_motions();
  planner->know_ways(options_.ways);
  return planner;
}

bool Foresight::working() const {
  return worker_.valid() && worker_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

void Foresight::take_back() {
  if (!worker_.valid() || working()) return;
  Done done = worker_.get();
  planner_ = std::move(done.planner);
  block_ = std::move(done.block);
}

void Foresight::throw_away() {
  wanted_.reset();
  given_up_ = true;
  take_back();
  if (block_ && *block_) job::discard(**std::exchange(block_, std::nullopt), options_.breath);
  block_.reset();
}

void Foresight::begin(std::optional<job::BlockWanted> wanted) {
  throw_away();
  if (!wanted || working()) return;
  given_up_ = false;
  wanted_ = std::move(wanted);
  if (options_.thread == Thread::Callers) {
    if (!planner_) planner_ = new_planner(options_.breath);
    planner_->know(wanted_->known);
    block_ = job::plan(*planner_, *wanted_);
    return;
  }
  // The first planner is made by the worker: a tree over thousands of parts takes its time.
  worker_ = in_background([this, planner = std::move(planner_), of = *wanted_]() mutable {
    if (!planner) planner = new_planner([this] { return !given_up_; });
    planner->know(of.known);
    auto block = job::plan(*planner, of);
    return Done{std::move(planner), std::move(block)};
  });
}

std::optional<Result<job::ProvenBlock>> Foresight::take(const job::BlockWanted& wanted,
                                                        const std::function<bool()>& serve) {
  const bool right = wanted_ && *wanted_ == wanted;
  while (right && working())
    if (!serve()) break;
  take_back();
  if (!right || !block_ || (!*block_ && block_->error().fault == Fault::Aborted)) {
    throw_away();
    return std::nullopt;
  }
  wanted_.reset();
  return std::exchange(block_, std::nullopt);
}

}  // namespace gantry::run
