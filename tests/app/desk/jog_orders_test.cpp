// A jog goes on as long as its client speaks.
#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

TEST_F(Desks, a_jog_goes_on_while_its_client_speaks) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"10 mm\"},\"speed\":\"20 mm/s\"}\n");
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  const double before = owner_->latest().target[0];
  serve_until(2);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_NEAR(owner_->latest().target[0] - before, 10, 1e-6);
}

TEST_F(Desks, a_jog_that_goes_slower_than_it_was_asked_for_says_so) {
  home();
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"10 mm\"},\"speed\":\"1e9 mm/s\"}\n");
  serve_until(2);
  EXPECT_EQ(answer(2).value("slowed", ""),
            "no faster than 26.8889 mm/s, because axis X would else not stand within 100 ms of its client's last word")
      << answer(2).dump();
  EXPECT_NE(answer(2).value("said", "").find("; no faster than 26.8889 mm/s"), std::string::npos) << answer(2).dump();
  client_->say("{\"order\":\"jog\",\"id\":3,\"by\":{\"X\":\"1 mm\"},\"speed\":\"20 mm/s\"}\n");
  serve_until(3);
  EXPECT_FALSE(answer(3).contains("slowed")) << answer(3).dump();
}

TEST_F(Desks, a_jog_ends_when_its_client_is_silent) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"100 mm\"},\"speed\":\"20 mm/s\"}\n");
  int last_word = 0;
  const int begin = steps_;
  on_cycle_ = [&] {
    if (steps_ % 25 != 0 || steps_ > begin + 1000) return;
    client_->say("{\"order\":\"status\",\"id\":9}\n");
    last_word = steps_;
  };
  const double before = owner_->latest().target[0];
  serve_until(2, 500);
  EXPECT_EQ(code_of(answer(2)), "G701") << heard_;
  EXPECT_NE(answer(2).dump().find("silent for 36 ms"), std::string::npos);
  EXPECT_GT(owner_->latest().target[0], before + 5);
  EXPECT_LE(moved_at_ - last_word, 100) << "it stands within 100 ms";
  EXPECT_GT(moved_at_ - last_word, 36);
}

TEST_F(Desks, a_jog_ends_when_its_client_is_gone) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"100 mm\"},\"speed\":\"20 mm/s\"}\n");
  const int begin = steps_;
  int gone = 0;
  on_cycle_ = [&] {
    if (steps_ < begin + 500 && steps_ % 25 == 0) client_->say("{\"order\":\"status\"}\n");
    if (gone == 0 && steps_ == begin + 500) client_.reset(), gone = steps_;
    if (steps_ == begin + 1500) Peer(folder_ / "owner.sock").say("{\"order\":\"quit\"}\n");
  };
  EXPECT_TRUE(desk_->serve());
  EXPECT_GT(moved_at_, gone);
  EXPECT_LE(moved_at_ - gone, 40);
}

}  // namespace
}  // namespace gantry::desk
