// The speed of a job that an operator changes in the middle of it.
#include <algorithm>
#include <cmath>

#include "tests/machine/order.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::order;
using test::Rig;
using test::valve_open;

constexpr const char* kOverridden = "recipes/demo-board.yaml";

TEST(Overrides, override_changes_the_time_and_not_the_path) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool slowed = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!slowed && owner.latest().block >= 8 && owner.latest().path_speed > 10)
      slowed = owner.order(order(OrderKind::Override, 0.5)).has_value();
  };
  const auto result = rig.run(kOverridden);
  EXPECT_EQ(result.exit_code, ExitCode::DoneWithDefects) << "beads are thicker at half their speed";
  EXPECT_EQ(result.board, record::Board::Defects);
  EXPECT_EQ(std::count_if(result.defects.begin(), result.defects.end(),
                          [](const auto& d) { return d.kind == record::Defect::Kind::Speed; }),
            6)
      << "each bead, and no dot";
  ASSERT_TRUE(slowed);
  EXPECT_GT(result.actual_s, 1.2 * result.predicted_s);
  for (const auto& d : result.deposits)
    EXPECT_LE(d.error_mm, 0.25) << d.id;  // on the path; ends are worth v x 0.5 ms more
  EXPECT_TRUE(result.collisions.empty());
}

// Raised while it dispenses, a bead keeps the speed with which it was begun; the next one has the new one.
TEST(Overrides, an_override_is_raised_when_the_valve_has_shut) {
  Rig rig({.placement = "dx=0.5 mm", .change = [](config::Machine& m) { m.override_max = 1.5; }});
  bool slowed = false, raised = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (!slowed && s.block != 0) slowed = owner.order(order(OrderKind::Override, 0.5)).has_value();
    if (slowed && !raised && valve_open(s) && s.path_speed > 5 && s.override_factor == 0.5) {
      raised = owner.order(order(OrderKind::Override, 1)).has_value();
      EXPECT_EQ(owner.order_said(), "100 % when the valve has shut");
    }
    EXPECT_FALSE(owner.order(order(OrderKind::Override, 1.6))) << "more than the machine allows";
  };
  const auto result = rig.run("recipes/patterns.yaml");
  ASSERT_TRUE(raised);
  EXPECT_EQ(std::count_if(result.defects.begin(), result.defects.end(),
                          [](const auto& d) { return d.kind == record::Defect::Kind::Speed; }),
            1)
      << "the bead that was begun at half its speed";
}

// A hold shuts the valve: what has waited for that comes then. An override of 0 takes its place.
TEST(Overrides, an_override_that_waits_for_the_valve_outlives_a_hold_but_not_another_override) {
  for (const bool by_hold : {true, false}) {
    Rig rig({.placement = "dx=0.5 mm"});
    bool slowed = false, raised = false, resumed = false;
    CycleIndex held_at = 0;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (!slowed && s.block != 0) slowed = owner.order(order(OrderKind::Override, 0.5)).has_value();
      if (slowed && !raised && valve_open(s) && s.path_speed > 5 && s.override_factor == 0.5) {
        raised = owner.order(order(OrderKind::Override, 1)).has_value();
        EXPECT_EQ(owner.order_said(), "100 % when the valve has shut");
        EXPECT_TRUE(
            owner.order(by_hold ? run::Order{.kind = OrderKind::Hold, .now = true} : order(OrderKind::Override, 0)));
        EXPECT_EQ(owner.order_said().find("100 % when the valve has shut is taken back") != std::string::npos, !by_hold)
            << owner.order_said();
        EXPECT_EQ(owner.progress().override_next.has_value(), by_hold);
        held_at = s.cycle;
      }
      if (held_at == 0 || resumed || s.cycle < held_at + 3000) return;
      EXPECT_EQ(s.override_factor, by_hold ? 1 : 0.5);
      resumed = owner.order(order(OrderKind::Resume)).has_value();
    };
    const auto result = rig.run("recipes/patterns.yaml");
    EXPECT_TRUE(resumed);
    EXPECT_EQ(result.features_done, result.features_total);
    EXPECT_EQ(rig.owner().latest().override_factor, by_hold ? 1 : 0.5);
  }
}

TEST(Overrides, an_override_may_be_as_low_as_1_percent) {
  Rig rig({.placement = "dx=0.5 mm"});
  CycleIndex slow_at = 0;
  double before = 0;
  bool back = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (slow_at == 0 && valve_open(s) && s.path_speed > 10) {
      before = s.path_speed;
      EXPECT_TRUE(owner.order(order(OrderKind::Override, 0.01)));
      slow_at = s.cycle;
    }
    if (slow_at == 0 || back) return;
    if (s.cycle > slow_at + 300 && s.cycle <= slow_at + 500) {
      EXPECT_NEAR(s.path_speed, 0.01 * before, 0.005 * before);
    }
    if (s.cycle == slow_at + 500) {
      EXPECT_TRUE(owner.order({.kind = OrderKind::Hold, .now = true}));
    }
    if (s.cycle < slow_at + 9000) return;  // the needle has lifted, at 1 % too
    back = true;
    EXPECT_EQ(s.path_speed, 0);
    EXPECT_TRUE(owner.order(order(OrderKind::Override, 1)));
    EXPECT_TRUE(owner.order(order(OrderKind::Resume)));
  };
  const auto result = rig.run("recipes/patterns.yaml");
  EXPECT_TRUE(back);
  EXPECT_TRUE(result.errors.empty());
  EXPECT_EQ(result.features_done, result.features_total);
}

TEST(Overrides, an_override_of_0_holds_and_one_above_100_ends_with_the_job) {
  Rig rig({.placement = "dx=0.5 mm", .change = [](config::Machine& m) { m.override_max = 1.5; }});
  CycleIndex held_at = 0;
  bool fast = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (held_at == 0 && s.block != 0 && s.path_speed > 10 && !valve_open(s)) {
      EXPECT_TRUE(owner.order(order(OrderKind::Override, 0)));
      held_at = s.cycle;
    }
    if (held_at != 0 && s.cycle == held_at + 500) {
      EXPECT_TRUE(owner.held());
      EXPECT_TRUE(owner.order(order(OrderKind::Resume)));
    }
    if (held_at != 0 && !fast && s.cycle > held_at + 600 && !valve_open(s))
      fast = owner.order(order(OrderKind::Override, 1.5)).has_value();
  };
  EXPECT_EQ(rig.run(kOverridden).exit_code, ExitCode::Done);
  ASSERT_TRUE(fast);
  EXPECT_EQ(rig.owner().latest().override_factor, 1.5);
  rig.on_step = {};
  EXPECT_EQ(rig.run(kOverridden).exit_code, ExitCode::Done);
  EXPECT_EQ(rig.owner().latest().override_factor, 1);
}

TEST(Overrides, an_override_below_100_is_in_force_in_the_next_job_too) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool slowed = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!slowed && owner.latest().block != 0) slowed = owner.order(order(OrderKind::Override, 0.6)).has_value();
  };
  EXPECT_EQ(rig.run("recipes/patterns.yaml").exit_code, ExitCode::DoneWithDefects);
  ASSERT_TRUE(slowed);
  double least = 1, most = 0;
  rig.on_step = [&](run::Owner& owner) {
    least = std::min<double>(least, owner.latest().override_factor);
    most = std::max<double>(most, owner.latest().override_factor);
  };
  const auto next = rig.run("recipes/patterns.yaml");
  EXPECT_EQ(next.exit_code, ExitCode::DoneWithDefects) << "every bead is too thick";
  EXPECT_FLOAT_EQ(static_cast<float>(least), 0.6F);
  EXPECT_FLOAT_EQ(static_cast<float>(most), 0.6F);
  EXPECT_GT(next.actual_s, 1.2 * next.predicted_s);
  const auto told = [](const auto& event) {
    return event.find("an override of 60 % is in force") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(next.events.begin(), next.events.end(), told));
}

// The machine allows 100 %; what is dispensed allows more, one of them less than the other.
TEST(Overrides, an_override_above_100_is_allowed_by_the_materials_of_the_job_while_it_runs) {
  const recipes::Recipe patterns = test::load_recipe("recipes/patterns.yaml");
  for (const double allowed : {1.0, 1.3}) {
    recipes::Recipe recipe = patterns;
    ASSERT_FALSE(recipe.materials.empty());
    for (auto& m : recipe.materials) m.override_max = 1.8;
    recipe.materials.front().override_max = allowed;
    Rig rig({.placement = "dx=0.5 mm"});
    bool raised = false, asked = false;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (asked || s.block == 0 || valve_open(s)) return;
      asked = true;
      const auto more = owner.order(order(OrderKind::Override, 1.35));
      ASSERT_FALSE(more);
      EXPECT_NE(more.error().message.find(allowed > 1 ? "130 %" : "100 %"), std::string::npos) << more.error().message;
      EXPECT_NE(more.error().message.find("of its materials"), std::string::npos) << more.error().message;
      raised = owner.order(order(OrderKind::Override, 1.25)).has_value();
    };
    EXPECT_EQ(rig.run(recipe).exit_code, ExitCode::Done);
    EXPECT_TRUE(asked);
    EXPECT_EQ(raised, allowed > 1);
    rig.on_step = {};
    for (int n = 0; n < 5; ++n) EXPECT_TRUE(rig.owner().idle());
    EXPECT_EQ(rig.owner().latest().override_factor, 1) << "the machine alone does not allow it";
    EXPECT_FALSE(rig.owner().order(order(OrderKind::Override, 1.25))) << "no job runs";
  }
}

}  // namespace
}  // namespace gantry
