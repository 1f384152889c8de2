// Status while a job runs or stands: where it is, and who or what holds it.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

class HeldBy : public Desks {
 protected:
  void run(int id) const { client_->say(run_order(id)); }
  /// Serves a job; `then` is called in the cycle after the machine was first seen held.
  void run_until_held(const std::function<void()>& begin, const std::function<void()>& then) {
    run(1);
    bool begun = false;
    int held = 0;
    on_cycle_ = [&, begin, then] {
      if (!begun && owner_->latest().state == cycle::State::Running && owner_->progress().features_done == 0 &&
          owner_->latest().path_speed > 1) {
        begun = true;
        begin();
      }
      if (owner_->latest().state == cycle::State::Held || owner_->latest().state == cycle::State::Stopped ||
          (begun && owner_->state() == cycle::State::Held))
        ++held;
      if (held == 200) then();
    };
    serve_until(1);
  }
};

TEST_F(HeldBy, an_order_is_told_to_everybody_and_as_ones_own_to_whom_gave_it) {
  Peer other(folder_ / "owner.sock");
  std::string of_other;
  run_until_held([&] { other.say("{\"order\":\"hold\",\"now\":true,\"id\":2}\n"); },
                 [&] {
                   client_->say("{\"order\":\"status\",\"id\":3}\n");
                   other.say("{\"order\":\"status\",\"id\":4}\n{\"order\":\"resume\",\"id\":5}\n");
                 });
  of_other = other.hear();
  const Json seen = answer(3)["held_by"];
  ASSERT_TRUE(seen.is_object()) << answer(3).dump();
  EXPECT_EQ(seen.value("by", ""), "order");
  EXPECT_EQ(seen.value("words", ""), "held by the order `hold`");
  EXPECT_EQ(seen.value("next", ""), "`gantry resume` goes on, `gantry abort` ends it");
  EXPECT_FALSE(seen.value("yours", true));
  EXPECT_NE(of_other.find("\"yours\":true"), std::string::npos) << of_other;
  EXPECT_NE(answer(3).value("said", "").find("\nheld by the order `hold`; `gantry resume` goes on"), std::string::npos)
      << answer(3).value("said", "");
  client_->say("{\"order\":\"status\",\"id\":6}\n");
  serve_until(6);
  EXPECT_TRUE(answer(6)["held_by"].is_null()) << "the job is over: " << answer(6).dump();
}

/// Until the job has been brought to its end: `resume` is refused by then, and nobody is sent to it.
TEST_F(HeldBy, what_was_aborted_on_hold_is_not_told_to_be_held_any_more) {
  run_until_held([&] { client_->say("{\"order\":\"hold\",\"now\":true,\"id\":2}\n"); },
                 [&] { client_->say("{\"order\":\"abort\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n"); });
  const Json seen = answer(4);
  EXPECT_EQ(seen.value("busy_with", ""), "run") << "the job is over before anybody asks: " << seen.dump();
  EXPECT_EQ(seen.value("state", ""), "stopping") << seen.dump();
  EXPECT_FALSE(seen.value("held", true));
  EXPECT_TRUE(seen["held_by"].is_null()) << seen["held_by"].dump();
}

TEST_F(HeldBy, an_override_of_nothing_is_named_as_such) {
  run_until_held([&] { client_->say("{\"order\":\"override\",\"value\":0,\"id\":2}\n"); },
                 [&] { client_->say("{\"order\":\"status\",\"id\":3}\n{\"order\":\"resume\",\"id\":4}\n"); });
  EXPECT_EQ(answer(3)["held_by"].value("words", ""), "held by an override of 0 %") << answer(3).dump();
  EXPECT_TRUE(answer(3)["held_by"].value("yours", false));
}

/// While it is prepared it stands already for whoever waits for it.
TEST_F(HeldBy, a_hold_of_a_job_that_is_prepared_is_told_at_once) {
  run(1);
  const int begin = steps_;
  bool said = false;
  on_cycle_ = [&] {
    if (!said && steps_ > begin + 3)
      said =
          client_->say(
              "{\"order\":\"hold\",\"id\":2}\n{\"order\":\"status\",\"id\":3}\n{\"order\":\"resume\",\"id\":4}\n") > 0;
  };
  serve_until(1);
  EXPECT_EQ(answer(3)["held_by"].value("by", ""), "order") << answer(3).dump();
  EXPECT_EQ(answer(3).value("busy_with", ""), "run");
  EXPECT_NE(answer(3).value("said", "").find("job: preparing"), std::string::npos) << answer(3).value("said", "");
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

class ByButton : public HeldBy {
  std::string script() const override { return "- {at: feature dot 1, do: press, input: hold, hold: 100 ms}"; }
};

TEST_F(ByButton, the_machine_s_hold_button_is_named_until_a_resume) {
  run_until_held([] {}, [&] { client_->say("{\"order\":\"status\",\"id\":3}\n{\"order\":\"resume\",\"id\":4}\n"); });
  EXPECT_EQ(answer(3)["held_by"].value("by", ""), "button") << answer(3).dump();
  EXPECT_NE(answer(3)["held_by"].value("next", "").find("the start button or `gantry resume`"), std::string::npos);
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
}

class ByDoor : public HeldBy {
  std::string script() const override {
    return "- {at: feature dot 1, do: set_input, input: door_closed, on: false}\n"
           "- {at: feature dot 1, after: 2 s, do: set_input, input: door_closed, on: true}";
  }
};

TEST_F(ByDoor, the_fault_that_has_stopped_it_is_named_with_its_remedy_and_after_its_reset_what_goes_on) {
  run(1);
  int held = 0;
  on_cycle_ = [&] {
    held += owner_->held();
    if (held == 1000) client_->say("{\"order\":\"status\",\"id\":3}\n");
    if (held == 4000) client_->say("{\"order\":\"reset\",\"id\":4}\n");
    if (held == 5000) client_->say("{\"order\":\"status\",\"id\":5}\n{\"order\":\"resume\",\"id\":6}\n");
  };
  serve_until(1);
  EXPECT_EQ(answer(3).value("door", ""), "open") << answer(3).dump();
  EXPECT_EQ(answer(3)["held_by"].value("by", ""), "fault") << answer(3).dump();
  EXPECT_NE(answer(3)["held_by"].value("words", "").find("stopped: the door is open [G704]"), std::string::npos)
      << answer(3)["held_by"].dump();
  EXPECT_NE(answer(3)["held_by"].value("next", "").find("close the door, then reset"), std::string::npos);
  EXPECT_EQ(answer(5).value("door", ""), "closed");
  EXPECT_NE(answer(5)["held_by"].value("words", "").find("which was reset"), std::string::npos) << answer(5).dump();
  EXPECT_EQ(answer(5)["held_by"].value("next", ""), "`gantry resume` goes on, `gantry abort` ends it");
}

/// The same facts in words and as members.
TEST_F(HeldBy, a_job_that_runs_is_told_with_feature_progress_time_override_mode_and_door) {
  run(1);
  std::vector<std::string> features;
  int asked = 0;
  on_cycle_ = [&] {
    const auto p = owner_->progress();
    if (!p.feature.empty() && (features.empty() || features.back() != p.feature)) features.push_back(p.feature);
    if (asked == 0 && owner_->latest().path_speed > 1 && p.features_done == 1 && !p.feature.empty())
      asked += client_->say("{\"order\":\"override\",\"value\":0.5,\"id\":2}\n") > 0;
    else if (asked > 0 && ++asked == 30)
      client_->say("{\"order\":\"status\",\"id\":3}\n");
  };
  serve_until(1);
  EXPECT_EQ(features, (std::vector<std::string>{"a", "b", "corner"}));
  const Json s = answer(3);
  const std::string said = s.value("said", "");
  EXPECT_EQ(s.value("busy_with", ""), "run");
  EXPECT_EQ(s.value("recipe", ""), std::filesystem::absolute(kShort).string());
  EXPECT_EQ(s.value("feature", ""), "b") << s.dump();
  EXPECT_EQ(s.value("features_total", 0), 3);
  EXPECT_TRUE(s["remaining_s"].is_number());
  EXPECT_EQ(s.value("door", ""), "closed");
  EXPECT_TRUE(s["held_by"].is_null());
  for (const std::string& words :
       {std::string("running, automatic, override 50 %, door closed"),
        std::string("job: 1 of 3 features, dispensing, at 'b', "), std::string(" s gone, about "),
        std::string(" s left"), "\n     " + s.value("recipe", "")})
    EXPECT_NE(said.find(words), std::string::npos) << "'" << words << "' in\n" << said;
}

TEST_F(HeldBy, what_is_no_job_is_named_too) {
  client_->say("{\"order\":\"home\",\"id\":1}\n");
  bool said = false;
  on_cycle_ = [&] {
    if (!said && owner_->latest().state == cycle::State::Homing)
      said = client_->say("{\"order\":\"status\",\"id\":2}\n") > 0;
  };
  serve_until(1);
  EXPECT_NE(answer(2).value("said", "").find("\nunder way: 'home'"), std::string::npos) << answer(2).value("said", "");
}

}  // namespace
}  // namespace gantry::desk
