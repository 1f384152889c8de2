#include "app/record/defects.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "app/record/deposit_figures.hpp"
#include "app/record/outcome.hpp"
#include "app/record/report.hpp"
#include "app/record/summary.hpp"

namespace gantry::record {
namespace {

using job::FeatureState;
using Kind = Defect::Kind;

constexpr double kCycle_s = 0.001;

recipes::Recipe recipe(const char* placement = "fixture") {
  const std::string text =
      std::string("version: 1\nrecipe: r\nplacement: ") + placement +
      "\nboard: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\nmaterials:\n"
      "  a: {speed: 20 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
      "dot_time: 60 ms, retract: 3 mm, tolerance: 0.05 mm, gap_tolerance: 0.02 mm}\nfeatures:\n"
      "  - dot: {name: d, material: a, at: [10 mm, 10 mm]}\n"
      "  - polyline: {name: b, material: a, points: [[20 mm, 10 mm], [40 mm, 10 mm], [40 mm, 30 mm]],"
      " corner_tolerance: 0.1 mm}\n";
  return recipes::parse(text, "r.yaml").value();
}

Deposit dot() {
  Deposit d{"d", "dot", {{10, 10, 0.2}}, {{10.01, 10, 0.2}}, 0.01, 0.2, 0.2, 1000, 1060};
  d.open_s = 0.060;
  return d;
}
Deposit shut_after(Deposit d, std::uint64_t ms) {
  d.closed_cycle = d.opened_cycle + ms, d.open_s = static_cast<double>(ms) * 1e-3;
  return d;
}
Deposit bead() {
  return {"b",
          "bead",
          {{20, 10, 0.2}, {40, 10, 0.2}, {40, 30, 0.2}},
          {{20, 10, 0.2}, {39.9, 10.1, 0.2}, {40, 30, 0.2}},
          0.12,
          0.2,
          0.2,
          2000,
          4000};
}

const std::vector<FeatureState> kDone{FeatureState::Done, FeatureState::Done};

JobResult judged(const std::vector<Deposit>& deposits, const std::vector<FeatureState>& features = kDone,
                 std::vector<job::OffSpeed> off_speed = {}, const char* placement = "fixture") {
  JobResult r;
  r.deposits = deposits, r.has_world = true;
  add_judgement(r, judge_board(r, recipe(placement), {features, std::move(off_speed)}, kCycle_s));
  return r;
}

void expect_one(const JobResult& r, const char* feature, Kind kind, Board board) {
  ASSERT_EQ(r.defects.size(), 1u);
  EXPECT_EQ(r.defects[0].feature, feature);
  EXPECT_EQ(r.defects[0].kind, kind) << r.defects[0].message;
  EXPECT_EQ(r.board, board);
  EXPECT_EQ(r.exit_code, ExitCode::DoneWithDefects);
  EXPECT_EQ(result_word(r), "done_with_defects");
}

void expect_lacks(const JobResult& r, const char* feature) {
  ASSERT_EQ(r.defects.size(), 1u);
  EXPECT_EQ(r.defects[0].feature, feature);
  EXPECT_TRUE(is_lacking(r.defects[0]));
  EXPECT_EQ(r.board, Board::Begun);
}

TEST(Defects, a_board_within_tolerance_is_whole_and_done) {
  const JobResult r = judged({dot(), bead()});
  EXPECT_TRUE(r.defects.empty());
  EXPECT_EQ(r.board, Board::Whole);
  EXPECT_EQ(r.exit_code, ExitCode::Done);
}

TEST(Defects, each_kind_is_told_of_its_feature) {
  expect_one(judged({dot()}), "b", Kind::Missing, Board::Begun);
  auto off = dot();
  off.error_mm = 0.06;
  expect_one(judged({off, bead()}), "d", Kind::Beside, Board::Defects);
  auto high = bead();
  high.gap_mm = 0.23;
  expect_one(judged({dot(), high}), "b", Kind::Gap, Board::Defects);
  auto corner = bead();
  corner.error_mm = 0.16;
  expect_one(judged({dot(), corner}), "b", Kind::Beside, Board::Defects);
  auto end = bead();  // a corner's tolerance is no end's
  end.board_mm.back().y = 29.9;
  expect_one(judged({dot(), end}), "b", Kind::Beside, Board::Defects);
  auto stray = dot();
  stray.id = "", stray.error_mm = std::numeric_limits<double>::quiet_NaN();
  expect_one(judged({dot(), stray, bead()}), "", Kind::Extra, Board::Defects);
  expect_one(judged({dot(), bead()}, kDone, {{1, 20, 10, 5}}), "b", Kind::Speed, Board::Defects);
  const auto stood = judged({dot(), bead()}, kDone, {{.feature = 1, .stands = 2, .stands_at_mm = 7}});
  expect_one(stood, "b", Kind::Speed, Board::Defects);
  EXPECT_NE(stood.defects[0].message.find("stands still 2 times"), std::string::npos) << stood.defects[0].message;
  expect_one(judged({dot(), bead()}, kDone, {}, "marks"), "", Kind::Reference, Board::Defects);
}

// Of a wide corner or a curve: the bead ends somewhere on it, and is no nearer to its path there than anywhere else.
TEST(Defects, an_end_in_mid_bead_by_early_off_may_be_off_as_far_as_the_path_may) {
  for (const bool early : {false, true}) {
    auto brief = recipe();
    if (early) brief.materials[0].early_off = 0.7;
    const auto ends_beside = [&](double mm) {
      JobResult r;
      Deposit b = bead();
      b.board_mm.back().x += mm, b.error_mm = mm;
      r.deposits = {dot(), b}, r.has_world = true;
      add_judgement(r, judge_board(r, brief, {kDone, {}}, kCycle_s));
      return r.defects.size();
    };
    EXPECT_EQ(ends_beside(0.04), 0u);
    EXPECT_EQ(ends_beside(0.14), early ? 0u : 1u);
    EXPECT_EQ(ends_beside(0.16), 1u);
  }
}

// An override below 100 % makes the way to the join longer after the resume has come in time.
// A stop takes the valve's command back before it has opened: what the loop counts as laid is not there.
TEST(Defects, a_bead_that_begins_where_it_was_joined_lacks_what_is_before) {
  const auto judged_as = [&](std::vector<double> joins_mm) {
    Deposit short_of_it = bead();
    short_of_it.board_mm.front().x += 0.55, short_of_it.error_mm = 0.55, short_of_it.joins_mm = std::move(joins_mm);
    JobResult r;
    r.deposits = {dot(), short_of_it}, r.has_world = true;
    r.joined = {{"b", 0.25, 2.9}};
    add_judgement(r, judge_board(r, recipe(), {kDone, {}}, kCycle_s));
    return r;
  };
  expect_one(judged_as({}), "b", Kind::Cut, Board::Begun);
  expect_one(judged_as({0.0}), "b", Kind::Beside, Board::Defects);
}

TEST(Defects, a_bead_that_was_joined_later_than_its_material_bears_is_one) {
  auto brief = recipe();
  brief.materials[0].rejoin_within_s = 6;
  const auto joined = [&](double after_s) {
    JobResult r;
    r.deposits = {dot(), bead()}, r.has_world = true;
    r.joined = {{"b", 12, after_s}};
    add_judgement(r, judge_board(r, brief, {kDone, {}}, kCycle_s));
    return r;
  };
  EXPECT_TRUE(joined(5.9).defects.empty());
  const JobResult late = joined(8.156);
  expect_one(late, "b", Kind::Late, Board::Defects);
  EXPECT_EQ(name(Kind::Late), "late");
  EXPECT_NE(late.defects[0].message.find("8.16 s after its valve had shut"), std::string::npos)
      << late.defects[0].message;
  EXPECT_NE(late.defects[0].message.find("within 6 s ('rejoin_within')"), std::string::npos);
}

// 5 % of 60 ms are 3 ms; dot_time and leads are whole cycles.
TEST(Defects, a_dot_of_another_amount_is_told_with_its_figures_although_the_controller_calls_it_done) {
  for (const std::uint64_t ms : {57, 60, 63})
    EXPECT_TRUE(judged({shut_after(dot(), ms), bead()}).defects.empty()) << ms;
  for (const std::uint64_t ms : {3, 56, 64, 120})
    expect_one(judged({shut_after(dot(), ms), bead()}), "d", Kind::Amount, Board::Defects);
  const std::string less = judged({shut_after(dot(), 20), bead()}).defects.front().message,
                    more = judged({shut_after(dot(), 90), bead()}).defects.front().message;
  EXPECT_NE(less.find("20 ms instead of 60 ms, 67 % less; 5 % are allowed"), std::string::npos) << less;
  EXPECT_NE(less.find("`valve_open_lead`"), std::string::npos) << less;
  EXPECT_NE(more.find("90 ms instead of 60 ms, 50 % more"), std::string::npos) << more;
  auto open = dot();
  open.closed_cycle = 0, open.open_s = 0;
  expect_one(judged({open, bead()}), "d", Kind::Amount, Board::Defects);
}

TEST(Defects, a_dot_whose_times_are_no_whole_cycles_may_be_a_cycle_off) {
  auto odd = recipe();
  odd.materials[0].dot_time = 0.0045;
  const auto defects = [&](double open_s) {
    auto d = dot();
    d.open_s = open_s;
    JobResult r;
    r.deposits = {d, bead()}, r.has_world = true;
    return judge_board(r, odd, {kDone, {}}, kCycle_s).defects.size();
  };
  EXPECT_EQ(defects(0.004), 0u);
  EXPECT_EQ(defects(0.005), 0u);
  EXPECT_EQ(defects(0.003), 1u);
  EXPECT_EQ(defects(0.006), 1u);
}

TEST(Defects, the_speed_that_the_world_has_seen_counts_whatever_was_planned) {
  const auto with = [&](double within, std::optional<double> held, FeatureState state = FeatureState::Done) {
    auto b = bead();
    b.speed = sim::DepositSpeed{.asked_mm_s = 20, .within_tolerance = within, .held_mm_s = held};
    return judged({dot(), b}, {FeatureState::Done, state});
  };
  EXPECT_TRUE(with(0.9, 20.9).defects.empty()) << "5 %";
  EXPECT_TRUE(with(0.6, std::nullopt).defects.empty()) << "corners";
  expect_one(with(0.9, 17), "b", Kind::Speed, Board::Defects);
  expect_one(with(0.4, std::nullopt), "b", Kind::Speed, Board::Defects);
  EXPECT_NE(with(0.9, 17).defects[0].message.find("17 mm/s instead of 20 mm/s"), std::string::npos);
  EXPECT_NE(with(0.4, std::nullopt).defects[0].message.find("40 % of its length"), std::string::npos);
  auto sagged = bead();
  sagged.speed =
      sim::DepositSpeed{.asked_mm_s = 20, .within_tolerance = 0.9, .sag = Sag{.low_mm_s = 12, .lasts_s = 0.3}};
  expect_one(judged({dot(), sagged}), "b", Kind::Speed, Board::Defects);
  const std::string words = judged({dot(), sagged}).defects.at(0).message;
  EXPECT_NE(words.find("slowed down to 12 mm/s instead of 20 mm/s, and was too slow for 300 ms"), std::string::npos);
  auto slow = bead();
  slow.speed = sim::DepositSpeed{.asked_mm_s = 20, .within_tolerance = 0, .held_mm_s = 10};
  expect_one(judged({dot(), slow}, kDone, {{1, 20, 10, 40, 80}}), "b", Kind::Speed, Board::Defects);  // once
  auto follows = recipe();
  follows.materials[0].flow_follows_speed = true;
  JobResult r;
  r.deposits = {dot(), slow}, r.has_world = true;
  EXPECT_TRUE(judge_board(r, follows, {kDone, {}}, kCycle_s).defects.empty());
}

TEST(Defects, ends_and_path_are_told_by_what_they_are_judged_by) {
  auto end = bead();  // a corner's tolerance is no end's
  end.board_mm.back().y = 29.9, end.error_mm = 0.12;
  const std::string ends = judged({dot(), end}).defects.at(0).message;
  EXPECT_NE(ends.find("its end 0.100 mm"), std::string::npos) << ends;
  EXPECT_NE(ends.find("0.05 mm are allowed"), std::string::npos) << ends;
  auto corner = bead();
  corner.error_mm = 0.16;
  const std::string path = judged({dot(), corner}).defects.at(0).message;
  EXPECT_NE(path.find("0.160 mm beside its place; 0.15 mm are allowed"), std::string::npos) << path;
}

TEST(Defects, what_a_stop_has_cut_counts_where_it_shows) {
  const std::vector<FeatureState> cut{FeatureState::Interrupted, FeatureState::Done};
  EXPECT_TRUE(judged({dot(), bead()}, cut).defects.empty()) << "the world says that it is all there";
  const auto small = shut_after(dot(), 20);
  expect_one(judged({small, bead()}, cut), "d", Kind::Cut, Board::Begun);
  auto half = bead();
  half.board_mm = {{20, 10, 0.2}, {30, 10, 0.2}}, half.error_mm = 22;
  expect_one(judged({dot(), half}, {FeatureState::Done, FeatureState::Interrupted}), "b", Kind::Cut, Board::Begun);
}

// The ends of a closed bead are one place, near which most of it may be missing.
TEST(Defects, what_is_cut_tells_how_much_of_it_lies) {
  auto little = bead();
  little.nominal_mm = {{20, 10, 0.2}, {30, 10, 0.2}, {30, 20, 0.2}, {20, 20, 0.2}, {20, 10, 0.2}};
  little.board_mm = {{20, 10, 0.2}, {23, 10, 0.2}}, little.error_mm = 14;
  const JobResult r = judged({dot(), little}, {FeatureState::Done, FeatureState::Interrupted});
  ASSERT_EQ(r.defects.size(), 1u);
  EXPECT_EQ(r.defects[0].message,
            "cut by a stop: 3.00 of its 40.00 mm lie; it starts 0.00 mm from its start and ends 3.00 mm from its end, "
            "straight across");
}

TEST(Defects, a_drop_under_a_feature_that_was_given_again_is_one_too_many_and_nothing_is_missing) {
  auto drop = shut_after(dot(), 3), again = dot();
  again.id = "", again.opened_cycle = 1500, again.closed_cycle = 1560;
  expect_one(judged({drop, again, bead()}, {FeatureState::Interrupted, FeatureState::Done}), "", Kind::Extra,
             Board::Defects);
  auto spot = bead();
  spot.board_mm = {{20, 10, 0.2}, {20.1, 10, 0.2}}, spot.error_mm = 28;
  auto whole = bead();
  whole.id = "";
  expect_one(judged({dot(), spot, whole}, {FeatureState::Done, FeatureState::Interrupted}), "", Kind::Extra,
             Board::Defects);
}

/// In the order of the recipe; what no feature of the recipe is near to has no id.
JobResult judged_in_order(const std::vector<Deposit>& deposits, const std::vector<FeatureState>& features = kDone) {
  JobResult r;
  r.deposits = deposits, r.has_world = true;
  for (std::size_t i = 0; i < features.size(); ++i)
    if (features[i] != FeatureState::LeftOut) r.feature_order.push_back(i);
  add_judgement(r, judge_board(r, recipe(), {features, {}}, kCycle_s));
  return r;
}
Deposit on_nothing(Deposit d, Vec2 by) {
  d.id.clear(), d.nominal_mm.clear();
  d.error_mm = std::numeric_limits<double>::quiet_NaN();
  for (Vec3& p : d.board_mm) p = p + Vec3{by.x, by.y, 0};
  return d;
}
std::string kinds(const JobResult& r) {
  std::string out(name(r.board));
  for (const Defect& d : r.defects) out += " " + d.feature + ":" + std::string(name(d.kind));
  return out;
}

// The board lay 5 mm off, and nobody has looked: all of it lies there, and dispensing it again would lay a second one
// beside it.
TEST(Defects, what_was_dispensed_for_a_feature_far_beside_its_place_is_not_missing) {
  const Vec2 off{3, -4};
  EXPECT_EQ(kinds(judged_in_order({on_nothing(dot(), off), on_nothing(bead(), off)})), "defects d:beside b:beside");
  const JobResult r = judged_in_order({on_nothing(dot(), off), bead()});
  EXPECT_EQ(kinds(r), "defects d:beside");
  EXPECT_NE(r.defects[0].message.find("5.006 mm beside its place"), std::string::npos) << r.defects[0].message;
  EXPECT_EQ(r.exit_code, ExitCode::DoneWithDefects);

  // The dot came to lie where the bead was to begin: the world takes it for that.
  Deposit taken = dot();
  taken.id = "b", taken.kind = "bead", taken.nominal_mm = bead().nominal_mm, taken.error_mm = 27.9;
  taken.board_mm = {{20.3, 10.2, 0.2}, {20.3, 10.2, 0.2}};
  EXPECT_EQ(kinds(judged_in_order({taken, on_nothing(bead(), off)})), "defects d:beside b:beside");
  EXPECT_EQ(kinds(judged_in_order({taken}, {FeatureState::Done, FeatureState::LeftOut})), "begun d:beside");
}

TEST(Defects, what_may_be_another_ones_makes_up_for_nothing) {
  const Deposit stray = on_nothing(dot(), {5, 5});
  EXPECT_EQ(kinds(judged_in_order({stray})), "begun d:missing b:missing :extra") << "which of both?";
  EXPECT_EQ(kinds(judged_in_order({bead(), stray})), "begun d:missing :extra") << "it came behind the bead";
  EXPECT_EQ(kinds(judged_in_order({dot(), stray})), "begun b:missing :extra") << "a dot is no bead";
  Deposit half = on_nothing(bead(), {5, 5});
  half.board_mm.resize(2);
  EXPECT_EQ(kinds(judged_in_order({dot(), half})), "begun b:missing :extra") << "half of it is no bead";
  EXPECT_EQ(kinds(judged_in_order({stray, bead()}, {FeatureState::Interrupted, FeatureState::Done})),
            "begun d:missing :extra")
      << "a stop may have kept it dry";
}

TEST(Defects, a_shot_that_is_still_open_is_not_whole) {
  const std::vector<FeatureState> cut{FeatureState::Interrupted, FeatureState::Done};
  auto open = dot();
  open.closed_cycle = 0, open.open_s = 0;
  expect_one(judged({open, bead()}, cut), "d", Kind::Cut, Board::Begun);
  auto again = open;  // given again, and still open: nothing is whole
  again.id = "", again.opened_cycle = 1500;
  const auto drop = shut_after(dot(), 3);
  const JobResult r = judged({drop, again, bead()}, cut);
  ASSERT_EQ(r.defects.size(), 2u);
  EXPECT_EQ(r.defects[0].kind, Kind::Cut);
  EXPECT_EQ(r.board, Board::Begun);
  auto spot = bead(), whole = bead();
  spot.board_mm = {{20, 10, 0.2}, {20.1, 10, 0.2}}, spot.error_mm = 28;
  whole.id = "", whole.closed_cycle = 0;
  const JobResult b = judged({dot(), spot, whole}, {FeatureState::Done, FeatureState::Interrupted});
  ASSERT_EQ(b.defects.size(), 2u);
  EXPECT_EQ(b.defects[0].kind, Kind::Cut);
}

TEST(Defects, a_feature_called_purge_is_judged_by_its_own_deposits) {
  auto called_purge = recipe();
  std::get<recipes::Dot>(called_purge.features[0]).id = "purge";
  std::get<recipes::Bead>(called_purge.features[1]).id = "purge";
  Deposit shot = dot();  // of purging, beside the work: far shorter than the dot, and no feature's
  shot.id = shot.kind = sim::kPurgeKind;
  shot.nominal_mm.clear(), shot.board_mm = {{-5, -5, 1}, {-9, -5, 1}};
  shot.error_mm = std::numeric_limits<double>::quiet_NaN();
  const auto judged_with = [&](const std::vector<Deposit>& deposits, FeatureState state) {
    JobResult r;
    r.deposits = deposits, r.has_world = true;
    r.beads = {{"purge", "polyline", 40}};
    auto one = called_purge;
    one.features.resize(1);
    const std::vector<FeatureState> features{state};
    add_judgement(r, judge_board(r, one, {features, {}}, kCycle_s));
    return r;
  };
  expect_one(judged_with({shot}, FeatureState::Done), "purge", Kind::Missing, Board::Begun);
  auto off = dot();
  off.id = "purge", off.error_mm = 0.06;
  expect_one(judged_with({shot, off}, FeatureState::Done), "purge", Kind::Beside, Board::Defects);
  auto laid = bead();
  laid.id = "purge";
  const JobResult r = judged_with({shot, shot, laid}, FeatureState::Done);
  ASSERT_EQ(laid_lengths(r).size(), 1u);
  EXPECT_DOUBLE_EQ(laid_lengths(r)[0].laid_mm.value_or(0), length_mm(laid));
}

TEST(Defects, what_a_job_leaves_out_is_no_defect_and_decides_whether_the_board_is_whole) {
  const std::vector<FeatureState> only_bead{FeatureState::LeftOut, FeatureState::Done};
  const auto judged_after = [&](std::vector<bool> whole, std::vector<Defect> defects,
                                const std::vector<Deposit>& deposits) {
    JobResult r;
    r.deposits = deposits, r.has_world = true;
    add_judgement(r, judge_board(r, recipe(), {only_bead, {}, {std::move(whole), std::move(defects)}}, kCycle_s));
    return r;
  };
  const JobResult alone = judged_after({}, {}, {bead()});
  EXPECT_TRUE(alone.defects.empty());
  EXPECT_EQ(alone.exit_code, ExitCode::Done) << "what was asked for is done";
  EXPECT_EQ(alone.board, Board::Begun) << "and the dot is missing";
  EXPECT_EQ(judged_after({true, false}, {}, {bead()}).board, Board::Whole);
  const Defect beside{"d", Kind::Beside, "0.2 mm beside"};
  const JobResult after = judged_after({true, false}, {beside}, {bead()});
  expect_one(after, "d", Kind::Beside, Board::Defects);
  EXPECT_EQ(after.defects[0].message, "by a job before: 0.2 mm beside");
  EXPECT_EQ(judged_after({true, false}, after.defects, {bead()}).defects[0].message, after.defects[0].message);
  EXPECT_EQ(judged_after({false, true}, {}, {bead()}).board, Board::Begun);
  expect_one(judged_after({true, false}, {}, {}), "b", Kind::Missing, Board::Begun);
  expect_one(judged_after({true, true}, {}, {dot(), bead()}), "d", Kind::Extra, Board::Defects);

  JobResult never;
  add_error(never, {Fault::DriveFault, "a drive fault", ""});
  const std::vector<FeatureState> not_begun{FeatureState::LeftOut, FeatureState::Open};
  add_judgement(never, judge_board(never, recipe(), {not_begun, {}}, kCycle_s));
  EXPECT_EQ(never.board, Board::Untouched);
}

// A job that is aborted on the first feature that it dispenses once more has not taken away what lies there.
TEST(Defects, what_a_job_was_to_dispense_once_more_and_has_not_come_to_lies_there_still) {
  const auto judged_after = [](std::vector<FeatureState> features, std::vector<bool> whole,
                               const std::vector<Deposit>& deposits, bool has_world) {
    JobResult r;
    add_error(r, {Fault::Aborted, "aborted", ""});
    r.deposits = deposits, r.has_world = has_world;
    add_judgement(r, judge_board(r, recipe(), {features, {}, {std::move(whole), {}}}, kCycle_s));
    return r;
  };
  for (const bool has_world : {true, false}) {
    const std::vector<Deposit> laid = has_world ? std::vector{dot()} : std::vector<Deposit>{};
    const std::vector<FeatureState> to_the_dot{FeatureState::Done, FeatureState::Open};
    const JobResult r = judged_after(to_the_dot, {true, true}, laid, has_world);
    EXPECT_TRUE(r.defects.empty());
    EXPECT_EQ(r.board, Board::Whole);
    expect_lacks(judged_after(to_the_dot, {true, false}, laid, has_world), "b");
  }
  // Kept dry by the stop: nothing has come on it, which a world alone can know.
  const std::vector<FeatureState> kept_dry{FeatureState::Done, FeatureState::Interrupted};
  EXPECT_TRUE(judged_after(kept_dry, {true, true}, {dot()}, true).defects.empty());
  expect_lacks(judged_after(kept_dry, {true, true}, {}, false), "b");
}

TEST(Defects, a_valve_that_a_fault_shuts_before_it_has_moved_leaves_the_board_untouched) {
  const std::vector<FeatureState> features{FeatureState::Interrupted, FeatureState::Open};
  for (const bool has_world : {true, false}) {
    JobResult r;
    add_error(r, {Fault::DriveFault, "a drive fault", ""});
    r.has_world = has_world;
    add_judgement(r, judge_board(r, recipe(), {features, {}}, kCycle_s));
    EXPECT_EQ(r.board, has_world ? Board::Untouched : Board::Begun) << "on a machine of steel nobody has seen it";
    EXPECT_EQ(r.defects.empty(), has_world);
  }
}

TEST(Defects, a_machine_without_a_world_tells_what_it_knows) {
  JobResult r;
  add_judgement(r, judge_board(r, recipe(), {kDone, {}}, kCycle_s));
  EXPECT_EQ(r.board, Board::Whole);
  for (const FeatureState state : {FeatureState::Open, FeatureState::Interrupted, FeatureState::Doubtful}) {
    const std::vector<FeatureState> features{FeatureState::Done, state};
    r = {};
    add_judgement(r, judge_board(r, recipe(), {features, {}}, kCycle_s));
    expect_one(r, "b", state == FeatureState::Open ? Kind::Missing : Kind::Cut, Board::Begun);
  }
}

TEST(Defects, an_errors_own_code_wins_and_defects_are_listed_beside_it) {
  JobResult r;
  add_error(r, {Fault::DriveFault, "a drive fault", ""});
  const std::vector<FeatureState> features{FeatureState::Interrupted, FeatureState::Open};
  add_judgement(r, judge_board(r, recipe(), {features, {}}, kCycle_s));
  EXPECT_EQ(r.exit_code, ExitCode::Device);
  EXPECT_EQ(r.defects.size(), 2u);
  EXPECT_EQ(r.board, Board::Begun);

  JobResult late = judged({dot()});
  add_error(late, {Fault::FileUnwritable, "no room", ""});
  EXPECT_EQ(late.exit_code, info(Fault::FileUnwritable).exit_code);

  JobResult never;
  add_error(never, {Fault::DriveFault, "a drive fault", ""});
  add_judgement(never, judge_board(never, recipe(), {std::vector<FeatureState>(2, FeatureState::Open), {}}, kCycle_s));
  EXPECT_EQ(never.board, Board::Untouched);
  EXPECT_TRUE(never.defects.empty()) << "nothing was begun";
}

TEST(Defects, the_summary_and_the_report_say_so_at_the_top) {
  const JobResult r = judged({dot()});
  const auto summary = to_json(r);
  EXPECT_EQ(summary.at("result"), "done_with_defects");
  EXPECT_EQ(summary.at("exit_code"), 9);
  EXPECT_EQ(summary.at("board"), "begun");
  ASSERT_EQ(summary.at("defects").size(), 1u);
  EXPECT_EQ(summary.at("defects")[0].at("feature"), "b");
  EXPECT_EQ(summary.at("defects")[0].at("kind"), "missing");
  EXPECT_FALSE(summary.at("defects")[0].at("message").get<std::string>().empty());
  const std::string page = report_page(r);
  EXPECT_NE(page.find("Done with defects"), std::string::npos);
  EXPECT_LT(page.find("Defects: 1"), page.find("Particulars"));
}

}  // namespace
}  // namespace gantry::record
