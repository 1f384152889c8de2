// When the needle is purged: by the time that the valve was shut, on the machine's own clock.
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

#include "app/job/prove.hpp"
#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

using test::Rig;

recipes::Recipe with_purge(const std::string& purge, const std::string& dot_time = "30 ms") {
  const auto recipe = recipes::parse(
      fmt::format("version: 1\nrecipe: purged\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, "
                  "frame: pallet}}\n"
                  "materials:\n  glue: {{speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
                  "dot_time: {}, settle_time: 10 ms, retract: 3 mm, tolerance: 5 mm, gap_tolerance: 2 mm}}\n"
                  "purge: {}\n"
                  "features:\n  - dot: {{name: d, material: glue, at: [10 mm, 10 mm]}}\n",
                  dot_time, purge),
      "purged.yaml");
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}

std::size_t purges(const record::JobResult& r) {
  return static_cast<std::size_t>(
      std::count_if(r.deposits.begin(), r.deposits.end(), [](const auto& d) { return d.kind == "purge"; }));
}

TEST(Purge, is_done_in_the_first_job_and_again_only_when_the_valve_was_shut_for_longer) {
  const recipes::Recipe recipe = with_purge("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 30 s}");
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult first = rig.run(recipe);
  test::expect_done(first);
  EXPECT_EQ(purges(first), 2u) << "nothing is known of a valve that was not open since the bus is up";
  EXPECT_EQ(first.purge_shots, 2u);
  EXPECT_EQ(first.features_done, 1u);
  test::expect_deposits(recipe, first);
  const record::JobResult second = rig.run(recipe);
  test::expect_done(second);
  EXPECT_LT(second.actual_s, 25);
  ASSERT_FALSE(first.steps.empty());
  for (const record::JobResult* job : {&first, &second})
    for (const auto& step : job->steps)
      EXPECT_NEAR(step.actual_s, step.predicted_s.value_or(-1), 0.004)
          << step.what << ": it is forecast without a purge";
  EXPECT_EQ(purges(second), 0u);
  EXPECT_EQ(second.features_done, 1u);
  for (int i = 0; i < 30'000; ++i) rig.owner().idle();
  const record::JobResult third = rig.run(recipe);
  test::expect_done(third);
  EXPECT_EQ(purges(third), 2u);
}

/// The block after the rise is proved while the head rises. Where the valve's time runs out meanwhile, another block is
/// wanted than was foreseen: that one is thrown away, and what is played is what is always played.
TEST(Purge, that_becomes_due_while_the_head_rises_is_done_though_it_was_not_foreseen) {
  constexpr double kAfter_s = 8;
  const recipes::Recipe recipe = with_purge("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 8 s}");
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg", .change = [](config::Machine& m) {
             for (auto& [axis, position] : m.park)
               if (axis == m.z) position -= 40;  // so that a job begins with a rise
           }});
  CycleIndex open_last = 0, job_began = 0, work_began = 0;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if ((s.outputs & config::bit(config::Output::Valve)) != 0) open_last = s.cycle;
    if (job_began == 0) job_began = s.cycle;
    if (s.block >= 2 && work_began == 0) work_began = s.cycle;
  };
  std::map<std::size_t, std::set<std::uint64_t>> streams;  // by how many shots were made
  int on_the_way = 0;
  test::expect_done(rig.run(recipe));
  for (double shut_s = kAfter_s - 1.5; shut_s < kAfter_s + 0.6; shut_s += 0.15) {
    SCOPED_TRACE(shut_s);
    const CycleIndex shut = open_last;
    while (static_cast<double>(rig.owner().latest().cycle - shut) < 1000 * shut_s) ASSERT_TRUE(rig.owner().idle());
    job_began = work_began = 0;
    const record::JobResult r = rig.run(recipe);
    test::expect_done(r);
    const double at_begin_s = static_cast<double>(job_began - shut) / 1000,
                 at_work_s = static_cast<double>(work_began - shut) / 1000;
    if (std::abs(at_work_s - kAfter_s) > 0.05) {
      EXPECT_EQ(purges(r), at_work_s > kAfter_s ? 2u : 0u) << at_work_s;
    }
    EXPECT_EQ(r.features_done, 1u);
    EXPECT_EQ(r.deposits.size(), 1 + purges(r));
    EXPECT_EQ(r.proofs.ahead + r.proofs.at_the_moment, purges(r) > 0 ? 3u : 2u) << "purge, features, parking";
    if (at_begin_s < kAfter_s - 0.05 && at_work_s > kAfter_s + 0.05) {
      ++on_the_way;
      EXPECT_GE(r.proofs.at_the_moment, 1u) << "the features were foreseen, and the purge was wanted";
    }
    streams[purges(r)].insert(r.setpoint_hash);
  }
  EXPECT_GE(on_the_way, 2);
  EXPECT_EQ(streams[2].size(), 1u);
  EXPECT_EQ(streams[0].size(), 1u);
}

TEST(Purge, is_the_same_in_every_run) {
  const recipes::Recipe recipe = with_purge("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 0 s}");
  std::uint64_t hash = 0;
  for (int i = 0; i < 2; ++i) {
    Rig rig({});
    const record::JobResult r = rig.run(recipe);
    test::expect_done(r);
    if (i > 0) {
      EXPECT_EQ(r.setpoint_hash, hash);
    }
    hash = r.setpoint_hash;
  }
}

TEST(Purge, goes_to_a_place_of_the_machine_however_the_board_lies) {
  const recipes::Recipe recipe =
      with_purge("{material: glue, frame: pallet, at: [70 mm, 45 mm, 40 mm], shots: 1, after: 0 s}");
  Rig rig({.placement = "dx=2 mm, dy=-1 mm, rot=1 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);
  ASSERT_EQ(purges(r), 1u);
  // Without marks the board is taken to lie at its nominal placement; the world knows better: turned by 1 deg and
  // shifted.
  const Vec3 at = r.deposits.front().board_mm.front();
  const Vec2 in_frame = rotated({at.x, at.y}, M_PI / 180) + Vec2{2, -1};
  EXPECT_NEAR(in_frame.x, 70, 0.02);
  EXPECT_NEAR(in_frame.y, 45, 0.02);
}

TEST(Purge, is_proved_like_any_motion) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const auto proof = [&](const std::string& purge, const std::string& part) {
    recipes::Recipe recipe = with_purge(purge);
    if (!part.empty()) recipe.parts.push_back({.name = part, .at = {60, 40}, .size = {10, 10, 15}, .location = {}});
    const auto job = recipes::compile(recipe, *machine);
    EXPECT_TRUE(job);
    return job::prove_nominal(*machine, recipe, *job);
  };
  EXPECT_TRUE(proof("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 30 s}", ""));
  const auto blocked = proof("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 30 s}", "relay");
  ASSERT_FALSE(blocked);
  EXPECT_EQ(blocked.error().fault, Fault::Collision);
  EXPECT_EQ(blocked.error().where, "purged.yaml:7:29");
  EXPECT_NE(blocked.error().message.find("purging"), std::string::npos);
  EXPECT_NE(blocked.error().message.find("relay"), std::string::npos);
}

/// Of a shot nobody is told how much of it is left: its whole length counts, which no override makes longer.
TEST(Purge, a_hold_waits_for_the_end_of_a_shot_only_where_that_is_within_hold_within) {
  for (const auto& [dot_time, override, waits] :
       {std::tuple{"3 s", 1.0, false}, {"1500 ms", 1.0, true}, {"1500 ms", 0.5, true}}) {
    SCOPED_TRACE(fmt::format("{} at {:.0f} %", dot_time, override * 100));
    const recipes::Recipe recipe =
        with_purge("{material: glue, at: [60 mm, 40 mm, 0 mm], shots: 2, after: 0 s}", dot_time);
    Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
    CycleIndex open = 0, held_at = 0, shut_at = 0, stood = 0;
    std::string said;
    bool slowed = false, resumed = false;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      const bool valve = (s.outputs & config::bit(config::Output::Valve)) != 0;
      if (!slowed && s.block != 0)
        slowed = owner.order({.kind = run::OrderKind::Override, .value = override}).has_value();
      open = valve ? open + 1 : 0;
      if (held_at == 0 && open == 100) {
        EXPECT_TRUE(owner.order({.kind = run::OrderKind::Hold}));
        said = owner.order_said();
        held_at = s.cycle;
      }
      if (held_at != 0 && shut_at == 0 && !valve) shut_at = s.cycle;
      stood = owner.held() && s.path_speed == 0 && shut_at != 0 ? stood + 1 : 0;
      if (!resumed && stood == 300) resumed = owner.order({.kind = run::OrderKind::Resume}).has_value();
    };
    const record::JobResult result = rig.run(recipe);
    ASSERT_NE(shut_at, 0);
    EXPECT_TRUE(resumed);
    EXPECT_NE(said.find("in the purge"), std::string::npos) << said;
    EXPECT_EQ(said.starts_with("holds now"), !waits) << said;
    if (waits) {
      EXPECT_NEAR(static_cast<double>(shut_at - held_at), 1400, 20);
      EXPECT_EQ(purges(result), 2u) << "nothing was cut";
    } else {
      EXPECT_LE(shut_at - held_at, 5);
      EXPECT_EQ(purges(result), 3u) << "what was cut is purged once more";
    }
    EXPECT_EQ(result.features_done, 1u);
    EXPECT_TRUE(result.errors.empty());
  }
}

}  // namespace
}  // namespace gantry
