#include "app/monitor/namesakes.hpp"

#include <gtest/gtest.h>

namespace gantry::monitor {
namespace {

TEST(Namesakes, two_sessions_that_take_turns_are_told_once) {
  Namesakes n;
  EXPECT_FALSE(n.heard(1));
  EXPECT_FALSE(n.heard(1));
  EXPECT_FALSE(n.heard(2)) << "may be the owner, started anew";
  EXPECT_EQ(n.heard(1), 2u) << "the first one still speaks";
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(n.heard(i % 2 == 0 ? 2 : 1));
}

TEST(Namesakes, an_owner_that_is_started_anew_is_one_machine) {
  Namesakes n;
  for (std::uint64_t session = 1; session < 100; ++session)
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(n.heard(session));
}

TEST(Namesakes, a_third_machine_is_told_too) {
  Namesakes n;
  n.heard(1), n.heard(2);
  EXPECT_TRUE(n.heard(1));
  EXPECT_FALSE(n.heard(3));
  EXPECT_EQ(n.heard(1), 3u);
  EXPECT_FALSE(n.heard(2)) << "told already";
  EXPECT_FALSE(n.heard(3));
}

TEST(Namesakes, the_words_name_sessions_hosts_and_the_remedy) {
  const auto words = namesake_words({"bench", 0xab, "left"}, {"bench", 0xcd, ""});
  for (const char* part : {"'bench'", "00000000000000ab", "host left", "00000000000000cd", "unknown host", "--name"})
    EXPECT_NE(words.find(part), std::string::npos) << words;
}

TEST(Announcement, comes_back_as_it_was) {
  for (const Speaker& s :
       {Speaker{"bench", 0x0123456789abcdef, "left"}, Speaker{"", 0, ""}, Speaker{"a;host=b;machine=c", ~0ull, "h"}}) {
    const auto back = announced(announcement(s));
    ASSERT_TRUE(back) << s.machine;
    EXPECT_EQ(back->machine, s.machine);
    EXPECT_EQ(back->session, s.session);
    EXPECT_EQ(back->host, s.host);
  }
}

TEST(Announcement, other_text_is_none) {
  const std::string whole = announcement({"bench", 17, "left"});
  for (std::size_t n = 0; n < whole.find("bench"); ++n) EXPECT_FALSE(announced(whole.substr(0, n))) << n;
  for (const char* text :
       {"", "typehash=RIHS01_a13e;", "gantry;session=12;host=a;machine=b",
        "gantry;session=zzzzzzzzzzzzzzzz;host=a;machine=b", "gantry;session=-00000000000001f;host=a;machine=b",
        "gantry;session=0000000000000001;machine=b;host=a"})
    EXPECT_FALSE(announced(text)) << text;
  const auto endless = announced("gantry;session=0000000000000001;host=" + std::string(70'000, 'h') + ";machine=b");
  ASSERT_TRUE(endless);
  EXPECT_LE(endless->host.size(), 64u);
}

}  // namespace
}  // namespace gantry::monitor
