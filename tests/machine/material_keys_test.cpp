// What a material's keys make of a bead's end, and dispensing on a part: by the world's log, and by where the axes were
// told to go.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "app/job/prove.hpp"
#include "app/record/defects.hpp"
#include "app/record/summary.hpp"
#include "tests/machine/deposits.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Rig;

recipes::Recipe recipe_of(const std::string& material_keys, const std::string& parts, const std::string& features) {
  const auto recipe = recipes::parse(
      fmt::format("version: 1\nrecipe: keys\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, "
                  "frame: pallet}}\n"
                  "parts: {{{}}}\nmaterials:\n"
                  "  glue: {{speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
                  "dot_time: 30 ms, settle_time: 10 ms, retract: 3 mm, tolerance: 5 mm, gap_tolerance: 2 mm{}}}\n"
                  "features:\n{}",
                  parts, material_keys, features),
      "keys.yaml");
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}
constexpr const char* kLine = "  - line: {name: l, material: glue, from: [20 mm, 20 mm], to: [50 mm, 20 mm]}\n";

/// The needle's tip over the board as it nominally lies, and the valve, cycle by cycle.
struct TipTrajectory {
  std::vector<Vec3> tip;
  std::vector<bool> valve;

  record::JobResult run(Rig& rig, const recipes::Recipe& recipe) {
    rig.on_step = [&](run::Owner& owner) {
      const cycle::Snapshot& s = owner.latest();
      const config::Machine& m = rig.machine();
      const config::Tool& needle = *config::find_tool(m, "needle");
      const Vec3 origin = config::find_frame(m, "pallet")->origin;
      tip.push_back({s.target[m.x.value] + needle.tip.x - origin.x, s.target[m.y.value] + needle.tip.y - origin.y,
                     s.target[m.z.value] + needle.tip.z - s.target[m.u->value] - origin.z - recipe.board.thickness});
      valve.push_back((s.outputs & config::bit(config::Output::Valve)) != 0);
    };
    return rig.run(recipe);
  }
  /// Index after the valve was shut last.
  [[nodiscard]] std::size_t shut() const {
    return valve.size() - static_cast<std::size_t>(std::find(valve.rbegin(), valve.rend(), true) - valve.rbegin());
  }
  /// How near the tip comes to a point from cycle `from` on, and when.
  [[nodiscard]] std::pair<double, std::size_t> nearest(Vec3 p, std::size_t from) const {
    std::pair<double, std::size_t> best{1e9, from};
    for (std::size_t i = from; i < tip.size(); ++i)
      if (const double d = norm(tip[i] - p); d < best.first) best = {d, i};
    return best;
  }
};

const record::Deposit& deposit(const record::JobResult& r, const std::string& id) {
  static const record::Deposit kNone{};
  for (const record::Deposit& d : r.deposits)
    if (d.id == id && !d.board_mm.empty()) return d;
  ADD_FAILURE() << "not dispensed: " << id;
  return kNone;
}

TEST(MaterialKeys, early_off_ends_the_bead_so_much_before_its_end) {
  const recipes::Recipe recipe = recipe_of(", early_off: 4 mm", "", kLine);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);
  const auto& path = deposit(r, "l").board_mm;
  ASSERT_FALSE(path.empty());
  EXPECT_NEAR(path.front().x, 20, 0.03);
  EXPECT_NEAR(path.back().x, 46, 0.03);
  EXPECT_LE(deposit(r, "l").error_mm, 0.03) << "the world expects it there";
}

TEST(MaterialKeys, early_off_counts_along_the_chords_of_a_curve) {
  const recipes::Recipe recipe = recipe_of(
      ", early_off: 5 mm", "", "  - circle: {name: c, material: glue, centre: [40 mm, 25 mm], radius: 10 mm}\n");
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);
  const auto& path = deposit(r, "c").board_mm;
  ASSERT_FALSE(path.empty());
  const double angle = std::atan2(path.back().y - 25, path.back().x - 40);
  EXPECT_NEAR(angle * 10, -5, 0.06);
}

TEST(MaterialKeys, back_track_goes_back_over_the_bead_and_rises_meanwhile) {
  const recipes::Recipe recipe = recipe_of(", back_track: 6 mm, tail_lift: 1.5 mm", "", kLine);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  TipTrajectory trajectory;
  test::expect_done(trajectory.run(rig, recipe));
  const std::size_t shut = trajectory.shut();
  const auto end = trajectory.nearest({50, 20, 0.5}, shut), back = trajectory.nearest({44, 20, 2}, shut);
  EXPECT_LT(end.first, 0.02);
  EXPECT_LT(back.first, 0.001) << "it rests there";
  EXPECT_GT(back.second, end.second);
  for (std::size_t i = shut; i <= back.second; ++i) {
    EXPECT_NEAR(trajectory.tip[i].y, 20, 0.001);
    EXPECT_GE(trajectory.tip[i].z, 0.499);
  }
  const auto up = trajectory.nearest({44, 20, 5}, back.second);
  EXPECT_LT(up.first, 0.3) << "and from there straight up by retract";
  for (std::size_t i = back.second; i <= up.second; ++i) EXPECT_NEAR(trajectory.tip[i].x, 44, 0.3);
}

TEST(MaterialKeys, tail_lift_alone_goes_straight_up_at_the_speed_of_the_bead) {
  const recipes::Recipe recipe = recipe_of(", tail_lift: 2 mm", "", kLine);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  TipTrajectory trajectory;
  test::expect_done(trajectory.run(rig, recipe));
  for (std::size_t i = trajectory.shut(); i + 1 < trajectory.tip.size() && trajectory.tip[i].z < 2.4; ++i)
    EXPECT_LE((trajectory.tip[i + 1].z - trajectory.tip[i].z) * 1000, 20.01) << trajectory.tip[i].z;
}

TEST(MaterialKeys, that_cannot_be_meant_are_told_where_they_stand) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const auto job = recipes::compile(recipe_of(", early_off: 31 mm", "", kLine), *machine);
  ASSERT_FALSE(job);
  EXPECT_EQ(job.error()[0].fault, Fault::Inconsistent);
  EXPECT_EQ(job.error()[0].where, "keys.yaml:7:187");
  EXPECT_NE(job.error()[0].message.find("only 30 mm"), std::string::npos) << job.error()[0].message;
}

// At 20 mm/s a cycle is 0.02 mm. Where less is left the valve, which is switched once in a cycle, may not open at all.
TEST(MaterialKeys, early_off_that_leaves_less_than_a_cycle_of_a_bead_is_told) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  for (const double left_mm : {0.001, 0.009, 0.019}) {
    const auto job = recipes::compile(recipe_of(fmt::format(", early_off: {} mm", 30 - left_mm), "", kLine), *machine);
    ASSERT_FALSE(job) << left_mm;
    EXPECT_EQ(job.error()[0].fault, Fault::Inconsistent);
    EXPECT_NE(job.error()[0].message.find("less than a cycle"), std::string::npos) << job.error()[0].message;
  }
  // Over the first point it is open as long as the needle stands there.
  EXPECT_TRUE(recipes::compile(recipe_of(", start_dwell: 50 ms, early_off: 29.999 mm", "", kLine), *machine));
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe_of(", early_off: 29.98 mm", "", kLine));
  test::expect_done(r);
  EXPECT_EQ(deposit(r, "l").board_mm.size(), 2u) << "a cycle's worth";
}

// It takes a cycle, however short it is: a valve that closes so much earlier than it opens never does.
TEST(MaterialKeys, leads_that_leave_nothing_of_a_bead_within_one_cycle_are_told) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  auto recipe = recipe_of("", "", "  - line: {name: l, material: glue, from: [20 mm, 20 mm], to: [20.01 mm, 20 mm]}\n");
  EXPECT_TRUE(recipes::compile(recipe, *machine));
  recipe.materials[0].valve_close_lead = recipe.materials[0].valve_open_lead + 1e-3;
  const auto job = recipes::compile(recipe, *machine);
  ASSERT_FALSE(job);
  EXPECT_NE(job.error()[0].message.find("'valve_close_lead' of 9 ms"), std::string::npos) << job.error()[0].message;
}

TEST(MaterialKeys, start_dwell_opens_the_valve_stands_and_then_lays_the_bead) {
  const recipes::Recipe recipe = recipe_of(", start_dwell: 150 ms", "", kLine);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  TipTrajectory trajectory;
  const record::JobResult r = trajectory.run(rig, recipe);
  test::expect_done(r);
  const record::Deposit& d = deposit(r, "l");
  EXPECT_NEAR(d.board_mm.front().x, 20, 0.03);
  EXPECT_NEAR(d.board_mm.back().x, 50, 0.03);
  EXPECT_LE(d.error_mm, 0.03) << "nothing is laid before its start";
  // 30 mm at 20 mm/s take 1.5 s, speeding up makes it longer by sqrt(v/j) = 16 ms, and it stands for 150 ms.
  EXPECT_NEAR(static_cast<double>(d.closed_cycle - d.opened_cycle), 1500 + 16 + 150, 4);
  ASSERT_TRUE(d.speed);
  EXPECT_NEAR(d.speed->volume_per_length, 1.666 / 1.5, 0.005);
  // The needle stands over the first point while the valve is open.
  std::size_t stands = 0;
  for (std::size_t i = 0; i < trajectory.tip.size(); ++i)
    stands += trajectory.valve[i] && norm(trajectory.tip[i] - Vec3{20, 20, 0.5}) < 1e-3 ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(stands), 150 + 8, 14) << "and a little before, by the lead, and while it sets out";
}

// The world's valve takes 8 ms to open. One that is told 100 ms too early stands open over the start for so much
// longer.
TEST(MaterialKeys, start_dwell_with_a_lead_that_the_valve_does_not_take_is_a_defect) {
  for (const double early_s : {0.0, 0.1}) {
    recipes::Recipe recipe = recipe_of(", start_dwell: 150 ms", "", kLine);
    recipe.materials.front().valve_open_lead += early_s;
    Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
    const record::JobResult r = rig.run(recipe);
    const bool good = early_s == 0;
    EXPECT_EQ(record::result_word(r), good ? "done" : "done_with_defects");
    const record::Deposit& d = deposit(r, "l");
    ASSERT_TRUE(d.speed);
    EXPECT_NEAR(d.speed->stood_s, 0.15 + early_s, 0.02);
    const auto amount = [](const record::Defect& x) { return x.kind == record::Defect::Kind::Amount; };
    EXPECT_EQ(std::count_if(r.defects.begin(), r.defects.end(), amount), good ? 0 : 1);
  }
}

// d = j t^3 / 6: from rest 5 um take 53 ms at 200 mm/s^3, though it stands no longer than it was told to.
TEST(MaterialKeys, start_dwell_on_axes_that_set_out_slowly_is_whole) {
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg", .change = [](config::Machine& m) {
             for (config::Axis& a : m.axes)
               if (a.id == m.x || a.id == m.y) a.j_max = 200, a.a_max = 400;
           }});
  recipes::Recipe recipe = recipe_of(", start_dwell: 150 ms", "", kLine);
  recipe.materials.front().speed = 3;
  const record::JobResult r = rig.run(recipe);
  EXPECT_GT(deposit(r, "l").speed->stood_s, 0.15 + 0.04);
  test::expect_done(r);
}

TEST(MaterialKeys, start_dwell_counts_in_what_is_predicted) {
  const auto on_it_s = [](const std::string& keys) {
    const recipes::Recipe recipe = recipe_of(keys, "", kLine);
    Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
    const record::JobResult r = rig.run(recipe);
    test::expect_done(r);
    EXPECT_EQ(r.feature_times.size(), 1u);
    const auto& [predicted, actual, disturbed] = r.feature_times.at(0);
    EXPECT_NEAR(predicted.on_it_s, actual.on_it_s, 0.0011) << "to one tick";
    EXPECT_NEAR(predicted.travel_s, actual.travel_s, 0.0011);
    return predicted.on_it_s;
  };
  const double with_s = on_it_s(", start_dwell: 250 ms"), without_s = on_it_s("");
  // The run-up, 33 ms, is saved; speeding up on the bead costs half of that.
  EXPECT_NEAR(with_s - without_s, 0.25 - 0.016, 0.003);
}

TEST(MaterialKeys, a_bead_that_is_cut_while_it_stands_at_its_start_stands_for_the_rest_of_it) {
  for (const int cut_after : {40, 120, 260}) {
    const recipes::Recipe recipe = recipe_of(", start_dwell: 200 ms", "", kLine);
    Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
    int open = 0;
    bool held = false, resumed = false;
    rig.on_step = [&](run::Owner& owner) {
      const cycle::Snapshot& s = owner.latest();
      open += (s.outputs & config::bit(config::Output::Valve)) != 0 ? 1 : 0;
      if (!held && open == cut_after) held = owner.order({.kind = run::OrderKind::Hold, .now = true}).has_value();
      if (held && !resumed && s.state == cycle::State::Held)
        resumed = owner.order({.kind = run::OrderKind::Resume}).has_value();
    };
    const record::JobResult r = rig.run(recipe);
    EXPECT_TRUE(resumed);
    EXPECT_TRUE(r.stays_cut.empty()) << r.stays_cut.begin()->second;
    EXPECT_EQ(r.features_done, 1u);
    double missing_mm = 0;
    for (const record::Deposit& d : r.deposits) {
      EXPECT_EQ(d.id, "l");
      for (const double mm : d.joins_mm) missing_mm = std::max(missing_mm, std::abs(mm));
    }
    const double open_cycles = open;
    EXPECT_LE(missing_mm, 20 * 0.5e-3 + 0.02) << cut_after;
    // Whole it is open for 1716 cycles; the second shot is told 2 ms earlier than its end as well, and what was cut on
    // the way is laid at its speed instead of speeding up there.
    EXPECT_NEAR(open_cycles, 1716 + 2 * 2, cut_after < 200 ? 6 : 25) << cut_after;
  }
}

constexpr const char* kPost = "stud: {at: [16.6 mm, 20 mm], size: [1 mm, 1 mm, 2.4 mm]}";

Result<job::NominalProof> proof_of(const recipes::Recipe& recipe) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  EXPECT_TRUE(machine);
  const auto job = recipes::compile(recipe, *machine);
  EXPECT_TRUE(job) << to_text(job.error()[0]);
  return job::prove_nominal(*machine, recipe, *job);
}

TEST(RunUp, that_is_blocked_is_named_with_the_body_and_the_line) {
  // At the bead's start the needle is 0.8 mm thick to each side and keeps 2 mm: a stud up to x = 17.2 mm may stand
  // there. The run-up comes nearer, and the material wants a bead to begin at its speed.
  const auto run_up = proof_of(recipe_of(", min_speed: 20 mm/s", kPost, kLine));
  ASSERT_FALSE(run_up);
  for (const char* word : {"bead 'l'", "run-up", "stud", "needle", "min_speed"})
    EXPECT_NE(run_up.error().message.find(word), std::string::npos) << run_up.error().message;
  EXPECT_EQ(run_up.error().where, "keys.yaml:9:5");
  const auto free = proof_of(recipe_of("", "stud: {at: [14 mm, 20 mm], size: [1 mm, 1 mm, 2.4 mm]}", kLine));
  ASSERT_TRUE(free) << to_text(free.error());
  EXPECT_TRUE(free->run_ups.empty());
  const auto along = proof_of(recipe_of("", "stud: {at: [35 mm, 21 mm], size: [1 mm, 1 mm, 2.4 mm]}", kLine));
  ASSERT_FALSE(along);
  EXPECT_EQ(along.error().message.find("run-"), std::string::npos) << along.error().message;
  for (const char* word : {"bead 'l'", "stud", "needle"})
    EXPECT_NE(along.error().message.find(word), std::string::npos) << along.error().message;
  EXPECT_EQ(along.error().where, "keys.yaml:9:5");
}

TEST(RunUp, that_is_blocked_is_a_shorter_one_and_nothing_is_hit) {
  // Free up to 0.1 mm before the start: v sqrt(v/j) with 0.98 of 80,000 mm/s3 is that at 9.2 mm/s.
  const recipes::Recipe recipe = recipe_of("", kPost, kLine);
  const auto proof = proof_of(recipe);
  ASSERT_TRUE(proof) << to_text(proof.error());
  ASSERT_EQ(proof->run_ups.size(), 1u);
  EXPECT_EQ(proof->run_ups[0].kind, job::RunUp::Kind::Shorter);
  EXPECT_LE(proof->run_ups[0].entry_mm_s, 9.25);
  EXPECT_GE(proof->run_ups[0].entry_mm_s, 9.2 - 20.0 / 16);
  EXPECT_NE(proof->run_ups[0].blocked.find("stud"), std::string::npos) << proof->run_ups[0].blocked;
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);  // no collision by the world's own watch, the bead whole
  EXPECT_LE(deposit(r, "l").error_mm, 0.03);
}

/// What is left after a hold is planned anew each time.
TEST(RunUp, that_is_blocked_is_told_once_however_often_the_job_is_held_before_it) {
  const std::string before = "  - line: {name: before, material: glue, from: [20 mm, 40 mm], to: [50 mm, 40 mm]}\n";
  const recipes::Recipe recipe = recipe_of("", kPost, before + kLine);
  const test::Said said;
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  int open = 0, holds = 0;
  rig.on_step = [&](run::Owner& owner) {
    const cycle::Snapshot& s = owner.latest();
    open = (s.outputs & config::bit(config::Output::Valve)) != 0 ? open + 1 : 0;
    if (s.feature == 0 && open == 100 && holds < 3)
      holds += owner.order({.kind = run::OrderKind::Hold, .now = true}).has_value() ? 1 : 0;
    if (s.state == cycle::State::Held) (void)owner.order({.kind = run::OrderKind::Resume});
  };
  test::expect_done(rig.run(recipe));
  EXPECT_EQ(holds, 3);
  EXPECT_EQ(said.count({"bead 'l' begins at", "stud"}), 1) << said.all();
}

TEST(RunUp, a_bead_begins_from_rest_where_the_body_is_as_near_as_it_may_be) {
  const recipes::Recipe recipe = recipe_of("", "stud: {at: [16.698 mm, 20 mm], size: [1 mm, 1 mm, 2.4 mm]}", kLine);
  const auto proof = proof_of(recipe);
  ASSERT_TRUE(proof) << to_text(proof.error());
  ASSERT_EQ(proof->run_ups.size(), 1u);
  EXPECT_EQ(proof->run_ups[0].kind, job::RunUp::Kind::FromRest);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);
  EXPECT_LE(deposit(r, "l").error_mm, 0.03);
  const auto slower =
      proof_of(recipe_of(", min_speed: 1 mm/s", "stud: {at: [16.698 mm, 20 mm], size: [1 mm, 1 mm, 2.4 mm]}", kLine));
  EXPECT_FALSE(slower) << "its material forbids that";
}

TEST(RunUp, comes_from_above_past_a_low_body_at_the_speed_of_the_bead) {
  // At 150 mm/s the run-up is 6.8 mm long and begins 1.5 mm beside the body, which is 0.6 mm high.
  recipes::Recipe recipe =
      recipe_of(", min_speed: 150 mm/s", "low: {at: [11.2 mm, 20 mm], size: [1 mm, 1 mm, 0.6 mm]}", kLine);
  recipe.materials[0].speed = 150;
  const auto proof = proof_of(recipe);
  ASSERT_TRUE(proof) << to_text(proof.error());
  ASSERT_EQ(proof->run_ups.size(), 1u);
  EXPECT_EQ(proof->run_ups[0].kind, job::RunUp::Kind::FromAbove);
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult r = rig.run(recipe);
  test::expect_done(r);
  EXPECT_LE(deposit(r, "l").error_mm, 0.1);
  ASSERT_TRUE(deposit(r, "l").speed);
  EXPECT_GT(deposit(r, "l").speed->within_5_percent, 0.98);
}

constexpr const char* kParts = "relay: {at: [40 mm, 30 mm], size: [20 mm, 12 mm, 9 mm]}";

TEST(OnAPart, features_lie_on_its_top_and_nothing_is_hit) {
  const recipes::Recipe recipe =
      recipe_of("", kParts,
                "  - dot: {name: d, material: glue, on: relay, at: [33 mm, 27 mm]}\n"
                "  - line: {name: l, material: glue, on: relay, from: [32 mm, 30 mm], to: [48 mm, 30 mm]}\n"
                "  - dot: {name: beside, material: glue, at: [10 mm, 10 mm]}\n");
  Rig rig({.placement = "dx=0.5 mm, dy=0.5 mm, rot=0 deg"});
  TipTrajectory trajectory;
  const record::JobResult r = trajectory.run(rig, recipe);
  test::expect_done(r);
  EXPECT_TRUE(r.collisions.empty());
  EXPECT_EQ(r.features_done, 3u);
  const auto none = rig.machine().sim.height_spread_mm;  // the world's board may be so much higher or lower
  EXPECT_NEAR(deposit(r, "d").board_mm[0].z, 9.5, none + 0.03);
  for (const Vec3 p : deposit(r, "l").board_mm) EXPECT_NEAR(p.z, 9.5, none + 0.03);
  const auto& nearest = r.minimum_clearance.by_design;
  ASSERT_TRUE(nearest);
  EXPECT_EQ(nearest->head, "needle");
}

TEST(OnAPart, other_pairs_keep_their_clearance_and_the_error_names_both) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const auto proof = [&](const std::string& on) {
    const recipes::Recipe recipe =
        recipe_of("", std::string(kParts) + ", tower: {at: [40 mm, 39 mm], size: [4 mm, 4 mm, 20 mm]}",
                  "  - dot: {name: d, material: glue, on: relay, at: " + on + "}\n");
    const auto job = recipes::compile(recipe, *machine);
    EXPECT_TRUE(job);
    return job::prove_nominal(*machine, recipe, *job);
  };
  EXPECT_TRUE(proof("[33 mm, 27 mm]")) << to_text(proof("[33 mm, 27 mm]").error());
  const auto near = proof("[40 mm, 35.5 mm]");
  ASSERT_FALSE(near) << "the tower is beside it";
  EXPECT_NE(near.error().message.find("tower"), std::string::npos) << near.error().message;
}

}  // namespace
}  // namespace gantry
