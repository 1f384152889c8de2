// What goes wrong in a job, and what the machine then does: every stop closes the valve, and the exit code and the
// words name the cause.
#include <algorithm>
#include <fmt/format.h>

#include "app/job/prove.hpp"
#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Rig;

using test::kDemo;

const Error& only_error(const record::JobResult& result) {
  static const Error none{Fault::None, "", ""};
  EXPECT_FALSE(result.errors.empty());
  return result.errors.empty() ? none : result.errors.front();
}

bool valve_open(const run::Owner& owner) { return (owner.latest().outputs & config::bit(config::Output::Valve)) != 0; }

TEST(Faults, a_missing_mark_ends_the_job_with_6) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: job start, do: remove_mark, name: back_right}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::VisionOrProbe);
  EXPECT_NE(only_error(result).message.find("back_right"), std::string::npos) << only_error(result).message;
  EXPECT_TRUE(result.deposits.empty());
}

TEST(Faults, a_picture_that_does_not_come_is_taken_once_more_R65) {
  const std::string dead = "- {at: mark front_left, do: camera_dead}\n";
  Rig once({.placement = "dx=0.5 mm", .script = dead + "- {at: mark front_left, after: 5 ms, do: camera_alive}\n"});
  const auto good = once.run(kDemo);
  EXPECT_EQ(good.exit_code, ExitCode::Done);
  ASSERT_EQ(good.marks.size(), 4u);
  EXPECT_EQ(good.marks[0].attempts, 2);

  Rig gone({.placement = "dx=0.5 mm", .script = dead});
  const auto bad = gone.run(kDemo);
  EXPECT_EQ(bad.exit_code, ExitCode::VisionOrProbe);
  EXPECT_EQ(only_error(bad).fault, Fault::CameraTimeout);
  EXPECT_TRUE(bad.deposits.empty());
}

/// The answer is due a fixed time after the exposure; with none left it always comes late, and is used all the same.
TEST(Faults, an_answer_that_takes_longer_than_the_machine_file_says_is_told) {
  Rig rig({.placement = "dx=0.5 mm", .change = [](config::Machine& m) { m.camera.answer_latency_s = -0.001; }});
  const test::Said said;
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
  EXPECT_EQ(said.count({"[G611]", "mark"}), 4) << said.all();
}

TEST(Faults, a_script_entry_beyond_the_end_of_the_job_is_told_with_its_line) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature dot 1, do: duplicate_frames, count: 1}\n"
                     "- {at: cycle 90000000, do: lose_frames, count: 3}\n"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Done);
  ASSERT_EQ(result.events.size(), 2u);
  EXPECT_NE(result.events[0].find("[G132]"), std::string::npos) << result.events[0];
  EXPECT_TRUE(result.events[1].ends_with(":2:3: lose_frames at cycle 90000000 did not happen before the job ended"))
      << result.events[1];
}

/// Also of the jobs behind it, whose time it is not either.
TEST(Faults, a_script_entry_that_a_job_has_ended_without_is_told_once) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: cycle 90000000, do: lose_frames, count: 3}\n"});
  const auto told = [&] {
    const auto result = rig.run("tests/cli/short-board.yaml");
    return std::count_if(result.events.begin(), result.events.end(),
                         [](const std::string& e) { return e.find("did not happen") != std::string::npos; });
  };
  EXPECT_EQ(told(), 1);
  EXPECT_EQ(told(), 0);
  EXPECT_EQ(told(), 0);
}

TEST(Faults, marks_that_disagree_are_refused_with_6) {
  Rig rig(
      {.placement = "dx=0.5 mm", .script = "- {at: job start, do: move_mark, name: back_right, by: [0.4 mm, 0 mm]}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::VisionOrProbe);
  EXPECT_EQ(only_error(result).fault, Fault::ResidualTooLarge);
  EXPECT_TRUE(result.deposits.empty());
}

TEST(Faults, a_drive_fault_in_mid_bead_stops_everything_and_closes_the_valve) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 2, after: 300 ms, do: drive_fault, axis: X, code: 0x0E}"});
  CycleIndex fault_at = 0, closed_at = 0;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (fault_at == 0 && s.error_code[0] != 0) {
      fault_at = s.cycle;
      EXPECT_TRUE(valve_open(owner)) << "the fault comes in the middle of a bead";
    }
    if (fault_at != 0 && closed_at == 0 && !valve_open(owner)) closed_at = s.cycle;
  };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Device);
  EXPECT_EQ(only_error(result).fault, Fault::DriveFault);
  EXPECT_NE(only_error(result).message.find("above 60 V"), std::string::npos)
      << "the drive's own text: " << only_error(result).message;
  EXPECT_NE(only_error(result).where.find("axis X"), std::string::npos);
  ASSERT_GT(fault_at, 0);
  EXPECT_LE(closed_at - fault_at, 1) << "the valve closes in the next frame";
  EXPECT_LT(result.features_done, result.features_total);
  EXPECT_FALSE(valve_open(rig.owner()));
}

TEST(Faults, a_latch_stays_until_reset_and_reset_starts_no_motion) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 3, do: drive_fault, axis: Y, code: 0x3210}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Device);
  for (int i = 0; i < 3000; ++i) rig.owner().idle();
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Stopped);
  EXPECT_NE(rig.owner().latest().latched, Fault::None);
  const AxisVec before = rig.owner().latest().actual;
  ASSERT_TRUE(rig.owner().order({.kind = run::OrderKind::Reset}));
  for (int i = 0; i < 3000; ++i) rig.owner().idle();
  EXPECT_EQ(rig.owner().latest().latched, Fault::None);
  EXPECT_EQ(rig.owner().latest().enabled, 0u) << "nothing is enabled again by a reset";
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(rig.owner().latest().actual[i], before[i], 0.01) << i;
}

TEST(Faults, a_cut_cable_ends_the_job_with_5) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 5, do: cut_link, station: z}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Device);
}

TEST(Faults, of_two_drives_on_one_axis_the_one_at_fault_is_named) {
  for (const auto& [drive, name] : {std::pair{0, "station 2 'y1'"}, std::pair{1, "station 3 'y2'"}}) {
    Rig rig({.placement = "dx=0.5 mm",
             .script = "- {at: feature bead 2, do: drive_fault, axis: Y, drive: " + std::to_string(drive) +
                       ", code: 0x3210}"});
    const auto result = rig.run(kDemo);
    EXPECT_EQ(result.exit_code, ExitCode::Device);
    ASSERT_FALSE(result.errors.empty());
    EXPECT_EQ(result.errors.front().where, std::string("axis Y, ") + name);
  }
}

/// An obstacle that stands in no file: the proof cannot know it, the world sees the crash.
std::string forgotten_tool(const std::string& at) {
  return "- {at: " + at +
         ", do: add_obstacle, name: forgotten_tool, centre: [240 mm, 190 mm, -95 mm], size: [60 mm, 60 mm, 30 mm]}";
}

TEST(Faults, the_world_counts_what_the_planner_was_not_told) {
  Rig rig({.placement = "dx=0 mm", .script = forgotten_tool("job start")});
  const auto result = rig.run(kDemo);
  ASSERT_FALSE(result.collisions.empty());
  EXPECT_EQ(result.collisions.front().standing, "forgotten_tool");
}

TEST(Faults, a_job_that_the_world_saw_crash_is_not_done) {
  Rig rig({.placement = "dx=0 mm", .script = forgotten_tool("feature dot 5")});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.features_done, result.features_total);
  EXPECT_EQ(result.exit_code, ExitCode::NotFeasible);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_NE(result.errors.front().message.find("forgotten_tool"), std::string::npos);
}

TEST(Faults, an_obstacle_on_the_only_path_is_refused_before_anything_moves) {
  recipes::Recipe recipe = test::load_recipe(kDemo);
  // A block over a dot: no path down to it.
  const auto& dot = std::get<recipes::Dot>(recipe.features.front());
  recipe.parts.push_back(
      {.name = "roof", .at = dot.at, .size = {6, 6, 17}, .rotation = 0, .fixture = true, .location = {}});
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const auto job = recipes::compile(recipe, *machine);
  ASSERT_TRUE(job) << to_text(job.error().front());
  const auto proof = job::prove_nominal(*machine, recipe, *job);
  ASSERT_FALSE(proof);
  EXPECT_EQ(info(proof.error().fault).exit_code, ExitCode::NotFeasible);
  EXPECT_NE(proof.error().message.find("needle"), std::string::npos) << proof.error().message;
  EXPECT_NE(proof.error().message.find("roof"), std::string::npos) << proof.error().message;
  EXPECT_EQ(proof.error().where, fmt::format("{}:{}:{}", recipe.file, dot.location.line, dot.location.column));
}

}  // namespace
}  // namespace gantry
