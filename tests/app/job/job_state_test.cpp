// What comes next in a job, against a model that knows nothing of blocks: it counts marks, touches and features.
#include "app/job/job_state.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "app/job/prove.hpp"
#include "config/machine.hpp"
#include "recipes/selection.hpp"

namespace gantry::job {
namespace {

/// In words, so that a difference can be read.
std::string words(const Next& step) {
  struct {
    std::string operator()(const SettleOffset&) { return "offset"; }
    std::string operator()(const SettleSurface&) { return "surface"; }
    std::string operator()(const recipes::LookAtMark& s) { return fmt::format("mark {}", s.mark); }
    std::string operator()(const recipes::Touch& s) { return fmt::format("touch {}", s.touch); }
    std::string operator()(const Retract& s) { return fmt::format("retract {}", s.touch); }
    std::string operator()(const recipes::PurgeNeedle&) { return "purge"; }
    std::string operator()(const recipes::Dispense& s) {
      std::string out = "dispense";
      for (const std::size_t f : s.features) out += fmt::format(" {}", f);
      return out;
    }
    std::string operator()(const recipes::Park&) { return "park"; }
    std::string operator()(const Ended&) { return "ended"; }
  } in_words;
  return std::visit(in_words, step);
}
std::vector<std::string> words(const std::vector<Next>& steps) {
  std::vector<std::string> out;
  for (const Next& s : steps) out.push_back(words(s));
  return out;
}

/// The model: how a job goes by what docs say of it.
std::vector<std::string> model(std::size_t marks, std::size_t touches, std::size_t features, bool purge = false) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < marks; ++i) out.push_back("mark " + std::to_string(i));
  out.emplace_back("offset");
  for (std::size_t i = 0; i < touches; ++i) {
    out.push_back("touch " + std::to_string(i));
    out.push_back("retract " + std::to_string(i));
  }
  out.emplace_back("surface");
  if (purge) out.emplace_back("purge");
  std::string all = "dispense";
  for (std::size_t i = 0; i < features; ++i) all += " " + std::to_string(i);
  out.push_back(all);
  out.emplace_back("park");
  return out;
}

/// A runner without a machine: the world answers at random.
struct SimulatedRunner {
  const recipes::Recipe& recipe;
  JobState& state;
  std::mt19937_64& random;
  std::vector<std::string> visited{};
  int stop_before = -1;  // a step that fails

  double any() { return std::uniform_real_distribution<double>(-1, 1)(random); }
  template <class Step>
  Result<JobState> operator()(const Step& step) {
    if (static_cast<int>(visited.size()) == stop_before) return fail(Fault::Aborted, "stopped here");
    visited.push_back(words(Next{step}));
    return take(step);
  }
  Result<JobState> take(const SettleOffset&) { return after_offset(state, {{any(), any()}, any()}); }
  Result<JobState> take(const SettleSurface&) { return after_surface(state, {any(), {any(), any()}}); }
  Result<JobState> take(const recipes::LookAtMark& s) { return after_mark(recipe, state, s.mark, {any(), any()}); }
  Result<JobState> take(const recipes::Touch& s) { return after_touch(state, s.touch, any()); }
  Result<JobState> take(const Retract&) { return after_retract(state); }
  Result<JobState> take(const recipes::PurgeNeedle&) { return after_block(state); }
  Result<JobState> take(const recipes::Dispense&) { return after_block(state); }
  Result<JobState> take(const recipes::Park&) { return after_block(state); }
};

std::vector<std::string> run(const recipes::Recipe& recipe, const recipes::Job& job, JobState& state, unsigned seed,
                             int stop_before = -1) {
  std::mt19937_64 random(seed);
  SimulatedRunner runner{recipe, state, random};
  runner.stop_before = stop_before;
  const auto ended = step_through(job, state, [&](const auto& step) { return runner(step); });
  EXPECT_EQ(ended.has_value(), stop_before < 0);
  return runner.visited;
}

config::Machine reference() {
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  EXPECT_TRUE(machine);
  return *machine;
}

recipes::Recipe recipe_of(const std::string& text) {
  auto recipe = recipes::parse(text, "random.yaml");
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e) << "\n" << text;
  return {};
}

std::string random_text(std::size_t marks, std::size_t touches, std::size_t features) {
  constexpr int kAt[4][2] = {{10, 10}, {70, 45}, {70, 10}, {10, 45}};
  std::string text =
      "version: 1\nrecipe: random\nboard: {size: [80 mm, 55 mm], thickness: 1.6 mm, frame: pallet}\n"
      "materials:\n  glue: {speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
      "dot_time: 30 ms, settle_time: 10 ms, retract: 3 mm}\n";
  const auto points = [&](const char* key, char name, std::size_t n, const char* more) {
    if (n > 0) text += std::string(key) + ":\n";
    for (std::size_t i = 0; i < n; ++i)
      text += fmt::format("  {}{}: {{at: [{} mm, {} mm]{}}}\n", name, i, kAt[i][0], kAt[i][1], more);
  };
  points("marks", 'm', marks, ", diameter: 1.5 mm");
  points("touches", 't', touches, "");
  text += "features:\n";
  for (std::size_t i = 0; i < features; ++i)
    text += fmt::format("  - dot: {{name: d{}, material: glue, at: [{} mm, {} mm]}}\n", i, 20 + 3 * i, 20 + i);
  return text;
}

TEST(JobState, the_prover_and_a_runner_go_through_every_job_as_the_model_does) {
  const config::Machine machine = reference();
  for (std::size_t marks = 0; marks <= 4; ++marks)
    for (std::size_t touches = 0; touches <= 4; ++touches)
      for (const std::size_t features : {1, 2, 7}) {
        SCOPED_TRACE(fmt::format("{} marks, {} touches, {} features", marks, touches, features));
        recipes::Recipe recipe = recipe_of(random_text(marks == 1 ? 2 : marks, touches, features));
        if (marks == 1) recipe.marks.pop_back();  // the format wants two; the step function does not
        const auto job = recipes::compile(recipe, machine);
        ASSERT_TRUE(job) << to_text(job.error().front());
        const auto expected = model(marks, touches, features);
        JobState state = begin_state(recipe, *job);
        EXPECT_EQ(run(recipe, *job, state, 7), expected);
        EXPECT_EQ(words(next(*job, state)), "ended");
        EXPECT_EQ(state.known.marks.size(), marks);
        EXPECT_EQ(state.known.heights.size(), touches);
        const auto proof = prove_nominal(machine, recipe, *job);
        ASSERT_TRUE(proof) << to_text(proof.error());
        EXPECT_EQ(words(proof->steps), expected);
      }
}

TEST(JobState, shipped_recipes_go_as_the_model_does) {
  const config::Machine machine = reference();
  int seen = 0;
  for (const char* folder : {"recipes", "tests/cli"})
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      if (file.path().extension() != ".yaml") continue;
      SCOPED_TRACE(file.path());
      const auto recipe = recipes::load(file.path());
      ASSERT_TRUE(recipe);
      const auto job = recipes::compile(*recipe, machine);
      ASSERT_TRUE(job);
      const auto expected =
          model(recipe->marks.size(), recipe->touches.size(), recipe->features.size(), recipe->purge.has_value());
      JobState state = begin_state(*recipe, *job);
      EXPECT_EQ(run(*recipe, *job, state, 3), expected);
      const auto proof = prove_nominal(machine, *recipe, *job);
      ++seen;
      if (file.path().stem() == "portal-closed") {
        ASSERT_FALSE(proof);
        EXPECT_EQ(proof.error().fault, Fault::Collision);
        continue;
      }
      ASSERT_TRUE(proof) << to_text(proof.error());
      EXPECT_EQ(words(proof->steps), expected);
    }
  EXPECT_GE(seen, 2);
}

TEST(JobState, a_copy_of_any_prefix_goes_on_as_the_whole_does) {
  const config::Machine machine = reference();
  const recipes::Recipe recipe = recipe_of(random_text(3, 3, 5));
  const auto job = recipes::compile(recipe, machine);
  ASSERT_TRUE(job);
  const auto whole = model(3, 3, 5);
  for (int cut = 0; cut < static_cast<int>(whole.size()); ++cut) {
    SCOPED_TRACE(cut);
    JobState state = begin_state(recipe, *job);
    auto visited = run(recipe, *job, state, 11, cut);
    EXPECT_EQ(visited, std::vector<std::string>(whole.begin(), whole.begin() + cut));
    JobState copy = state;
    EXPECT_EQ(copy, state);
    const auto rest = run(recipe, *job, copy, 5);
    EXPECT_EQ(rest, std::vector<std::string>(whole.begin() + cut, whole.end()));
    EXPECT_NE(copy, state) << "the copy went on alone";
    EXPECT_EQ(run(recipe, *job, state, 5), rest);
    EXPECT_EQ(copy, state);
  }
}

TEST(JobState, features_that_are_no_longer_open_are_not_dispensed_again) {
  const config::Machine machine = reference();
  std::mt19937_64 random(5);
  const recipes::Recipe recipe = recipe_of(random_text(0, 0, 12));
  const auto job = recipes::compile(recipe, machine);
  ASSERT_TRUE(job);
  for (int n = 0; n < 200; ++n) {
    JobState state = after_surface(after_offset(begin_state(recipe, *job), {}), {});
    std::string expected = "dispense";
    for (std::size_t f = 0; f < 12; ++f) {
      state.features[f] = static_cast<FeatureState>(std::uniform_int_distribution<int>(0, 5)(random));
      if (state.features[f] == FeatureState::Open) expected += fmt::format(" {}", f);
    }
    EXPECT_EQ(words(next(*job, state)), expected);
    const JobState lost = lost_sight(state);
    EXPECT_EQ(count(lost, FeatureState::Begun), 0u);
    EXPECT_EQ(count(lost, FeatureState::Doubtful),
              count(state, FeatureState::Begun) + count(state, FeatureState::Doubtful));
  }
}

TEST(JobState, what_a_job_leaves_out_is_left_out_and_all_that_features_need_is_done) {
  const config::Machine machine = reference();
  const recipes::Recipe recipe = recipe_of(random_text(3, 3, 5));
  auto job = recipes::compile(recipe, machine);
  ASSERT_TRUE(job);
  *job = recipes::only(*job, {1, 4});
  JobState state = begin_state(recipe, *job);
  using enum FeatureState;
  EXPECT_EQ(state.features, (std::vector{LeftOut, Open, LeftOut, LeftOut, Open}));
  auto expected = model(3, 3, 5);
  for (std::string& step : expected)
    if (step.starts_with("dispense")) step = "dispense 1 4";
  EXPECT_EQ(run(recipe, *job, state, 7), expected);
  const auto proof = prove_nominal(machine, recipe, *job);
  ASSERT_TRUE(proof) << to_text(proof.error());
  EXPECT_EQ(words(proof->steps), expected);
}

TEST(JobState, one_mark_gives_the_shift_and_two_the_rotation) {
  recipes::Recipe recipe;
  recipe.marks = {{.name = "a", .at = {0, 0}, .location = {}}, {.name = "b", .at = {10, 0}, .location = {}}};
  JobState state = after_mark(recipe, begin_state(recipe, {}), 0, {1, 2});
  EXPECT_EQ(state.known.guess, (recipes::WorkOffset{{1, 2}, 0}));
  state = after_mark(recipe, state, 1, {1, 12});  // a quarter turn
  EXPECT_NEAR(state.known.guess.rotation, 1.5707963267948966, 1e-12);
  EXPECT_NEAR(state.known.guess.shift.x, 1, 1e-12);
  EXPECT_NEAR(state.known.guess.shift.y, 2, 1e-12);
}

}  // namespace
}  // namespace gantry::job
