// A hold that arrives behind an order that moves axes holds what that order begins, though the hold is taken first: the
// machine stands, says so, and goes on with a resume. Judged by the axes' targets alone.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

struct Row {
  const char* name;
  const char* order;     ///< without its id; "": the machine's start button
  bool is_long = false;  ///< an abort ends it when it is seen to go on
};
constexpr Row kMotions[] = {
    {"a jog", R"("order":"jog","by":{"X":"5 mm","Y":"3 mm"},"speed":"50 mm/s")"},
    {"parking", R"("order":"park")"},
    {"homing", R"("order":"home")"},
    {"homing of some axes", R"("order":"home","only":["C","U"])"},
    {"a job", R"("order":"run","recipe":"RECIPE","out":"OUT","force":true)", true},
    {"the start button", "", true},
};
/// By whom the hold comes, and what stands between.
enum class From { SamePacket, LaterClient, EarlierClient, LongLine };
constexpr std::pair<From, const char*> kWays[] = {{From::SamePacket, "in the same packet"},
                                                  {From::LaterClient, "from a client that came later"},
                                                  {From::EarlierClient, "from a client that came earlier"},
                                                  {From::LongLine, "with twenty questions before the motion"}};
constexpr int kWithin = 60;    ///< cycles: parking and jogs brake within 40
constexpr int kWatched = 600;  ///< cycles in which nothing may move, and of them on hold with the owner:
constexpr int kHeld = 300;

class HoldBehind : public Desks {
 protected:
  void SetUp() override {
    Desks::SetUp();
    std::filesystem::current_path(folder_);  // the start button's results go to out/ where the owner stands
    later_ = std::make_unique<Peer>(folder_ / "owner.sock");
    middle_ = std::make_unique<Peer>(folder_ / "owner.sock");
  }
  void TearDown() override {
    std::filesystem::current_path(source_);
    Desks::TearDown();
  }
  [[nodiscard]] std::string line(const Row& row, int id) const {
    std::string text = "{" + std::string(row.order) + ",\"id\":" + std::to_string(id) + "}\n";
    const auto put = [&](std::string_view word, const std::string& by) {
      if (const auto at = text.find(word); at != std::string::npos) text.replace(at, word.size(), by);
    };
    put("RECIPE", source_ / kShort);
    put("OUT", folder_ / "job");
    return text;
  }
  static std::string order(const char* what, int id) {
    return std::string("{\"order\":\"") + what + "\",\"id\":" + std::to_string(id) + "}\n";
  }
  /// What has no id nobody asks for again.
  void hear() {
    for (const auto& peer : {later_.get(), middle_.get()}) {
      const std::string all = peer->hear();
      for (std::size_t at = 0; at < all.size();) {
        const std::size_t end = std::min(all.find('\n', at), all.size() - 1) + 1;
        const std::string one = all.substr(at, end - at);
        if (one.find("\"id\":") != std::string::npos) heard_ += one;
        at = end;
      }
    }
  }
  [[nodiscard]] bool start_pressed() const {
    return (owner_->latest().inputs & config::bit(config::Input::Start)) != 0;
  }
  /// Says both so that the owner reads them in one turn.
  void say(const Row& row, From from, int motion, int hold) {
    const std::string moves = line(row, motion), holds = order("hold", hold);
    std::string questions;
    for (int i = 0; i < 20; ++i) questions += "{\"order\":\"status\"}\n";
    switch (from) {
      case From::SamePacket: middle_->say(moves + holds); break;
      case From::LaterClient: middle_->say(moves), later_->say(holds); break;
      case From::EarlierClient: middle_->say(moves), client_->say(holds); break;
      case From::LongLine: middle_->say(questions + moves), later_->say(holds); break;
    }
  }
  /// `id` of the motion; those behind it are of the hold, of the resume, and of the abort that ends what goes on.
  void judge(const Row& row, From from, int id) {
    const bool button = *row.order == '\0';
    const auto pressed = [&] { return owner_->world()->add_script("{do: press, input: start, hold: 100 ms}"); };
    ASSERT_TRUE(!button || pressed().has_value());
    AxisVec before = owner_->latest().target;
    int said = 0, resumed = 0, moved = 0, beyond = 0, held = 0;
    bool gone_on = false;
    const auto moves = [&] {
      const bool yes = owner_->latest().target != std::exchange(before, owner_->latest().target);
      return yes || owner_->latest().state == cycle::State::Homing || owner_->latest().state == cycle::State::Running;
    };
    on_cycle_ = [&] {
      hear();
      if (steps_ % 20 == 0) middle_->say("{\"order\":\"status\"}\n");  // the sign of life of a jog
      const bool moving = moves();
      if (said == 0) {
        if (button && !start_pressed()) return;
        said = steps_;
        if (button)
          later_->say(order("hold", id + 1));
        else
          say(row, from, id, id + 1);
        return;
      }
      if (resumed == 0) {
        moved += moving;
        if (steps_ - said > kWithin) beyond += moving;
        held += owner_->held();
        if (steps_ - said < kWatched || held < kHeld) return;  // a job is prepared as fast as the host can
        resumed = steps_;
        later_->say(order("resume", id + 2));
      } else if (moving && !std::exchange(gone_on, true) && row.is_long) {
        later_->say(order("abort", id + 3));
      }
    };
    const int last = row.is_long ? id + 3 : id;
    serve_until(last);
    EXPECT_TRUE(answer(id + 1).value("ok", false)) << "the hold is told as it is: " << answer(id + 1).dump();
    EXPECT_EQ(beyond, 0) << "it stands";
    EXPECT_LT(moved, kWithin);
    EXPECT_GE(held, kHeld);
    EXPECT_TRUE(answer(id + 2).value("ok", false)) << answer(id + 2).dump();
    EXPECT_TRUE(gone_on) << "the resume lets it go on";
    EXPECT_TRUE(answer(last).value("ok", false)) << answer(last).dump();
  }

  std::unique_ptr<Peer> later_, middle_;
};

TEST_F(HoldBehind, whatever_moves_axes_stands_until_a_resume) {
  home();
  int id = 100;
  for (const auto& [from, way] : kWays)
    for (const Row& row : kMotions) {
      SCOPED_TRACE(std::string(row.name) + ", " + way);
      client_->hear(), heard_.clear();
      judge(row, from, id += 10);
    }
}

/// An abort and a hold that come behind the start button in one turn: its job has not begun.
TEST_F(HoldBehind, an_abort_in_the_turn_in_which_the_start_button_is_seen_is_not_undone) {
  home();
  ASSERT_TRUE(owner_->world()->add_script("{do: press, input: start, hold: 100 ms}").has_value());
  bool said = false, ran = false;
  on_cycle_ = [&] {
    if (!said && start_pressed()) said = client_->say(order("abort", 2)) > 0;
    ran = ran || owner_->undertaking() == run::Undertaking::Job;
  };
  serve_until(2, 3000);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_FALSE(ran);
}

/// Who is told that an abort was taken sees nothing move afterwards that was asked for before it was told.
TEST_F(HoldBehind, a_start_button_that_is_pressed_before_an_abort_is_answered_begins_nothing) {
  home();
  int id = 2;
  for (const int behind : {1, 7, 40}) {  // cycles; an abort is answered after 10
    SCOPED_TRACE(behind);
    const int aborted = id++, last = id++;
    int said = 0;
    bool pressed = false, asked = false, ran = false;
    on_cycle_ = [&] {
      if (said == 0) said = client_->say(order("abort", aborted)) > 0 ? steps_ : 0;
      if (!pressed && steps_ >= said + behind)
        pressed = owner_->world()->add_script("{do: press, input: start, hold: 100 ms}").has_value();
      ran = ran || owner_->undertaking() == run::Undertaking::Job;  // its recipe is read on another thread
      if (!asked && steps_ > said + 600 && ran == (behind > 10)) asked = client_->say(order("abort", last)) > 0;
    };
    serve_until(last, 600);
    EXPECT_TRUE(answer(aborted).value("ok", false)) << answer(aborted).dump();
    EXPECT_EQ(ran, behind > 10);
  }
}

/// Nor does a hold that was taken end by a button that was pressed before anybody was told.
TEST_F(HoldBehind, a_start_button_that_is_pressed_before_a_hold_is_answered_does_not_resume) {
  home();
  int id = 2;
  for (const int behind : {1, 7, 60}) {  // cycles; a hold is answered after 10
    SCOPED_TRACE(behind);
    const int jog = id++, held = id++, gone_on = id++;
    const double before = owner_->latest().target[0];
    int said = 0;
    bool pressed = false, asked = false;
    client_->say(line(kMotions[0], jog));
    on_cycle_ = [&] {
      if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":99}\n");
      if (said == 0 && owner_->latest().target[0] > before + 1)
        said = client_->say(order("hold", held)) > 0 ? steps_ : 0;
      if (said == 0) return;
      if (!pressed && steps_ >= said + behind)
        pressed = owner_->world()->add_script("{do: press, input: start, hold: 100 ms}").has_value();
      if (!asked && steps_ > said + 500) asked = client_->say(order("resume", gone_on)) > 0;
    };
    serve_until(jog);
    EXPECT_TRUE(answer(held).value("ok", false)) << answer(held).dump();
    EXPECT_EQ(asked, behind <= 10) << "it stood until somebody asked";
    EXPECT_TRUE(answer(jog).value("ok", false)) << answer(jog).dump();
  }
}

/// It asked for the motion before it asked for the hold, though the hold is taken first.
TEST_F(HoldBehind, a_resume_ahead_of_a_hold_does_not_undo_it_and_one_behind_it_does) {
  home();
  client_->say("{\"order\":\"park\",\"id\":2}\n" + order("hold", 3) + order("resume", 4));
  serve_until(2);
  EXPECT_TRUE(answer(3).value("ok", false)) << answer(3).dump();
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  client_->say(line(kMotions[0], 12));
  const double before = owner_->latest().target[0];
  int held = 0;
  bool asked = false;
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":99}\n");
    if (held == 0 && !asked && owner_->latest().target[0] > before + 1) asked = client_->say(order("hold", 13)) > 0;
    if (!owner_->held()) return;
    ++held;
    if (held == 200) client_->say(order("resume", 14) + order("hold", 15));
    if (held == 600) client_->say(order("resume", 16));
  };
  serve_until(12);
  EXPECT_EQ(code_of(answer(14)), "G702") << answer(14).dump();
  EXPECT_NE(answer(14).dump().find("a hold came behind it"), std::string::npos) << answer(14).dump();
  EXPECT_TRUE(answer(15).value("ok", false)) << answer(15).dump();
  EXPECT_GE(held, 600);
  EXPECT_TRUE(answer(16).value("ok", false)) << answer(16).dump();
  EXPECT_TRUE(answer(12).value("ok", false)) << answer(12).dump();
}

/// What stands on hold goes on, and what was held back in the line is free, too.
TEST_F(HoldBehind, a_resume_lets_go_what_stands_and_what_waits_in_line) {
  home();
  client_->say(line(kMotions[0], 2));
  int since = 0;
  on_cycle_ = [&] {
    hear();
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":99}\n");
    if (since == 0 && owner_->latest().state != cycle::State::Running) return;
    if (++since == 1) say(kMotions[1], From::LongLine, 3, 4);
    if (since == 15) later_->say(order("resume", 5));
  };
  serve_until(2);
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
  EXPECT_TRUE(answer(5).value("ok", false)) << answer(5).dump();
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_EQ(code_of(answer(3)), "G702") << "one at a time: " << answer(3).dump();
  on_cycle_ = [&] {
    hear();
    if (since == 0) return;
    if (since++ == 1000) say(kMotions[1], From::LongLine, 13, 14);
    if (since == 1005) later_->say(order("resume", 15));
  };
  since = 999;
  serve_until(13);
  EXPECT_NE(answer(14).dump().find("'park' waits before its first motion"), std::string::npos) << answer(14).dump();
  EXPECT_NE(answer(15).dump().find("'park' begins when it is taken"), std::string::npos) << answer(15).dump();
  EXPECT_TRUE(answer(13).value("ok", false)) << answer(13).dump();
}

/// Drives home by themselves.
TEST_F(HoldBehind, one_of_what_is_homing_is_refused_as_it_is_whatever_waits_in_line) {
  client_->say(order("home", 2));
  bool said = false;
  on_cycle_ = [&] {
    hear();
    if (!said && owner_->latest().state == cycle::State::Homing) said = true, say(kMotions[1], From::LongLine, 3, 4);
  };
  serve_until(2);
  EXPECT_EQ(code_of(answer(4)), "G702") << answer(4).dump();
  EXPECT_NE(answer(4).dump().find("cannot be held; `abort` ends it"), std::string::npos) << answer(4).dump();
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
}

/// Ctrl-Z in one client (gantry run, park) must not stop what another one has ordered.
TEST_F(HoldBehind, one_that_is_for_its_own_orders_alone_leaves_others_alone) {
  home();
  const std::string mine = R"({"order":"hold","now":true,"mine":true,"id":)";
  client_->say(line(kMotions[0], 2));
  bool said = false;
  int held = 0;
  on_cycle_ = [&] {
    hear();
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":99}\n");
    if (!said && owner_->latest().state == cycle::State::Running) said = later_->say(mine + "3}\n") > 0;
    held += owner_->held();
  };
  serve_until(2);
  EXPECT_EQ(code_of(answer(3)), "G702") << answer(3).dump();
  EXPECT_NE(answer(3).dump().find("nothing that this connection has ordered"), std::string::npos);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_EQ(held, 0);

  client_->say("{\"order\":\"park\",\"id\":4}\n" + mine + "5}\n");
  later_->say(mine + "6}\n");
  on_cycle_ = [&] {
    hear();
    if (!owner_->held()) return;
    ++held;
    if (held == 300) client_->say(mine + "7}\n");
    if (held == 400) later_->say(order("resume", 8));
  };
  serve_until(4);
  EXPECT_TRUE(answer(5).value("ok", false)) << answer(5).dump();
  EXPECT_EQ(code_of(answer(6)), "G702") << answer(6).dump();
  EXPECT_TRUE(answer(7).value("ok", false)) << "held already: " << answer(7).dump();
  EXPECT_GE(held, 400);
  EXPECT_TRUE(answer(8).value("ok", false)) << answer(8).dump();
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
}

}  // namespace
}  // namespace gantry::desk
