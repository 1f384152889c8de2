// The desk and a part that was begun and not finished, or has defects: no job begins over it unasked.
#include <fmt/format.h>

#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

/// The first bead of the first job is cut by the stop button.
class APartThatIsCut : public Desks {
 protected:
  std::string script() const override {
    return "- {at: feature bead 1, after: 300 ms, do: press, input: stop, hold: 100 ms}";
  }
  BegunParts* parts() override { return &*parts_; }
  void SetUp() override {
    parts_.emplace((std::filesystem::temp_directory_path() / ("gantry-parts-" + std::to_string(getpid()))).string());
    Desks::SetUp();
  }
  void TearDown() override {
    Desks::TearDown();
    std::filesystem::remove_all(kept());
  }
  [[nodiscard]] std::filesystem::path kept() const {
    return std::filesystem::temp_directory_path() / ("gantry-parts-" + std::to_string(getpid()));
  }
  /// Files about parts.
  [[nodiscard]] std::size_t remembered() const {
    std::size_t n = 0;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(kept(), ignored))
      n += entry.path().filename().string().starts_with("part") ? 1u : 0u;
    return n;
  }
  /// UTC of its only part.
  static std::string began_in(const std::filesystem::path& folder) {
    std::ifstream file(folder / "part.json");
    return Json::parse(file, nullptr, false).value("began", "");
  }
  [[nodiscard]] bool clamped() const { return (owner_->latest().outputs & config::bit(config::Output::Clamp)) != 0; }
  Json ask(Json order) {
    order["id"] = ++id_;
    client_->say(order.dump() + "\n");
    serve_until(id_);
    return answer(id_);
  }
  Json run(const Json& more = Json::object(), const std::string& recipe = kShort) {
    Json order{{"order", "run"},
               {"recipe", std::filesystem::absolute(recipe).string()},
               {"out", (folder_ / "job").string()},
               {"force", true}};
    order.update(more);
    return ask(order);
  }
  /// The first job: it is stopped in its bead, and given up.
  void cut(const Json& more = Json::object()) {
    bool given_up = false;
    on_cycle_ = [&, asked = on_cycle_] {
      if (asked) asked();
      if (given_up || !owner_->stopped()) return;
      client_->say("{\"order\":\"abort\"}\n");
      given_up = true;
    };
    const Json first = run(more);
    on_cycle_ = {};
    ASSERT_EQ(code_of(first), "G701") << first.dump();
    for (int i = 0; i < 200; ++i) EXPECT_TRUE(owner_->idle());  // the button is up again
    EXPECT_EQ(first.value("board", ""), "begun");
    EXPECT_EQ(first.value("to_finish", ""), "--only corner");
    EXPECT_NE(first.value("said", "").find("cut            'corner'"), std::string::npos) << first.value("said", "");
    EXPECT_NE(first.value("said", "").find("short-board.yaml --only corner"), std::string::npos);
    ASSERT_TRUE(ask({{"order", "reset"}}).value("ok", false));
    EXPECT_EQ(remembered(), 1u);
  }
  void expect_refused(const Json& answer, const std::vector<std::string>& words) {
    EXPECT_EQ(code_of(answer), "G702") << answer.dump();
    EXPECT_EQ(answer.value("exit_code", 0), 7);
    EXPECT_EQ(answer.value("board", ""), "begun");
    for (const std::string& word : words)
      EXPECT_NE(answer.dump().find(word), std::string::npos) << word << answer.dump();
  }
  static void expect_whole(const Json& answer) {
    EXPECT_TRUE(answer.value("ok", false)) << answer.dump();
    EXPECT_EQ(answer.value("board", ""), "whole") << answer.dump();
    EXPECT_TRUE(answer["to_finish"].is_null());
  }

 private:
  std::optional<BegunParts> parts_;
  int id_ = 100;
};

TEST_F(APartThatIsCut, is_refused_and_made_whole_by_what_was_cut) {
  cut();
  const int stood = moved_at_;
  expect_refused(run(), {"the part in the machine was begun at 20", "1 of its 3 features", "--only corner",
                         "`gantry part-removed`"});
  EXPECT_EQ(moved_at_, stood) << "nothing has moved";
  EXPECT_EQ(run().value("said", "").find("VIRTUAL: the job failed before it began"), 0u) << "the owner's bus is up";
  EXPECT_EQ(code_of(run({{"only", {"cornr"}}})), "G901");
  EXPECT_EQ(code_of(run({{"only", "corner"}})), "G702") << "no list: not taken for all features";
  EXPECT_EQ(code_of(run({{"from", 3}})), "G702");
  expect_whole(run({{"only", {"corner"}}}));
  EXPECT_EQ(remembered(), 0u);
  expect_whole(run());
}

// Whatever is wrong with the order, something lies on the part.
TEST_F(APartThatIsCut, is_begun_in_each_answer_that_refuses_a_job) {
  cut({{"serial", "S1"}});
  for (const Json& more : {Json{{"only", {"nobody"}}}, Json{{"recipe", "/none.yaml"}}, Json{{"certificate", "/none"}},
                           Json{{"serrial", "S1"}}, Json{{"finish", true}, {"only", {"corner"}}}}) {
    Json order{{"serial", "S1"}};
    order.update(more);
    const Json refused = run(order);
    EXPECT_FALSE(refused.value("ok", true)) << more;
    EXPECT_EQ(refused.value("board", ""), "begun") << more << refused.dump();
  }
}

TEST_F(APartThatIsCut, is_finished_without_naming_what_it_lacks) {
  EXPECT_EQ(code_of(run({{"finish", true}})), "G702") << "nothing was begun";
  cut({{"serial", "S-1"}});
  const Json another = run({{"serial", "S-2"}, {"finish", true}});
  EXPECT_EQ(code_of(another), "G702") << another.dump();
  EXPECT_NE(another.dump().find("the clamp still holds the part with serial 'S-1'"), std::string::npos)
      << another.dump();
  EXPECT_EQ(code_of(run({{"serial", "S-1"}, {"finish", true}, {"only", {"b"}}})), "G901");
  EXPECT_EQ(code_of(run({{"serial", "S-1"}, {"finish", "yes"}})), "G702");
  const Json rest = run({{"serial", "S-1"}, {"finish", true}});
  expect_whole(rest);
  EXPECT_NE(rest.value("said", "").find("1 of 1 features"), std::string::npos) << rest.dump();
  EXPECT_EQ(remembered(), 0u);
}

/// An array of which every other dot is dispensed: the names of the rest would fill many lines.
TEST_F(APartThatIsCut, that_lacks_very_much_is_answered_in_few_words) {
  const std::string recipe = (folder_ / "many.yaml").string();
  {
    std::ifstream shipped(kShort);
    const std::string text{std::istreambuf_iterator<char>(shipped), {}};
    std::ofstream(recipe) << text
                          << "  - array: {name: many, material: adhesive, at: [20 mm, 5 mm], rows: 8, columns: 12, "
                             "pitch: [1.5 mm, 1.5 mm]}\n";
  }
  std::vector<std::string> some;
  for (int row = 0; row < 8; ++row)
    for (int column = row % 2; column < 12; column += 2) some.push_back(fmt::format("many[{}][{}]", row, column));
  const Json half = run({{"only", some}}, recipe);
  ASSERT_EQ(half.value("board", ""), "begun") << half.dump().substr(0, 2000);
  EXPECT_EQ(half.value("to_finish", ""), "--finish");
  EXPECT_LT(half.dump().size(), 4000u);
  EXPECT_LT(run(Json::object(), recipe).dump().size(), 4000u);
}

TEST_F(APartThatIsCut, stays_begun_when_only_something_else_is_dispensed) {
  cut();
  const Json again = run({{"only", {"b"}}});
  EXPECT_TRUE(again.value("ok", false)) << "what was asked for is done: " << again.dump();
  EXPECT_EQ(again.value("board", ""), "begun");
  EXPECT_EQ(again.value("to_finish", ""), "--only corner");
  EXPECT_TRUE(clamped()) << "it lacks something: nobody has asked for it";
  expect_refused(run({{"serial", "Z1"}}), {"the part in the machine", "say `gantry part-removed` when"});
  expect_whole(run({{"only", {"corner"}}}));
  EXPECT_FALSE(clamped());
}

TEST_F(APartThatIsCut, is_another_one_when_it_was_taken_out) {
  cut();
  const Json out = ask({{"order", "part_removed"}});
  EXPECT_TRUE(out.value("ok", false)) << out.dump();
  EXPECT_NE(out.value("said", "").find("is not waited for any more"), std::string::npos) << out.dump();
  EXPECT_EQ(remembered(), 0u);
  const Json unknown = ask({{"order", "part_removed"}, {"serial", "S-7"}});
  EXPECT_NE(unknown.value("said", "").find("no part with serial 'S-7' was begun"), std::string::npos) << unknown.dump();
  expect_whole(run());
}

TEST_F(APartThatIsCut, is_known_by_its_serial_wherever_it_has_been) {
  cut({{"serial", "S/1"}});
  expect_refused(run({{"serial", "S/1"}}),
                 {"the part with serial 'S/1'", "--only corner", "part-removed --serial S/1"});
  expect_refused(run(), {"the part with serial 'S/1'"});  // the clamp has not opened: it is in the machine
  for (const Json& more : {Json::object(), Json{{"only", {"corner"}}}}) {
    Json order{{"serial", "S/2"}};
    order.update(more);
    const Json over = run(order);
    EXPECT_EQ(code_of(over), "G702") << over.dump();
    for (const char* word : {"holds the part with serial 'S/1'", "this job is for 'S/2'", "`gantry part-removed`",
                             "--only corner --serial S/1"})
      EXPECT_NE(over.dump().find(word), std::string::npos) << word << over.dump();
    EXPECT_EQ(over.value("board", ""), "untouched");
    EXPECT_TRUE(over["to_finish"].is_null()) << over.dump();
  }
  ASSERT_TRUE(owner_->part_removed());  // a hand opens the clamp
  expect_whole(run({{"serial", "S/2"}}));
  expect_whole(run());  // the clamp has opened, and nobody says what lies there
  expect_refused(run({{"serial", "S/1"}}), {"1 of its 3 features"});
  std::string text;
  {
    std::ifstream file(kShort);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::ofstream(folder_ / "short-board.yaml") << text + "\n# changed\n";
  expect_refused(run({{"serial", "S/1"}, {"only", {"corner"}}}, folder_ / "short-board.yaml"),
                 {"this recipe as it was before it was changed"});
  expect_whole(run({{"serial", "S/1"}, {"only", {"corner"}}}));
  expect_whole(run({{"serial", "S/1"}}));
}

// Begun without a serial, it has one from the first job on that names it.
TEST_F(APartThatIsCut, is_of_the_serial_that_takes_it_up) {
  cut();
  EXPECT_NE(code_of(run({{"serial", "A"}, {"only", {"b"}}})), "G702");
  EXPECT_EQ(remembered(), 1u);
  for (const Json& more : {Json{{"finish", true}}, Json{{"only", {"corner"}}}}) {
    Json order{{"serial", "B"}};
    order.update(more);
    const Json over = run(order);
    EXPECT_EQ(code_of(over), "G702") << over.dump();
    EXPECT_NE(over.dump().find("holds the part with serial 'A'"), std::string::npos) << over.dump();
  }
  expect_whole(run({{"serial", "A"}, {"finish", true}}));
  EXPECT_EQ(remembered(), 0u);
}

TEST_F(APartThatIsCut, is_remembered_before_its_first_shot_and_a_lost_one_asks_for_eyes) {
  bool seen_before_valve = false, valve = false;
  std::filesystem::path copy = folder_ / "lost";
  on_cycle_ = [&] {
    if (valve || (owner_->latest().outputs & config::bit(config::Output::Valve)) == 0) return;
    valve = true;
    seen_before_valve = remembered() == 1;
    std::filesystem::copy(kept(), copy);  // what a disk holds when the power fails here
  };
  cut();
  EXPECT_TRUE(valve);
  EXPECT_TRUE(seen_before_valve);
  EXPECT_EQ(began_in(kept()), began_in(copy)) << "when its job began, not when it ended";
  std::filesystem::remove_all(kept());
  std::filesystem::copy(copy, kept());
  for (const char* clamp : {"closed", "open, as after a power cut"}) {
    expect_refused(run(), {"nobody saw how far it came", "--from FEATURE or --only FEATURES"});
    ASSERT_TRUE(owner_->part_removed()) << clamp;  // not by an order: nobody says that it is out
  }
  const Json finish = run({{"finish", true}});
  EXPECT_EQ(code_of(finish), "G702") << finish.dump();
  EXPECT_EQ(finish.value("board", ""), "begun");
  for (const char* word : {"nobody saw how far it came", "--from FEATURE or --only FEATURES",
                           "or say `gantry part-removed` when it is taken out"})
    EXPECT_NE(finish.dump().find(word), std::string::npos) << word << finish.dump();
  const Json rest = run({{"from", "b"}});
  EXPECT_TRUE(rest.value("ok", false)) << rest.dump();
  EXPECT_EQ(rest.value("board", ""), "begun") << "nobody has seen 'a'";
  expect_refused(run(), {"a job on it was lost, and nobody saw what of `--only a` lies there"});
  EXPECT_TRUE(rest.at("to_finish").is_null())
      << "and no command is given that might dispense it twice: " << rest.dump();
}

/// Its owner was killed in the job: it may still lie in the machine, whatever the next serial says.
TEST_F(APartThatIsCut, whose_owner_was_killed_is_not_dispensed_over_for_another_serial) {
  std::filesystem::path copy = folder_ / "lost";
  bool valve = false;
  on_cycle_ = [&] {
    if (valve || (owner_->latest().outputs & config::bit(config::Output::Valve)) == 0) return;
    valve = true;
    std::filesystem::copy(kept(), copy);  // what a killed program leaves here
  };
  cut({{"serial", "S/1"}});
  ASSERT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  std::filesystem::remove_all(kept());
  std::filesystem::copy(copy, kept());
  const int stood = moved_at_;
  for (const Json& more : {Json::object(), Json{{"finish", true}}, Json{{"only", {"corner"}}}}) {
    Json order{{"serial", "S/2"}};
    order.update(more);
    const Json over = run(order);
    EXPECT_EQ(code_of(over), "G702") << over.dump();
    for (const char* word : {"the part with serial 'S/1'", "may still be in the machine", "nobody saw how far it came",
                             "this job is for 'S/2'", "say `gantry part-removed` when it is taken out",
                             "--from FEATURE or --only FEATURES and --serial S/1"})
      EXPECT_NE(over.dump().find(word), std::string::npos) << word << over.dump();
  }
  EXPECT_EQ(moved_at_, stood);
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  expect_whole(run({{"serial", "S/2"}}));
}

/// While the part is written down the machine is served: an abort that comes then is none that meets a job.
TEST_F(APartThatIsCut, is_not_begun_by_a_job_that_is_aborted_while_it_is_written_down) {
  bool sent = false;
  on_cycle_ = [&] {
    if (!sent && remembered() > 0) sent = client_->say("{\"order\":\"abort\",\"id\":2}\n") > 0;
  };
  const int stood = moved_at_;
  const Json answer = run();
  EXPECT_TRUE(sent);
  EXPECT_EQ(code_of(answer), "G701") << answer.dump();
  EXPECT_EQ(answer.value("board", ""), "untouched");
  EXPECT_EQ(moved_at_, stood);
  EXPECT_EQ(remembered(), 0u);
}

/// The clamp opens when a job ends `done` and by `part_removed`: until then nobody dispenses over a finished part.
class APartWithDefects : public APartThatIsCut {
 protected:
  [[nodiscard]] std::string script() const override { return ""; }
  void SetUp() override {
    APartThatIsCut::SetUp();
    on_cycle_ = [this] {
      if (!slowed_ && (owner_->latest().outputs & config::bit(config::Output::Valve)) != 0)
        slowed_ = client_->say("{\"order\":\"override\",\"value\":0.2}\n") > 0;
    };
    first_ = run(first());
    ASSERT_EQ(first_.value("result", ""), "done_with_defects") << first_.dump();
    EXPECT_TRUE(ask({{"order", "override"}, {"value", 1}}).value("ok", false));
  }
  /// Of its first job.
  [[nodiscard]] virtual Json first() const { return Json::object(); }
  Json first_;

 private:
  bool slowed_ = false;
};

/// One feature of it was dispensed too slowly, the others were not.
class APartBegunWithADefect : public APartWithDefects {
  [[nodiscard]] Json first() const override { return {{"only", {"corner"}}}; }
};

TEST_F(APartBegunWithADefect, is_not_done_by_what_finishes_it) {
  const std::string told = first_.value("said", "");
  EXPECT_NE(told.find("'corner'"), std::string::npos) << first_.dump();
  EXPECT_EQ(first_.value("board", ""), "begun");
  const Json rest = run({{"finish", true}});
  EXPECT_EQ(rest.value("result", ""), "done_with_defects") << rest.dump();
  EXPECT_EQ(rest.value("exit_code", -1), 9) << rest.dump();
  EXPECT_EQ(rest.value("board", ""), "defects") << rest.dump();
  EXPECT_NE(rest.dump().find("'corner': by a job before: "), std::string::npos) << rest.dump();
  EXPECT_TRUE(clamped());
}

TEST_F(APartWithDefects, stays_clamped_and_no_job_begins_over_it_until_it_is_removed) {
  EXPECT_TRUE(clamped());
  EXPECT_NE(first_.value("said", "").find("`gantry part-removed` opens it"), std::string::npos) << first_.dump();
  const int stood = moved_at_;
  const Json refused = run();
  EXPECT_EQ(code_of(refused), "G702") << refused.dump();
  EXPECT_NE(refused.dump().find("say `gantry part-removed` to open the clamp"), std::string::npos) << refused.dump();
  EXPECT_EQ(refused.value("board", ""), "defects");
  EXPECT_EQ(moved_at_, stood);
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  EXPECT_FALSE(clamped());
  expect_whole(run());
}

/// What the refusal of --finish names is a way that works.
TEST_F(APartWithDefects, lacks_nothing_that_could_be_finished) {
  const int stood = moved_at_;
  const Json refused = run({{"finish", true}});
  EXPECT_EQ(code_of(refused), "G702") << refused.dump();
  for (const char* word : {"has all its features", "say `gantry part-removed` to open the clamp", "--only"})
    EXPECT_NE(refused.dump().find(word), std::string::npos) << word << refused.dump();
  EXPECT_EQ(refused.dump().find("leave '--finish' out"), std::string::npos) << "that is refused, too";
  EXPECT_EQ(refused.value("board", ""), "defects");
  EXPECT_EQ(moved_at_, stood);
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  const Json none = run({{"finish", true}});
  EXPECT_EQ(code_of(none), "G702") << none.dump();
  EXPECT_NE(none.dump().find("no part was begun and not finished; leave '--finish' out"), std::string::npos);
  expect_whole(run());
}

TEST_F(APartWithDefects, may_get_a_feature_once_more) {
  const Json again = run({{"only", {"b"}}});
  EXPECT_NE(code_of(again), "G702") << again.dump();
  EXPECT_NE(again.value("said", "").find("once more      'b'"), std::string::npos) << again.dump();
  EXPECT_EQ(again.value("board", ""), "defects") << again.dump();
  EXPECT_TRUE(again["to_finish"].is_null()) << again.dump();
}

TEST_F(APartWithDefects, is_another_one_than_that_of_a_serial_only_when_both_have_serials) {
  EXPECT_EQ(code_of(run({{"serial", "S/1"}})), "G702");
  EXPECT_TRUE(ask({{"order", "part_removed"}, {"serial", "S/1"}}).value("ok", false));
  expect_whole(run({{"serial", "S/1"}}));
}

TEST_F(APartWithDefects, with_a_serial_is_not_dispensed_over_for_another_one) {
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  bool slowed = false;
  on_cycle_ = [&] {
    if (!slowed && (owner_->latest().outputs & config::bit(config::Output::Valve)) != 0)
      slowed = client_->say("{\"order\":\"override\",\"value\":0.2}\n") > 0;
  };
  ASSERT_EQ(run({{"serial", "S/1"}}).value("result", ""), "done_with_defects");
  on_cycle_ = {};
  EXPECT_TRUE(ask({{"order", "override"}, {"value", 1}}).value("ok", false));
  const int stood = moved_at_;
  const Json unknown = ask({{"order", "part_removed"}, {"serial", "S/7"}});
  EXPECT_NE(unknown.dump().find("the clamp stays as it is: the part in the machine is 'S/1'"), std::string::npos)
      << unknown.dump();
  EXPECT_TRUE(clamped());
  const Json over = run({{"serial", "S/2"}});
  EXPECT_EQ(code_of(over), "G702") << over.dump();
  EXPECT_NE(over.dump().find("holds the part with serial 'S/1'"), std::string::npos) << over.dump();
  EXPECT_EQ(moved_at_, stood);
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  expect_whole(run({{"serial", "S/2"}}));
}

TEST_F(APartThatIsCut, whose_file_cannot_be_read_is_not_run_over) {
  cut();
  std::ofstream(kept() / "part.json") << "{\"format\": 1, \"left\": [[5, 99999999999]]}";
  for (const Json& more :
       {Json::object(), Json{{"finish", true}}, Json{{"only", {"corner"}}}, Json{{"only", {"no"}}}}) {
    const Json answer = run(more);
    EXPECT_FALSE(answer.value("ok", true)) << answer.dump();
    EXPECT_EQ(answer.value("board", ""), "begun") << "something lies on it" << answer.dump();
  }
  const Json answer = run();
  EXPECT_EQ(code_of(answer), "G405") << answer.dump();
  EXPECT_NE(answer.dump().find("part.json"), std::string::npos);
}

// What one lacks that was begun without a serial it lacks for a job of any.
TEST_F(APartThatIsCut, without_a_serial_is_told_to_jobs_of_every_serial) {
  cut();
  for (const Json& more : {Json::object(), Json{{"only", {"no"}}}, Json{{"recipe", "/none.yaml"}}}) {
    Json order{{"serial", "X"}};
    order.update(more);
    EXPECT_EQ(run(order).value("board", ""), "begun") << order;
  }
}

}  // namespace
}  // namespace gantry::desk
