// An abort that says "mine" ends what its client has ordered, and no other one's; what is ended so was interrupted.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

class OwnOrders : public Desks {
 protected:
  [[nodiscard]] std::string run(int id) const { return run_order(id, "job" + std::to_string(id)); }
  [[nodiscard]] Json summary(int id) const {
    std::ifstream file(folder_ / ("job" + std::to_string(id)) / "summary.json");
    return file ? Json::parse(file) : Json::object();
  }
};

constexpr const char* kMine = "{\"order\":\"abort\",\"mine\":true,\"id\":9}\n";

TEST_F(OwnOrders, an_abort_of_its_own_orders_by_another_client_leaves_homing_alone) {
  Peer other(folder_ / "owner.sock");
  client_->say("{\"order\":\"home\",\"id\":1}\n");
  bool said = false;
  std::string heard;
  on_cycle_ = [&] {
    heard += other.hear();
    if (!said && owner_->latest().state == cycle::State::Homing) said = other.say(kMine) > 0;
  };
  serve_until(1);
  EXPECT_TRUE(said);
  EXPECT_NE(heard.find("\"ok\":true"), std::string::npos) << "an abort is never refused: " << heard;
  EXPECT_TRUE(answer(1).value("ok", false)) << answer(1).dump();
}

TEST_F(OwnOrders, an_abort_of_its_own_orders_leaves_the_job_of_another_client_alone) {
  Peer other(folder_ / "owner.sock");
  client_->say(run(1));
  int said = 0;
  on_cycle_ = [&] {
    other.hear();
    if (said == 0) said += other.say(kMine) > 0;  // while it is prepared
    if (said == 1 && owner_->latest().state == cycle::State::Running) said += other.say(kMine) > 0;
    if (said == 2 && owner_->progress().features_done == 1) said += other.say(kMine) > 0;
  };
  serve_until(1);
  EXPECT_EQ(said, 3);
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

TEST_F(OwnOrders, a_client_that_ends_its_own_job_has_interrupted_it_and_the_owner_goes_on) {
  client_->say(run(1));
  bool said = false;
  on_cycle_ = [&] {
    if (!said && owner_->latest().state == cycle::State::Running) said = client_->say(kMine) > 0;
  };
  serve_until(1);
  EXPECT_TRUE(said);
  EXPECT_EQ(code_of(answer(1)), "G700") << answer(1).dump();
  EXPECT_EQ(answer(1).value("exit_code", 0), 130);
  EXPECT_EQ(answer(1).value("result", ""), "interrupted");
  EXPECT_EQ(summary(1).value("exit_code", 0), 130);
  const Json actions = summary(1).value("actions", Json::array());
  EXPECT_EQ(std::count_if(actions.begin(), actions.end(), [](const Json& a) { return a["what"] == "interrupt"; }), 1)
      << actions.dump();
  EXPECT_EQ(owner_->latest().state, cycle::State::Ready) << "as after any abort, torque stays";
  on_cycle_ = {};
  client_->say("{\"order\":\"park\",\"id\":2}\n");
  serve_until(2);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
}

TEST_F(OwnOrders, a_client_that_ends_its_own_homing_has_interrupted_it) {
  client_->say("{\"order\":\"home\",\"id\":1}\n");
  bool said = false;
  on_cycle_ = [&] {
    if (!said && owner_->latest().state == cycle::State::Homing) said = client_->say(kMine) > 0;
  };
  serve_until(1);
  EXPECT_EQ(code_of(answer(1)), "G700") << answer(1).dump();
  EXPECT_EQ(answer(1).value("exit_code", 0), 130);
}

/// As an owner finds them that stood still while their client gave up.
TEST_F(OwnOrders, what_was_said_before_in_one_breath_is_not_begun_and_what_asks_or_stops_is_taken) {
  home();
  client_->say("{\"order\":\"park\",\"id\":2}\n{\"order\":\"resume\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n" +
               run(5) + kMine + "{\"order\":\"jog\",\"id\":6,\"by\":{\"X\":\"1 mm\"}}\n");
  const double before = owner_->latest().target[0];
  double moved = 0;
  on_cycle_ = [&] {
    if (!answered(6)) moved = std::max(moved, std::abs(owner_->latest().target[0] - before));
    if (steps_ % 20 == 0) client_->say("{\"order\":\"status\",\"id\":8}\n");
  };
  serve_until(6);
  for (const int id : {2, 3, 5}) EXPECT_EQ(code_of(answer(id)), "G700") << answer(id).dump();
  EXPECT_EQ(answer(5).value("board", ""), "untouched");
  EXPECT_TRUE(answer(4).value("ok", false));
  EXPECT_TRUE(answer(6).value("ok", false)) << "what it says afterwards counts: " << answer(6).dump();
  EXPECT_LE(moved, 1.001) << "parking would have gone farther";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "job5"));
}

TEST_F(OwnOrders, a_client_that_is_gone_and_has_taken_its_order_back_moves_nothing) {
  home();
  {
    Peer gone(folder_ / "owner.sock");
    gone.say("{\"order\":\"park\"}\n" + std::string(kMine));
  }
  bool moved = false;
  on_cycle_ = [&] { moved = moved || owner_->latest().state == cycle::State::Running; };
  client_->say("{\"order\":\"status\",\"id\":2}\n");
  serve_until(2, 500);
  EXPECT_FALSE(moved);
}

}  // namespace
}  // namespace gantry::desk
