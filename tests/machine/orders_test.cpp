// What operators do in the middle of a job.
#include <cmath>

#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::Rig;

constexpr const char* kDemo = "recipes/demo-board.yaml";

run::Order order(OrderKind kind, double value = 1) { return {.kind = kind, .value = value}; }
bool valve_open(const cycle::Snapshot& s) { return (s.outputs & config::bit(config::Output::Valve)) != 0; }

TEST(Orders, hold_in_a_bead_closes_the_valve_and_resume_does_not_open_it_again) {
  Rig rig({.placement = "dx=0.5 mm"});
  std::uint32_t bead = motion::kTravel;
  CycleIndex held_at = 0, still_at = 0, resumed_at = 0;
  bool reopened = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (held_at == 0 && valve_open(s) && s.path_speed > 10) {  // in the middle of a bead
      bead = s.feature;
      held_at = s.cycle;
      EXPECT_TRUE(owner.order(order(OrderKind::Hold)));
    }
    if (held_at != 0 && s.cycle > held_at + 2 && resumed_at == 0) {
      EXPECT_FALSE(valve_open(s)) << s.cycle - held_at;
      if (still_at == 0 && s.path_speed == 0) still_at = s.cycle;
      if (still_at != 0 && s.cycle > still_at + 500) {
        resumed_at = s.cycle;
        EXPECT_TRUE(owner.order(order(OrderKind::Resume)));
      }
    }
    if (resumed_at != 0 && s.feature == bead && valve_open(s)) reopened = true;
  };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Done);
  ASSERT_GT(resumed_at, 0);
  EXPECT_LT(still_at - held_at, 300);
  EXPECT_FALSE(reopened);
  ASSERT_EQ(result.interrupted.size(), 1u);
  EXPECT_EQ(result.features_done, result.features_total - 1);
}

TEST(Orders, override_changes_the_time_and_not_the_path) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool slowed = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!slowed && owner.latest().block >= 8 && owner.latest().path_speed > 10)
      slowed = owner.order(order(OrderKind::Override, 0.5)).has_value();
  };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Done);
  ASSERT_TRUE(slowed);
  EXPECT_GT(result.actual_s, 1.2 * result.predicted_s);
  for (const auto& d : result.deposits)
    EXPECT_LE(d.error_mm, 0.25) << d.id;  // on the path; ends are worth v x 0.5 ms more
  EXPECT_TRUE(result.collisions.empty());
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

TEST(Orders, what_does_not_fit_the_state_is_refused_with_a_reason) {
  Rig rig({});
  ASSERT_TRUE(rig.owner().bring_up());
  for (const OrderKind kind : {OrderKind::Hold, OrderKind::Resume, OrderKind::Abort}) {
    const auto refused = rig.owner().order(order(kind));
    ASSERT_FALSE(refused) << run::name(kind);
    EXPECT_EQ(refused.error().fault, Fault::Refused);
    EXPECT_NE(refused.error().message.find(std::string(run::name(kind))), std::string::npos);
  }
}

}  // namespace
}  // namespace gantry
