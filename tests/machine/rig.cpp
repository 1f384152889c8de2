#include "tests/machine/rig.hpp"

#include <cstdlib>
#include <fstream>
#include <map>
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

// Tests ask for the same few files again and again. What a file of the source tree holds is read once, and a recipe is
// proved once on a machine that no test has changed: both depend on nothing else.
bool of_the_source(const std::string& file) { return !file.starts_with('/'); }
template <class Read>
const auto& once(const std::string& key, Read&& read) {
  static std::map<std::string, decltype(read())> kept;
  const auto found = kept.find(key);
  return found != kept.end() ? found->second : kept.emplace(key, read()).first->second;
}

Checked<config::Machine> machine_of(const std::string& file) {
  const auto read = [&] { return config::load_machine(file); };
  return of_the_source(file) ? once(file, read) : read();
}
Checked<recipes::Recipe> recipe_of(const std::string& file) {
  const auto read = [&] { return recipes::load(file); };
  return of_the_source(file) ? once(file, read) : read();
}

using OnStep = std::function<void(run::Owner&)>;
using Prove = std::function<Result<job::NominalProof>(const recipes::Job&)>;

record::JobResult run_on(run::Owner& owner, const config::Machine& machine, const recipes::Recipe& recipe,
                         const OnStep& on_step, bool outlives_stops, const Prove& prove) {
  const auto job = recipes::compile(recipe, machine);
  if (!job) return failed(job.error());
  owner.on_step([&] {
    if (on_step) on_step(owner);
  });
  if (owner.latest().cycle == 0)
    if (auto up = owner.bring_up(); !up) return failed({up.error()});
  const auto proof = prove(*job);
  return owner.run(
      recipe, *job,
      {.forecast = proof ? &proof->forecast : nullptr,
       .slow_beads = proof ? std::span<const job::SlowBead>(proof->slow_beads) : std::span<const job::SlowBead>(),
       .outlives_stops = outlives_stops});
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
  auto recipe = recipe_of(file);
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}

Rig::Rig(const RigOptions& options) : options_(options) {
  auto machine = machine_of(options.machine);
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
  auto recipe = recipe_of(recipe_file);
  if (!recipe) return failed(recipe.error());
  if (options_.change || !of_the_source(options_.machine) || !of_the_source(recipe_file)) return run(*recipe);
  return run_on(*owner_, machine_, *recipe, on_step, options_.outlives_stops, [&](const recipes::Job& job) {
    return once(options_.machine + " " + recipe_file, [&] { return job::prove_nominal(machine_, *recipe, job); });
  });
}

record::JobResult Rig::run(const recipes::Recipe& recipe) {
  return run_on(*owner_, machine_, recipe, on_step, options_.outlives_stops,
                [&](const recipes::Job& job) { return job::prove_nominal(machine_, recipe, job); });
}

}  // namespace gantry::test
