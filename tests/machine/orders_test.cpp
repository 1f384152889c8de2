// What operators do in the middle of a job.
#include <algorithm>
#include <cmath>

#include "tests/machine/order.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::answer_of_reset;
using test::order;
using test::Rig;
using test::valve_open;

using test::kDemo;

/// As many orders as come in one turn, and more than the loop's ring holds: an order is put in flight, and the
/// machine's time stands while it is given.
TEST(Orders, no_time_passes_while_orders_are_given) {
  Rig rig({.placement = "dx=0.5 mm"});
  int turns = 0, taken = 0, refused = 0;
  CycleIndex obeyed_at = 0, given_at = 0;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (given_at != 0 && obeyed_at == 0 && s.override_factor == 0.75) obeyed_at = s.cycle;
    if (s.block < 3 || turns == 3) return;
    ++turns;
    given_at = s.cycle;
    for (int i = 0; i < 200; ++i) {
      const auto done = owner.order(order(OrderKind::Override, 0.75));
      ++(done ? taken : refused);
      EXPECT_EQ(owner.latest().cycle, given_at);
    }
  };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(turns, 3);
  EXPECT_GE(taken, 64);
  EXPECT_GT(refused, 0) << "what would wait for long is told to come again";
  EXPECT_GT(obeyed_at, 0);
  EXPECT_TRUE(result.collisions.empty());
  EXPECT_EQ(result.features_done, result.features_total);
}

TEST(Orders, an_interrupt_comes_to_rest_with_the_valve_closed_and_says_130) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool sent = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!sent && valve_open(owner.latest())) {
      sent = true;
      owner.interrupt(Error{Fault::Interrupted, "interrupted", ""});
    }
  };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Interrupted);
  EXPECT_FALSE(valve_open(rig.owner().latest()));
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Ready);
  const AxisVec at = rig.owner().latest().target;
  for (int i = 0; i < 100; ++i) rig.owner().idle();
  EXPECT_EQ(rig.owner().latest().target, at);
}

TEST(Orders, an_interrupt_at_any_time_of_homing_ends_in_order) {
  for (const CycleIndex after : {200, 900, 1300, 2100, 3000, 4200}) {
    Rig rig({.placement = "dx=0.5 mm"});
    CycleIndex begin = 0;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (begin == 0 && s.state == cycle::State::Homing) begin = s.cycle;
      if (begin != 0 && s.cycle == begin + after) owner.interrupt(Error{Fault::Interrupted, "interrupted", ""});
    };
    const auto result = rig.run(kDemo);
    EXPECT_EQ(result.exit_code, ExitCode::Interrupted)
        << after << ": " << (result.errors.empty() ? "" : to_text(result.errors.front()));
    EXPECT_EQ(rig.owner().latest().latched, Fault::None) << after;
  }
}

/// Aborts the first job of `rig` in the middle of a bead.
void abort_in_a_bead(Rig& rig) {
  bool sent = false;
  rig.on_step = [&](run::Owner& owner) {
    if (sent || !valve_open(owner.latest()) || owner.latest().path_speed < 10) return;
    sent = true;
    EXPECT_TRUE(owner.order(order(OrderKind::Abort)));
  };
  EXPECT_EQ(rig.run(kDemo).exit_code, info(Fault::Aborted).exit_code);
  ASSERT_TRUE(sent);
  rig.on_step = {};
}

TEST(Orders, after_an_abort_in_a_bead_the_next_job_raises_the_needle_and_runs) {
  Rig rig({.placement = "dx=0.5 mm"});
  abort_in_a_bead(rig);
  ASSERT_LT(rig.owner().latest().target[rig.machine().z.value], rig.machine().safe_z_mm - 5);
  const auto again = rig.run(kDemo);
  EXPECT_EQ(again.exit_code, ExitCode::Done) << (again.errors.empty() ? "" : to_text(again.errors.front()));
  EXPECT_EQ(again.features_done, again.features_total);
  EXPECT_TRUE(again.collisions.empty());
}

TEST(Orders, a_job_on_hold_can_be_aborted_and_the_machine_is_free) {
  Rig rig({.placement = "dx=0.5 mm"});
  CycleIndex held_at = 0;
  bool aborted = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (held_at == 0 && valve_open(s) && s.path_speed > 10 && owner.order(order(OrderKind::Hold))) held_at = s.cycle;
    if (held_at != 0 && !aborted && s.cycle > held_at + 400) aborted = owner.order(order(OrderKind::Abort)).has_value();
  };
  EXPECT_EQ(rig.run(kDemo).exit_code, info(Fault::Aborted).exit_code);
  ASSERT_TRUE(aborted);
  rig.on_step = {};
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Ready);
  const auto again = rig.run(kDemo);
  EXPECT_EQ(again.exit_code, ExitCode::Done) << (again.errors.empty() ? "" : to_text(again.errors.front()));
}

TEST(Orders, after_an_abort_homing_is_not_told_that_it_was_aborted) {
  Rig rig({.placement = "dx=0.5 mm"});
  abort_in_a_bead(rig);
  const auto homed = rig.owner().home();
  EXPECT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Ready);
  EXPECT_NEAR(rig.owner().latest().actual[rig.machine().z.value], 1, 0.1) << "in the new reference, at its switch";
}

TEST(Orders, homing_can_be_aborted_and_done_again) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  bool sent = false;
  rig.owner().on_step([&] {
    if (!sent && rig.owner().latest().state == cycle::State::Homing)
      sent = rig.owner().order(order(OrderKind::Abort)).has_value();
  });
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::Aborted);
  rig.owner().on_step({});
  const auto again = rig.owner().home();
  EXPECT_TRUE(again) << to_text(again.error());
}

TEST(Orders, a_job_is_refused_while_a_fault_is_latched_and_runs_after_the_reset) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 3, do: press, input: stop, hold: 100 ms}"});
  const auto stopped = rig.run(kDemo);
  ASSERT_NE(stopped.exit_code, ExitCode::Done);
  ASSERT_NE(rig.owner().latest().latched, Fault::None);
  const auto refused = rig.run(kDemo);
  ASSERT_FALSE(refused.errors.empty());
  EXPECT_EQ(refused.errors.front().fault, Fault::Latched) << to_text(refused.errors.front());
  EXPECT_EQ(refused.exit_code, ExitCode::Refused);
  for (int i = 0; i < 2000; ++i) rig.owner().idle();
  ASSERT_TRUE(rig.owner().order(order(OrderKind::Reset)));
  for (int i = 0; i < 500; ++i) rig.owner().idle();
  const auto again = rig.run(kDemo);
  EXPECT_EQ(again.exit_code, ExitCode::Done) << (again.errors.empty() ? "" : to_text(again.errors.front()));
}

/// By where the world says the axes are: C and U have lost their supply, X, Y and Z are referenced and stay.
TEST(Orders, a_job_homes_what_is_not_referenced_and_nothing_else) {
  Rig rig({.placement = "dx=0.5 mm"});
  ASSERT_EQ(rig.run("tests/cli/short-board.yaml").exit_code, ExitCode::Done);
  run::Owner& owner = rig.owner();
  const std::uint32_t all = owner.latest().referenced;
  ASSERT_TRUE(owner.world()->add_script("{do: power_cycle, station: cu, dark: 200 ms}"));
  for (int i = 0; i < 8000; ++i) ASSERT_TRUE(owner.idle());
  ASSERT_NE(owner.latest().referenced, all);
  ASSERT_EQ(owner.latest().referenced & 0b111u, all & 0b111u);
  ASSERT_TRUE(owner.order(order(OrderKind::Reset)));
  ASSERT_TRUE(test::answer_of_reset(owner));
  const AxisVec before = *owner.world()->axes();
  int homing = 0;
  double moved_mm = 0;
  rig.on_step = [&](run::Owner& o) {
    if (o.latest().state != cycle::State::Homing) return;
    ++homing;
    const AxisVec now = *o.world()->axes();
    for (std::size_t i = 0; i < 3; ++i) moved_mm = std::max(moved_mm, std::abs(now[i] - before[i]));
  };
  const auto result = rig.run("tests/cli/short-board.yaml");
  EXPECT_EQ(result.exit_code, ExitCode::Done) << (result.errors.empty() ? "" : to_text(result.errors.front()));
  EXPECT_GT(homing, 100);
  EXPECT_LT(moved_mm, 0.1);
}

TEST(Orders, another_recipe_finds_its_own_board_in_the_machine) {
  Rig rig({.placement = "dx=0.5 mm"});
  ASSERT_EQ(rig.run("tests/cli/short-board.yaml").exit_code, ExitCode::Done);
  const auto other = rig.run(kDemo);
  EXPECT_EQ(other.exit_code, ExitCode::Done) << (other.errors.empty() ? "" : to_text(other.errors.front()));
}

TEST(Orders, what_does_not_fit_the_state_is_refused_with_a_reason) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  for (const OrderKind kind : {OrderKind::Hold, OrderKind::Resume}) {
    const auto refused = rig.owner().order(order(kind));
    ASSERT_FALSE(refused) << run::name(kind);
    EXPECT_EQ(refused.error().fault, Fault::Refused);
    EXPECT_NE(refused.error().message.find(std::string(run::name(kind))), std::string::npos);
    EXPECT_NE(refused.error().message.find("the machine is disabled, and nothing is "), std::string::npos)
        << refused.error().message;
    EXPECT_TRUE(refused.error().message.ends_with("; nothing has to be done"))
        << "it names what may be done: " << refused.error().message;
  }
  EXPECT_TRUE(rig.owner().order(order(OrderKind::Abort))) << "an abort is never refused";
}

// ---- an abort cannot be undone, a reset starts nothing ----

TEST(Orders, an_abort_is_not_undone_by_a_reset_of_the_same_poll) {
  // At many instants of a job: in travel, over a mark, in a touch, in a bead, between two blocks.
  for (const CycleIndex after : {5, 300, 900, 2500, 4700, 7100, 9000, 12'000, 18'000, 25'000}) {
    Rig rig({.placement = "dx=0.5 mm"});
    CycleIndex begin = 0;
    bool reset_taken = false;
    AxisVec at_abort{};
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (s.block == 0 && begin == 0) return;
      if (begin == 0) begin = s.cycle;
      if (s.cycle < begin + after) return;
      if (at_abort == AxisVec{}) at_abort = s.target;
      EXPECT_TRUE(owner.order(order(OrderKind::Abort)));
      reset_taken = owner.order(order(OrderKind::Reset)).has_value() || reset_taken;
      EXPECT_FALSE(owner.order(order(OrderKind::Resume)));
    };
    const auto result = rig.run(kDemo);
    ASSERT_NE(begin, 0);
    EXPECT_EQ(result.exit_code, info(Fault::Aborted).exit_code) << after;
    EXPECT_FALSE(reset_taken) << after;
    EXPECT_FALSE(valve_open(rig.owner().latest())) << after;
    rig.on_step = {};
    const AxisVec at = rig.owner().latest().target;
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(rig.owner().idle());
    EXPECT_EQ(rig.owner().latest().target, at) << after;
  }
}

TEST(Orders, a_reset_is_refused_while_axes_home_and_keeps_their_torque) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  int refused = 0;
  rig.owner().on_step([&] {
    if (rig.owner().latest().state != cycle::State::Homing) return;
    const auto reset = rig.owner().order(order(OrderKind::Reset));
    ASSERT_FALSE(reset);
    EXPECT_NE(reset.error().message.find("abort"), std::string::npos) << reset.error().message;
    ++refused;
    EXPECT_NE(rig.owner().latest().enabled, 0u);
  });
  const auto homed = rig.owner().home();
  EXPECT_TRUE(homed) << to_text(homed.error());
  EXPECT_GT(refused, 100);
}

TEST(Orders, a_reset_right_after_enable_does_not_leave_the_machine_enabling) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  int refused = 0;
  rig.owner().on_step([&] {
    if (rig.owner().latest().state == cycle::State::Enabling)
      refused += rig.owner().order(order(OrderKind::Reset)).has_value() ? 0 : 1;
  });
  EXPECT_TRUE(rig.owner().enable());
  EXPECT_GT(refused, 0);
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Ready);
  EXPECT_EQ(rig.owner().latest().referenced, 0u) << "enabling moves no axis";
}

TEST(Orders, enabling_can_be_aborted_and_done_again) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  rig.owner().on_step([&] {
    if (rig.owner().latest().state != cycle::State::Enabling) return;
    EXPECT_TRUE(rig.owner().order(order(OrderKind::Abort)));
  });
  const auto enabled = rig.owner().enable();
  ASSERT_FALSE(enabled);
  EXPECT_EQ(enabled.error().fault, Fault::Aborted);
  rig.owner().on_step({});
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Disabled);
  EXPECT_EQ(rig.owner().latest().enabled, 0u);
  EXPECT_TRUE(rig.owner().enable());
}

TEST(Orders, a_reset_after_which_something_stays_latched_says_what) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature dot 3, do: set_input, input: door_closed, on: false}\n"
                     "- {at: cycle 60000, do: set_input, input: door_closed, on: true}"});
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Refused);
  ASSERT_EQ(rig.owner().latest().latched, Fault::DoorOpen);
  ASSERT_LT(rig.owner().latest().cycle, 59'000);
  ASSERT_TRUE(rig.owner().order(order(OrderKind::Reset)));
  const auto still = answer_of_reset(rig.owner());
  ASSERT_FALSE(still) << "the door is open";
  EXPECT_NE(still.error().message.find("G704"), std::string::npos) << still.error().message;
  EXPECT_EQ(rig.owner().latest().state, cycle::State::Stopped);
  while (rig.owner().latest().cycle < 60'500) ASSERT_TRUE(rig.owner().idle());
  ASSERT_TRUE(rig.owner().order(order(OrderKind::Reset)));
  EXPECT_TRUE(answer_of_reset(rig.owner()));
  EXPECT_EQ(rig.owner().latest().latched, Fault::None);
  const AxisVec at = rig.owner().latest().target;
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
  EXPECT_EQ(rig.owner().latest().target, at) << "a reset starts no motion";
  ASSERT_TRUE(rig.owner().order(order(OrderKind::Reset))) << "with nothing latched";
  EXPECT_TRUE(answer_of_reset(rig.owner()));
}

/// Both are given while the machine stands on hold, and the resume reaches the loop first.
TEST(Orders, a_reset_that_a_motion_has_overtaken_is_refused_as_one_that_came_later) {
  Rig rig({.placement = "dx=0.5 mm"});
  CycleIndex held_at = 0;
  std::optional<Result<void>> answer;
  bool asked = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (held_at == 0 && s.block == 3 && s.path_speed > 10) {
      EXPECT_TRUE(owner.order(order(OrderKind::Hold)));
      held_at = s.cycle;
    }
    if (held_at != 0 && !asked && s.cycle > held_at + 300 && s.state == cycle::State::Held) {
      asked = true;
      EXPECT_TRUE(owner.order(order(OrderKind::Resume)));
      EXPECT_TRUE(owner.order(order(OrderKind::Reset)));
    }
    if (asked && !answer) answer = owner.reset_answer();
  };
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
  ASSERT_TRUE(answer);
  ASSERT_FALSE(*answer);
  EXPECT_EQ(answer->error().fault, Fault::Refused);
  EXPECT_EQ(answer->error().message.substr(0, 21), "'reset' is refused: t") << answer->error().message;
}

TEST(Orders, a_hold_between_two_blocks_keeps_the_next_one_waiting) {
  Rig rig({.placement = "dx=0.5 mm"});
  CycleIndex held_at = 0;
  bool moved = false, resumed = false;
  AxisVec at{};
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (held_at == 0 && owner.progress().doing.starts_with("mark") && s.state == cycle::State::Ready && s.block == 0) {
      ASSERT_TRUE(owner.order(order(OrderKind::Hold)));
      EXPECT_TRUE(owner.held());
      held_at = s.cycle;
      at = s.target;
    }
    if (held_at == 0 || resumed) return;
    moved = moved || s.target != at;
    if (s.cycle > held_at + 3000) resumed = owner.order(order(OrderKind::Resume)).has_value();
  };
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
  EXPECT_TRUE(resumed);
  EXPECT_FALSE(moved);
}

/// Homing comes to its end; the job's first motion waits, and a hold button that somebody keeps pressed does the same.
TEST(Orders, a_hold_before_a_job_s_first_motion_keeps_it_waiting) {
  for (const bool button : {false, true}) {
    Rig rig({.placement = "dx=0.5 mm", .script = button ? "- {at: cycle 1, do: press, input: hold, hold: 20 s}" : ""});
    CycleIndex ready_at = 0;
    bool held = button, homed = false, played = false, resumed = false, all_had_torque = true;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (s.state == cycle::State::Homing) {
        homed = true;
        all_had_torque = all_had_torque && s.enabled == 0b11111;
        if (!held) held = owner.order(order(OrderKind::Hold)).has_value();
      }
      if (resumed) return;
      played = played || s.block != 0 || (button && homed);
      // Who holds while axes home lets them come home; who holds before lets none begin.
      if ((homed || button) && ready_at == 0 && s.state == cycle::State::Ready) ready_at = s.cycle;
      if (ready_at == 0 || s.cycle < ready_at + 3000) return;
      EXPECT_TRUE(owner.held());
      resumed = owner.order(order(OrderKind::Resume)).has_value();
    };
    EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
    EXPECT_TRUE(held);
    EXPECT_TRUE(resumed);
    EXPECT_FALSE(played) << "button " << button;
    EXPECT_TRUE(all_had_torque) << "drives that home have it";
  }
}

TEST(Orders, one_undertaking_at_a_time) {
  Rig rig({.placement = "dx=0.5 mm"});
  int asked = 0;
  rig.on_step = [&](run::Owner& owner) {
    if (asked > 0 || owner.latest().block == 0) return;
    ++asked;
    EXPECT_FALSE(owner.home());
    EXPECT_FALSE(owner.enable());
    EXPECT_FALSE(owner.disable());
    EXPECT_FALSE(owner.jog({.by = {{"Z", "1 mm"}}, .speed = ""}));
  };
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
  EXPECT_EQ(asked, 1);
}

TEST(Orders, after_an_interrupt_nothing_is_undertaken_any_more) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  rig.owner().interrupt(Error{Fault::Interrupted, "interrupted", ""});
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::Interrupted);
  EXPECT_EQ(rig.owner().latest().enabled, 0u);
}

TEST(Orders, an_abort_while_a_block_is_planned_ends_the_planning_and_nothing_moves) {
  Rig rig({.placement = "dx=0.5 mm"});
  const recipes::Recipe recipe = test::load_recipe("tests/machine/many-dots.yaml");
  AxisVec at{};
  int asked = 0;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    // All marks and touches are done, and the last block stands behind: what comes next is planned now.
    if (asked > 0 || owner.progress().doing != "dispensing" || s.block != 0) return;
    ++asked;
    at = s.target;
    EXPECT_TRUE(owner.order(order(OrderKind::Abort)));
    EXPECT_FALSE(owner.order(order(OrderKind::Reset)));
  };
  const auto result = rig.run(recipe);
  EXPECT_EQ(asked, 1) << "orders come in while 4000 dots are planned";
  EXPECT_EQ(result.exit_code, info(Fault::Aborted).exit_code);
  EXPECT_EQ(rig.owner().latest().target, at);
  EXPECT_EQ(result.features_done, 0u);
}

TEST(Orders, an_owner_that_ends_no_longer_calls_those_who_came_after_it) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  run::OwnerOptions options;
  options.virtual_time = true;
  auto owner = run::Owner::open(*machine, options);
  ASSERT_TRUE(owner) << to_text(owner.error());
  int calls = 0;
  (*owner)->on_step([&calls] { ++calls; });
  ASSERT_TRUE((*owner)->bring_up());
  ASSERT_GT(calls, 0);
  calls = 0;
  owner->reset();
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace gantry
