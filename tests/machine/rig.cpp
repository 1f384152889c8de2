#include "tests/machine/rig.hpp"

#include <cstdlib>
#include <fstream>
#include <unistd.h>

#include "app/job/prove.hpp"

namespace gantry::test {
namespace {

record::JobResult failed(std::vector<Error> errors) {
  record::JobResult result;
  result.exit_code = info(errors.front().fault).exit_code;
  result.errors = std::move(errors);
  return result;
}

}  // namespace

Result<void> answer_of_reset(run::Owner& owner) {
  for (int i = 0; i < 5000; ++i) {
    if (const auto answer = owner.reset_answer()) return *answer;
    EXPECT_TRUE(owner.idle());
  }
  ADD_FAILURE() << "a reset without an answer";
  return {};
}

recipes::Recipe load_recipe(const std::string& file) {
  auto recipe = recipes::load(file);
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}

Rig::Rig(const RigOptions& options) : options_(options) {
  auto machine = config::load_machine(options.machine);
  if (!machine) {
    for (const Error& e : machine.error()) ADD_FAILURE() << to_text(e);
    return;
  }
  machine_ = *machine;
  if (options.change) options.change(machine_);
  if (!options_.script.empty()) {
    std::string name = "/tmp/gantry-script-XXXXXX";
    const int fd = mkstemp(name.data());
    if (fd >= 0) close(fd);
    script_file_ = name;
    std::ofstream(script_file_) << options_.script;
  }
  run::OwnerOptions owner_options;
  owner_options.virtual_time = true;
  owner_options.sim.placement = options_.placement;
  owner_options.sim.seed = options_.seed;
  owner_options.sim.script_file = script_file_;
  if (options_.wired) {
    auto truth = std::make_shared<config::Machine>(machine_);
    options_.wired(*truth);
    owner_options.sim.wired = std::move(truth);
  }
  for (const auto& [name, habits] : options_.habits)
    for (const config::Station& s : machine_.stations)
      if (s.name == name) owner_options.sim.habits.emplace_back(s.id, habits);
  auto owner = run::Owner::open(machine_, owner_options);
  if (!owner) {
    ADD_FAILURE() << to_text(owner.error());
    return;
  }
  owner_ = std::move(*owner);
}

Rig::~Rig() {
  on_step = {};  // these may look at what the test has already destroyed
  if (owner_) owner_->on_step({});
  owner_.reset();
  if (!script_file_.empty()) unlink(script_file_.c_str());
}

record::JobResult Rig::run(const std::string& recipe_file) {
  auto recipe = recipes::load(recipe_file);
  if (!recipe) return failed(recipe.error());
  return run(*recipe);
}

record::JobResult Rig::run(const recipes::Recipe& recipe) {
  const auto job = recipes::compile(recipe, machine_);
  if (!job) return failed(job.error());
  owner_->on_step([this] {
    if (on_step) on_step(*owner_);
  });
  if (owner_->latest().cycle == 0)
    if (auto up = owner_->bring_up(); !up) return failed({up.error()});
  const auto proof = job::prove_nominal(machine_, recipe, *job);
  return owner_->run(
      recipe, *job,
      {.forecast = proof ? &proof->forecast : nullptr,
       .slow_beads = proof ? std::span<const job::SlowBead>(proof->slow_beads) : std::span<const job::SlowBead>(),
       .outlives_stops = options_.outlives_stops});
}

}  // namespace gantry::test
