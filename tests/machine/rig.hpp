// A whole machine in virtual time for a test: owner, loop, master, virtual bus and world, in this one thread.
//   Rig rig({.placement = "dx=1 mm, rot=0.5 deg", .script = "- {at: feature dot 7, do: drive_fault, axis: X, code:
//   0x0E}"}); record::JobResult r = rig.run("recipes/demo-board.yaml");
#pragma once
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "sim/station/habits.hpp"

namespace gantry::test {

inline constexpr const char *kDemo = "recipes/demo-board.yaml", *kShort = "tests/cli/short-board.yaml";

struct RigOptions {
  std::string placement{};
  std::string script{};  ///< world script, YAML
  std::uint64_t seed = 1;
  std::string machine = "config/machines/dispenser.yaml";
  std::function<void(config::Machine&)> change{};  ///< made to the machine file's content
  std::function<void(config::Machine&)> wired{};   ///< made to the simulated machine alone, after `change`
  std::vector<std::pair<const char*, sim::StationHabits>> habits{};  ///< of its stations, by name
  bool outlives_stops = false;                                       ///< as in run::RunOptions
};

class Rig {
 public:
  explicit Rig(const RigOptions& options);
  ~Rig();

  /// Loads, compiles, brings up if that was not done yet, runs. What fails before the job starts comes back as the
  /// result's errors.
  record::JobResult run(const std::string& recipe_file);
  record::JobResult run(const recipes::Recipe& recipe);

  run::Owner& owner() { return *owner_; }
  const config::Machine& machine() const { return machine_; }
  /// Called in every step of the run thread.
  std::function<void(run::Owner&)> on_step;

 private:
  RigOptions options_;
  config::Machine machine_;
  std::string script_file_;
  std::unique_ptr<run::Owner> owner_;
};

/// Idles until the reset that was taken has its answer.
Result<void> answer_of_reset(run::Owner& owner);

recipes::Recipe load_recipe(const std::string& file);

}  // namespace gantry::test
