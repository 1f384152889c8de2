// Orders that an owner finds when it has stood still or was busy, of clients that were killed or have fallen silent
// meanwhile: nothing moves for them.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

class AbsentClient : public Desks {
 protected:
  void SetUp() override {
    Desks::SetUp();
    home();
    client_->say("{\"order\":\"disable\",\"id\":2}\n");
    serve_until(2);
  }
  /// This program, and so its owner, gets no CPU for so long.
  void stand_still(Time span) { clock_.sleep_until(clock_.now() + span); }
  static constexpr const char* kJog = "{\"order\":\"jog\",\"by\":{\"X\":\"5 mm\"},\"speed\":\"50 mm/s\",\"id\":3}\n";
  static constexpr const char* kWord = "{\"order\":\"status\"}\n";
};

/// Nobody waits for it any more, and its client may have been killed so that it does not come about.
TEST_F(AbsentClient, what_takes_the_machine_is_not_begun_when_its_client_has_hung_up_before_it_was_taken) {
  const std::string job = R"({"order":"run","recipe":")" + (source_ / kShort).string() + R"(","out":")" +
                          (folder_ / "job").string() + "\"}\n";
  int id = 100;
  for (const std::string& order : {std::string(kJog), std::string("{\"order\":\"park\"}\n"),
                                   std::string("{\"order\":\"home\"}\n"), job, std::string("{\"order\":\"enable\"}\n")})
    for (const std::size_t words : {0u, 20u, 3000u}) {  // unread ones hide the end of the connection
      SCOPED_TRACE(order + std::to_string(words) + " lines behind it");
      std::string all = order;
      for (std::size_t i = 0; i < words; ++i) all += kWord;
      std::make_unique<Peer>(folder_ / "owner.sock")->say(all);
      bool begun = false;
      on_cycle_ = [&] { begun = begun || owner_->undertaking() != run::Undertaking::None; };
      client_->hear(), heard_.clear();
      client_->say("{\"order\":\"status\",\"id\":" + std::to_string(++id) + "}\n");
      serve_until(id, 120);
      EXPECT_FALSE(begun);
      EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
    }
}

TEST_F(AbsentClient, who_only_sends_no_more_is_still_there) {
  Peer half(folder_ / "owner.sock");
  half.say("{\"order\":\"park\",\"id\":3}\n");
  half.send_no_more();
  on_cycle_ = [&] { heard_ += half.hear(); };
  serve_until(3);
  EXPECT_TRUE(answer(3).value("ok", false)) << answer(3).dump();
}

/// Its order may be as old as the owner's stand-still: whether somebody is there now is told by its next word.
TEST_F(AbsentClient, a_jog_that_an_owner_finds_after_a_stand_still_begins_with_the_next_word_of_its_client) {
  for (const bool silent : {true, false}) {
    SCOPED_TRACE(silent ? "silent" : "speaking");
    client_->hear(), heard_.clear();
    const double before = owner_->latest().target[0];
    bool begun = false, said = false;
    int since = 0;
    on_cycle_ = [&] {
      if (!said) {
        said = client_->say(kJog) > 0;
        stand_still(std::chrono::seconds(2));
      }
      if (++since > 20 && !silent && since % 10 == 0) client_->say(kWord);
      begun = begun || owner_->undertaking() == run::Undertaking::Jog;
      EXPECT_FALSE(begun && since <= 20);
    };
    serve_until(3);
    EXPECT_EQ(begun, !silent);
    if (silent) {
      EXPECT_EQ(code_of(answer(3)), "G701") << answer(3).dump();
      EXPECT_EQ(owner_->latest().target[0], before);
      EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
    } else {
      EXPECT_TRUE(answer(3).value("ok", false)) << answer(3).dump();
      EXPECT_NEAR(owner_->latest().target[0], before + 5, 1e-6);
    }
  }
}

}  // namespace
}  // namespace gantry::desk
