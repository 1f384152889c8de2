// Proves the next block while the machine works on this one: told what is likely to be wanted, it plans that on a
// thread of its own, and hands the block over when this very one is wanted. What was foreseen otherwise is thrown away.
//   Foresight ahead(machine, recipe, {.thread = Foresight::Thread::Own});
//   ahead.begin(wanted);   control.play(block);   if (auto foreseen = ahead.take(wanted, serve)) ...
// One worker at most, and what it works with is its own: the planner goes to it and comes back with the block. In
// virtual time nothing runs beside the cycle, and begin() itself plans.
#pragma once
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "app/job/block_wanted.hpp"
#include "config/machine.hpp"
#include "core/breath.hpp"
#include "core/error.hpp"
#include "motion/plan/second_opinion.hpp"
#include "recipes/job.hpp"

namespace gantry::run {

class Foresight {
 public:
  enum class Thread { Callers, Own };
  struct Options {
    Thread thread = Thread::Callers;
    Breath breath{};                                  ///< of the caller's thread
    motion::Opinion opinion{};                        ///< asked in the thread that plans
    std::shared_ptr<const motion::KnownWays> ways{};  ///< BlockPlanner::know_ways()
    bool lists_motions = false;
  };
  /// The recipe outlives it; the machine is copied, so that its owner may write to his.
  Foresight(const config::Machine& machine, const recipes::Recipe& recipe, Options options);
  /// Gives up what is planned, which ends within a feature.
  ~Foresight();
  Foresight(const Foresight&) = delete;
  Foresight& operator=(const Foresight&) = delete;

  /// This block will be wanted, if all goes as it should; nothing: none is known. What was foreseen before is thrown
  /// away. While a worker still ends that was given up, nothing is foreseen.
  void begin(std::optional<job::BlockWanted> wanted);
  /// The block, or why there is none, when it is this one that was foreseen. As long as it is not ready `serve` is
  /// called again and again, which lets about a cycle pass; as soon as it gives false, nothing is foreseen any more. A
  /// wrong foresight is thrown away.
  std::optional<Result<job::ProvenBlock>> take(const job::BlockWanted& wanted, const std::function<bool()>& serve);

  /// The one that has planned the block which was handed over last.
  [[nodiscard]] const job::BlockPlanner& planner() const { return *planner_; }

 private:
  struct Done {
    std::unique_ptr<job::BlockPlanner> planner;
    std::optional<Result<job::ProvenBlock>> block;
  };
  [[nodiscard]] std::unique_ptr<job::BlockPlanner> new_planner(Breath breath) const;
  [[nodiscard]] bool working() const;
  void throw_away();
  void take_back();

  const config::Machine machine_;
  const recipes::Recipe& recipe_;
  const Options options_;
  std::optional<job::BlockWanted> wanted_;  ///< what the block is of; nothing: it is not wanted any more
  std::atomic<bool> given_up_{false};
  std::unique_ptr<job::BlockPlanner> planner_;     ///< while no worker has it
  std::optional<Result<job::ProvenBlock>> block_;  ///< of `wanted_`, once it is planned
  std::future<Done> worker_;                       ///< last: ends before what it works with
};

}  // namespace gantry::run
