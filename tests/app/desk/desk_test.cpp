// The desk's orders and jobs.
#include "app/desk/desk.hpp"

#include <chrono>
#include <map>

#include "app/desk/prepare.hpp"
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

TEST_F(Desks, an_abort_cancels_an_order_that_waits) {
  client_->say("{\"order\":\"home\",\"id\":1}\n");
  step();
  Peer other(folder_ / "owner.sock");
  other.say("{\"order\":\"abort\",\"id\":2}\n");
  std::string heard;
  for (int i = 0; i < 30 && heard.empty(); ++i) step(), heard += other.hear();
  EXPECT_NE(heard.find("\"ok\":true"), std::string::npos) << heard;
  serve_until(1, 2000);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
}

TEST_F(Desks, an_abort_cancels_a_job_that_is_prepared_and_nothing_moves_afterwards) {
  client_->say(run_order(1, "job", "recipes/demo-board.yaml"));
  bool sent = false;
  on_cycle_ = [&] {
    if (!sent && steps_ > 30) sent = client_->say("{\"order\":\"abort\",\"id\":2}\n") > 0;
  };
  client_->say("{\"order\":\"abort\",\"id\":3}\n");  // behind it in one turn: it waits already
  serve_until(1, 3000);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "job"));
  EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
}

/// Between two steps, and before the first, the loop has nothing to do and is ready, or disabled.
TEST_F(Desks, status_never_reads_as_idle_while_there_is_an_order) {
  const std::string recipe = std::filesystem::absolute(kShort);
  const std::vector<std::string> orders{
      "\"enable\"", "\"disable\"", "\"home\"", "\"park\"",
      "\"run\",\"recipe\":\"" + recipe + "\",\"out\":\"" + (folder_ / "job").string() + '"'};
  int id = 10;
  for (const std::string& order : orders) {
    SCOPED_TRACE(order);
    Peer watch(folder_ / "owner.sock");
    std::string seen;
    std::map<std::string, int> states;
    client_->say("{\"order\":" + order + ",\"id\":" + std::to_string(++id) + "}\n");
    on_cycle_ = [&] {
      seen += watch.hear();
      if (steps_ % 5 == 0) watch.say("{\"order\":\"status\"}\n");
      for (std::size_t end = seen.find('\n'); end != std::string::npos; end = seen.find('\n')) {
        const Json status = Json::parse(seen.substr(0, end));
        seen.erase(0, end + 1);
        const std::string state = status.value("state", "");
        EXPECT_EQ(state == "ready" || state == "disabled", status["busy_with"].is_null()) << status.dump();
        EXPECT_EQ(status.value("said", "").substr(0, state.size()), state);
        ++states[state];
      }
    };
    serve_until(id);
    EXPECT_TRUE(answer(id).value("ok", false)) << answer(id).dump();
    if (order.starts_with("\"run")) {
      EXPECT_GT(states["preparing"], 0);
      EXPECT_GT(states["running"], 0);
    }
    client_->hear(), heard_.clear();
  }
}

/// It is answered by what it has led to, not by itself.
TEST_F(Desks, an_order_that_is_done_is_not_under_way_in_its_own_answer) {
  int id = 10;
  for (const std::string order : {"part_removed", "enable", "part_removed", "home", "park"}) {
    SCOPED_TRACE(order);
    client_->say("{\"order\":\"" + order + "\",\"id\":" + std::to_string(++id) + "}\n");
    serve_until(id);
    const Json done = answer(id);
    EXPECT_TRUE(done.value("ok", false)) << done.dump();
    EXPECT_EQ(done.value("state", ""), id == 11 ? "disabled" : "ready") << done.dump();
    EXPECT_TRUE(done["busy_with"].is_null()) << done.dump();
    EXPECT_EQ(done.value("said", "").find("under way"), std::string::npos) << done.dump();
  }
}

/// Both lines come in one turn: the order waits until the turn is over.
TEST_F(Desks, an_order_that_was_taken_and_has_not_begun_is_what_the_owner_is_busy_with) {
  Peer other(folder_ / "owner.sock");
  step();  // both are known
  client_->say("{\"order\":\"park\",\"id\":1}\n");
  other.say("{\"order\":\"status\"}\n");
  std::string heard;
  for (int i = 0; i < 3 && heard.empty(); ++i) step(), heard += other.hear();
  const Json status = Json::parse(heard.substr(0, heard.find('\n')));
  EXPECT_EQ(status.value("state", ""), "preparing") << heard;
  EXPECT_EQ(status.value("busy_with", Json()), Json("park")) << heard;
}

/// Each order alone is taken; together they must not leave a machine that neither answers nor has torque.
TEST_F(Desks, a_reset_and_an_order_of_another_client_in_one_poll_are_both_carried_out) {
  Peer other(folder_ / "owner.sock");
  int id = 100;
  for (const char* order : {"enable", "home", "park", "disable", "enable"})
    for (const bool reset_first : {true, false}) {
      SCOPED_TRACE(std::string(order) + (reset_first ? " behind a reset" : " ahead of a reset"));
      if (std::string(order) != "disable") {
        client_->say("{\"order\":\"disable\",\"id\":" + std::to_string(++id) + "}\n");
        serve_until(id);
      }
      const int reset = ++id, asked = ++id;
      const std::string first = "{\"order\":\"reset\",\"id\":" + std::to_string(reset) + "}\n";
      const std::string second = "{\"order\":\"" + std::string(order) + "\",\"id\":" + std::to_string(asked) + "}\n";
      client_->say(reset_first ? first : second);
      other.say(reset_first ? second : first);
      std::string heard;
      const int begin = steps_;
      on_cycle_ = [&] { heard_ += other.hear(); };
      serve_until(asked, 3);
      EXPECT_TRUE(answer(asked).value("ok", false)) << answer(asked).dump();
      EXPECT_TRUE(answer(reset).value("ok", false)) << answer(reset).dump();
      EXPECT_EQ(owner_->latest().state, std::string(order) == "disable" ? cycle::State::Disabled : cycle::State::Ready);
      if (std::string(order) == "enable") {
        EXPECT_LT(steps_ - begin, 2000);
      }
    }
}

TEST_F(Desks, a_stop_with_an_id_that_is_none_stops_and_is_answered_without_it) {
  home();
  const std::string id(200, 'x');
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"100 mm\"},\"speed\":\"20 mm/s\"}\n");
  const int begin = steps_;
  bool sent = false;
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
    if (!sent && steps_ > begin + 300) sent = client_->say("{\"order\":\"abort\",\"id\":\"" + id + "\"}\n") > 0;
  };
  const double before = owner_->latest().target[0];
  serve_until(2, 20);
  EXPECT_EQ(code_of(answer(2)), "G701") << answer(2).dump();
  EXPECT_LT(owner_->latest().target[0], before + 10);
  EXPECT_NE(heard_.find("\"order\":\"abort\"}"), std::string::npos) << "the answer has no id";
  EXPECT_EQ(heard_.find(id), std::string::npos);
}

/// Whoever ends the owner, or aborts the job, does not wait for a proof that nobody wants any more.
TEST_F(Desks, a_proof_is_abandoned_when_the_owner_is_asked_to_end) {
  const std::string recipe = std::filesystem::absolute("tests/machine/many-dots.yaml");
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin_proof = Clock::now();
  ASSERT_TRUE(prepare(machine_, recipe));
  const auto whole = Clock::now() - begin_proof;
  client_->say(run_order(1, "job", recipe));
  bool asked = false;
  on_cycle_ = [&] {
    if (!asked && Clock::now() - begin_proof > whole * 5 / 4) asked = client_->say("{\"order\":\"quit\"}\n") > 0;
  };
  EXPECT_TRUE(desk_->serve());
  ASSERT_TRUE(asked);
  ASSERT_EQ(owner_->latest().block, 0u);
  const Clock::time_point ended = Clock::now();
  desk_.reset();
  EXPECT_LT((Clock::now() - ended).count(), whole.count() / 2);
}

TEST_F(Desks, a_job_is_answered_in_short_and_told_in_its_folder) {
  client_->say(run_order(1));
  serve_until(1);
  const Json done = answer(1);
  EXPECT_TRUE(done.value("ok", false)) << heard_;
  EXPECT_EQ(done.value("order", ""), "run");
  EXPECT_EQ(done.value("result", ""), "done");
  EXPECT_EQ(done.value("exit_code", -1), 0);
  EXPECT_EQ(done.value("folder", ""), (folder_ / "job").string());
  EXPECT_NE(done.value("said", "").find("3 of 3 features"), std::string::npos);
  EXPECT_LT(done.dump().size(), kLongestAnswer);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "job/summary.json"));
}

TEST_F(Desks, a_recipe_that_cannot_be_read_is_told_as_such) {
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"/none/board.yaml\"}\n");
  serve_until(1);
  EXPECT_NE(heard_.find("the owner, which runs as user"), std::string::npos) << heard_;
  EXPECT_EQ(errors_of(answer(1)).front().where, "/none/board.yaml");
}

TEST_F(Desks, a_thousand_mistakes_fit_into_an_answer) {
  std::vector<Error> errors(1000, Error{Fault::Usage, std::string(10'000, 'e'), "there"});
  const Json answer = failure(errors);
  EXPECT_LT(to_line(answer).size(), kLongestAnswer);
  EXPECT_EQ(answer["errors"].size() + answer["errors_left_out"].get<std::size_t>(), 1000u);
}

TEST_F(Desks, parking_is_answered_when_the_head_stands_there_and_needs_no_sign_of_life) {
  home();
  client_->say("{\"order\":\"park\",\"id\":2}\n");
  bool asked = false;
  on_cycle_ = [&] {
    if (!asked && owner_->latest().state == cycle::State::Running)
      asked = client_->say("{\"order\":\"home\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n") > 0;
  };
  serve_until(2);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  for (const auto& [axis, position] : machine_.park)
    EXPECT_NEAR(owner_->latest().target[axis.value], position, 1e-6) << axis.value;
  EXPECT_EQ(code_of(answer(3)), "G702");
  EXPECT_NE(answer(3).dump().find("'park'"), std::string::npos);
  EXPECT_EQ(answer(4).value("busy_with", ""), "park");
}

TEST_F(Desks, a_job_goes_on_without_its_client) {
  client_->say(run_order(1));
  int left = 400'000;
  on_cycle_ = [&] {
    if (client_ && owner_->latest().block > 0) client_.reset();
    if (std::filesystem::exists(folder_ / "job/summary.json") || --left == 0)
      Peer(folder_ / "owner.sock").say("{\"order\":\"quit\"}\n");
  };
  EXPECT_TRUE(desk_->serve());
  EXPECT_FALSE(client_);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "job/summary.json"));
}

TEST_F(Desks, a_second_order_that_takes_time_is_refused_and_the_answer_names_the_first) {
  client_->say("{\"order\":\"home\",\"id\":1}\n{\"order\":\"enable\",\"id\":2}\n");
  serve_until(1);
  EXPECT_TRUE(answer(1).value("ok", false));
  EXPECT_EQ(code_of(answer(2)), "G702");
  EXPECT_NE(answer(2).dump().find("'home'"), std::string::npos);
}

TEST_F(Desks, status_tells_mode_and_faults_and_the_clamp_opens_by_an_order) {
  client_->say("{\"order\":\"status\",\"id\":1}\n{\"order\":\"part_removed\",\"id\":2}\n");
  serve_until(2);
  EXPECT_EQ(answer(1).value("mode", ""), "automatic");
  EXPECT_EQ(answer(1).value("held", true), false);
  EXPECT_TRUE(answer(1)["faults"].empty());
  EXPECT_TRUE(answer(2).value("ok", false)) << heard_;
  EXPECT_EQ(owner_->latest().outputs & config::bit(config::Output::Clamp), 0u);
}

}  // namespace
}  // namespace gantry::desk
