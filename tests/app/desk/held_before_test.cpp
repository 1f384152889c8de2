// A hold while a job or parking is prepared, by an order or by the button: it waits before its first motion.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

/// While a job is prepared the owner does not know it yet.
TEST_F(Desks, a_hold_while_a_job_is_prepared_lets_it_wait_before_its_first_motion) {
  client_->say(run_order(1));
  const int begin = steps_;
  bool asked = false, moved = false;
  int waits = 0;
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"hold\",\"id\":2}\n{\"order\":\"status\",\"id\":3}\n") > 0;
    const auto& s = owner_->latest();
    if (waits <= 3000) moved = moved || s.block != 0;
    if (owner_->undertaking() == run::Undertaking::Job && owner_->state() == cycle::State::Held) ++waits;
    if (waits == 3000) client_->say("{\"order\":\"resume\",\"id\":4}\n"), ++waits;
  };
  serve_until(1);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_NE(answer(2).dump().find("waits before its first motion"), std::string::npos) << answer(2).dump();
  EXPECT_TRUE(answer(3).value("held", false)) << answer(3).dump();
  EXPECT_GT(waits, 3000) << "the machine homes, and then waits";
  EXPECT_FALSE(moved);
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

TEST_F(Desks, a_hold_of_a_job_that_is_prepared_is_taken_back_by_a_resume_and_forgotten_by_an_abort) {
  const auto run = [&](int id) { return run_order(id, "job" + std::to_string(id)); };
  client_->say(run(1));
  int begin = steps_;
  bool asked = false, held = false;
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"override\",\"value\":0,\"id\":2}\n{\"order\":\"abort\",\"id\":3}\n") > 0;
  };
  serve_until(1);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  asked = false;
  begin = steps_;
  client_->say(run(4));
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"hold\",\"id\":5}\n{\"order\":\"resume\",\"id\":6}\n") > 0;
    held = held || owner_->held();
  };
  serve_until(4);
  EXPECT_TRUE(answer(6).value("ok", false)) << answer(6).dump();
  EXPECT_FALSE(held);
  EXPECT_EQ(answer(4).value("result", ""), "done") << answer(4).dump();
}

/// The button is pressed by somebody who sees the job begin: it is the same hold as that of a client.
TEST_F(Desks, the_hold_button_while_a_job_is_prepared_lets_it_wait_before_its_first_motion) {
  client_->say(run_order(1));
  const int begin = steps_;
  bool pressed = false, moved = false, told = false;
  int waits = 0;
  on_cycle_ = [&] {
    if (!pressed && steps_ > begin + 3) {
      pressed = owner_->world()->add_script("{do: press, input: hold, hold: 20 ms}").has_value();
      EXPECT_TRUE(pressed);
    }
    if (steps_ == begin + 40) told = client_->say("{\"order\":\"status\",\"id\":2}\n") > 0;
    const auto& s = owner_->latest();
    if (waits <= 2000) moved = moved || s.block != 0;
    if (owner_->undertaking() == run::Undertaking::Job && owner_->state() == cycle::State::Held) ++waits;
    if (waits == 2000) client_->say("{\"order\":\"resume\",\"id\":3}\n"), ++waits;
  };
  serve_until(1);
  EXPECT_TRUE(told);
  EXPECT_EQ(answer(2).value("doing", ""), "preparing") << answer(2).dump();
  EXPECT_TRUE(answer(2).value("held", false)) << answer(2).dump();
  EXPECT_GT(waits, 2000) << "the machine homes, and then waits";
  EXPECT_FALSE(moved);
  EXPECT_TRUE(answer(3).value("ok", false)) << answer(3).dump();
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

/// As status says while it is held: "the start button or `gantry resume` goes on".
TEST_F(Desks, the_start_button_lets_a_job_go_that_the_hold_button_has_held_while_it_was_prepared) {
  client_->say(run_order(1));
  const int begin = steps_;
  bool held = false, resumed = false;
  const auto press = [&](const char* input) {
    const std::string words = std::string("{do: press, input: ") + input + ", hold: 20 ms}";
    EXPECT_TRUE(owner_->world()->add_script(words).has_value());
  };
  on_cycle_ = [&] {
    const int step = steps_ - begin;
    if (step == 4) press("hold");
    if (step == 40 || step == 120) client_->say("{\"order\":\"status\",\"id\":" + std::to_string(step) + "}\n");
    if (step == 60) press("start");
    held = held || (step > 120 && owner_->held());
    // Whoever finds it on hold nevertheless lets it go, so that this ends.
    if (step > 40'000 && !resumed) resumed = client_->say("{\"order\":\"resume\",\"id\":3}\n") > 0;
  };
  serve_until(1);
  EXPECT_EQ(answer(40).value("doing", ""), "preparing") << answer(40).dump();
  EXPECT_TRUE(answer(40).value("held", false)) << answer(40).dump();
  EXPECT_NE(answer(40)["held_by"].value("next", "").find("start button"), std::string::npos) << answer(40).dump();
  EXPECT_EQ(answer(120).value("doing", ""), "preparing") << answer(120).dump();
  EXPECT_FALSE(answer(120).value("held", true)) << answer(120).dump();
  EXPECT_FALSE(held);
  EXPECT_FALSE(resumed);
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

/// What was asked for in the moment in which a job, a jog or parking begins is neither lost nor told twice.
TEST_F(Desks, a_hold_in_the_moment_in_which_a_job_begins_is_told_once) {
  for (const bool before : {true, false}) {
    const int id = before ? 1 : 11;
    const std::string job = "job" + std::to_string(id);
    client_->say(run_order(id, job));
    const int begin = steps_;
    bool asked = false, resumed = false;
    on_cycle_ = [&] {
      const bool moment = before ? steps_ > begin + 3 : owner_->undertaking() == run::Undertaking::Job;
      if (!asked && moment) asked = client_->say("{\"order\":\"hold\",\"id\":5}\n") > 0;
      if (!resumed && asked && owner_->undertaking() == run::Undertaking::Job && owner_->state() == cycle::State::Held)
        resumed = client_->say("{\"order\":\"resume\",\"id\":6}\n") > 0;
    };
    serve_until(id);
    EXPECT_EQ(answer(id).value("result", ""), "done") << answer(id).dump();
    std::ifstream file(folder_ / job / "summary.json");
    const Json summary = Json::parse(file);
    std::string actions;
    for (const auto& action : summary["actions"]) actions += action.dump() + "\n";
    std::size_t holds = 0;
    for (std::size_t at = actions.find("\"hold\""); at != std::string::npos; at = actions.find("\"hold\"", at + 1))
      ++holds;
    EXPECT_EQ(holds, 1u) << actions;
    EXPECT_LT(actions.find("\"hold\""), actions.find("\"resume\"")) << actions;
  }
}

TEST_F(Desks, a_hold_while_parking_is_planned_lets_it_wait_before_it_moves) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"50 mm\"},\"speed\":\"100 mm/s\"}\n");
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  serve_until(2);
  ASSERT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  client_->say("{\"order\":\"disable\",\"id\":3}\n");
  on_cycle_ = {};
  serve_until(3);
  client_->say("{\"order\":\"park\",\"id\":4}\n");  // it gives torque first
  bool asked = false, moved = false;
  int waits = 0;
  on_cycle_ = [&] {
    if (!asked && owner_->undertaking() == run::Undertaking::Park)
      asked = client_->say("{\"order\":\"hold\",\"id\":5}\n") > 0;
    if (waits <= 500) moved = moved || owner_->latest().block != 0;
    if (owner_->held() && owner_->latest().state == cycle::State::Ready) ++waits;
    if (waits == 500) client_->say("{\"order\":\"resume\",\"id\":6}\n"), ++waits;
    if (steps_ % 1000 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  serve_until(4);
  EXPECT_TRUE(answer(5).value("ok", false)) << answer(5).dump();
  EXPECT_FALSE(moved);
  EXPECT_GT(waits, 500);
  EXPECT_TRUE(answer(6).value("ok", false)) << answer(6).dump();
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
}

}  // namespace
}  // namespace gantry::desk
