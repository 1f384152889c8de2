// The owner's socket with many clients in one process: time is an argument, and what is judged is counted in turns.
#include "app/desk/order_socket.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <sys/stat.h>
#include <unistd.h>

#include "app/desk/order_line.hpp"
#include "tests/app/desk/peer.hpp"

namespace gantry::desk {
namespace {

using namespace std::chrono_literals;
using run::OrderKind;
using test::Peer;

class Sockets : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("gantry-door-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    auto door = OrderSocket::listen(path());
    ASSERT_TRUE(door) << to_text(door.error());
    door_ = std::move(*door);
  }
  void TearDown() override {
    door_.reset();
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] std::string path() const { return folder_ / "owner.sock"; }
  std::unique_ptr<Peer> peer() const { return std::make_unique<Peer>(path()); }
  static bool is(const OrderSocket::Incoming& in, OrderKind kind) {
    return in.request.order && in.request.order->kind == kind;
  }
  /// One turn, in which every line is answered, `times` over.
  std::vector<OrderSocket::Incoming> turn(std::size_t times = 1) {
    now_ += 1ms;
    auto lines = door_->turn(now_);
    for (const auto& in : lines)
      for (std::size_t i = 0; i < times; ++i) door_->reply(in.client, "answer to it");
    return lines;
  }
  static std::size_t count(const std::string& text, std::string_view what) {
    std::size_t n = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
    return n;
  }

  std::filesystem::path folder_;
  std::unique_ptr<OrderSocket> door_;
  Time now_ = 1s;
};

const std::string kStatus = R"({"order":"status"})"
                            "\n";
const std::string kAbort = R"({"order":"abort"})"
                           "\n";

TEST_F(Sockets, a_flood_of_one_client_delays_nobody_and_is_answered_line_by_line) {
  const auto fast = peer(), other = peer();
  std::size_t sent = 0, answered = 0, refused = 0;
  std::string cut;
  for (int i = 0; i < 2000; ++i) {
    for (std::size_t n = 1; n > 0 && sent < 40'000 + static_cast<std::size_t>(i);) {
      std::string text = cut.empty() ? kStatus : cut;
      n = other->connected() ? fast->say(text) : 0;
      cut = n < text.size() ? text.substr(n) : "";
      if (n > 0 && cut.empty()) ++sent;
    }
    if (i == 1000) other->say(kAbort);
    const auto lines = turn();
    EXPECT_LE(lines.size(), 2u);
    if (i == 1000) {
      ASSERT_FALSE(lines.empty());
      EXPECT_TRUE(is(lines.front(), OrderKind::Abort)) << "an abort is the first thing of the turn in which it arrives";
    }
    const std::string heard = fast->hear();
    answered += count(heard, "answer to");
    refused += count(heard, "G702");
    ASSERT_EQ(count(heard, "<end>"), 0u) << "who reads its answers is not dropped";
  }
  for (int i = 0; i < 100; ++i) {
    turn();
    const std::string heard = fast->hear();
    answered += count(heard, "answer to"), refused += count(heard, "G702");
  }
  EXPECT_EQ(answered + refused, sent) << "every line has one answer";
  EXPECT_GE(answered, 2000u);
}

TEST_F(Sockets, an_abort_waits_neither_behind_other_clients_nor_behind_lines_of_its_own) {
  std::vector<std::unique_ptr<Peer>> peers;
  for (std::size_t i = 0; i < OrderSocket::kMostClients; ++i) peers.push_back(peer());
  for (const auto& p : peers)
    for (int i = 0; i < 30; ++i) p->say(kStatus);
  peers.back()->say(kAbort);
  const auto lines = turn();
  ASSERT_GT(lines.size(), 1u);
  EXPECT_TRUE(is(lines.front(), OrderKind::Abort));
  EXPECT_LE(lines.size(), 1 + OrderSocket::kLinesPerTurn);
  std::map<std::uint64_t, int> of_client;
  for (std::size_t i = 1; i < lines.size(); ++i) ++of_client[lines[i].client];
  for (const auto& [client, n] : of_client) EXPECT_EQ(n, 1);
}

/// Of several kinds each is the last word of its client.
TEST_F(Sockets, an_abort_does_not_wait_behind_a_hold_of_its_client_either) {
  const auto p = peer();
  p->say(R"({"order":"hold"})"
         "\n");
  for (int i = 0; i < 20; ++i) p->say(kStatus);
  p->say(kAbort);
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(is(lines[0], OrderKind::Hold));
  EXPECT_TRUE(is(lines[1], OrderKind::Abort));
  EXPECT_LT(lines[0].number, lines[2].number);
  EXPECT_LT(lines[2].number, lines[1].number) << "the question stood between them";
}

TEST_F(Sockets, of_what_several_clients_say_at_once_a_stop_counts_as_the_later_one) {
  const auto first = peer(), second = peer(), third = peer();
  turn();
  first->say(kStatus);
  second->say(kStatus + kAbort + kStatus);
  third->say(kStatus);
  const std::uint64_t before = door_->number();
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 4u);
  ASSERT_TRUE(is(lines[0], OrderKind::Abort));
  for (std::size_t i = 1; i < lines.size(); ++i) EXPECT_LT(lines[i].number, lines[0].number);
  const auto behind = turn();
  ASSERT_EQ(behind.size(), 1u);
  EXPECT_GT(behind[0].number, lines[0].number) << "what its client said behind it is later";
  EXPECT_LT(behind[0].number, door_->number());
  for (const auto& in : lines) EXPECT_GE(in.number, before);
}

TEST_F(Sockets, a_line_too_many_is_refused_by_its_name) {
  const auto p = peer();
  for (int i = 0; i < 50; ++i) p->say("{\"order\":\"status\",\"id\":" + std::to_string(i) + "}\n");
  turn();
  const std::string told = p->hear();
  EXPECT_EQ(count(told, "G702"), 18u);
  for (int i = 32; i < 50; ++i)
    EXPECT_EQ(count(told, "\"order\":\"status\",\"id\":" + std::to_string(i) + "}\n"), 1u) << i << "\n" << told;
}

TEST_F(Sockets, who_is_gone_is_known_also_while_lines_of_it_are_unread) {
  const auto p = peer(), half = peer();
  std::string all;
  for (int i = 0; i < 3000; ++i) all += kStatus;
  p->say(all);
  half->say(kStatus);
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 2u);
  half->send_no_more();
  EXPECT_FALSE(door_->hung_up(lines[0].client));
  EXPECT_FALSE(door_->hung_up(lines[1].client)) << "it waits for its answers";
  EXPECT_TRUE(door_->heard(lines[0].client));
  EXPECT_FALSE(door_->heard(lines[1].client));
  p->hang_up();
  EXPECT_TRUE(door_->hung_up(lines[0].client));
  EXPECT_FALSE(door_->heard(lines[0].client));
}

/// It may have been stopped, or have died of something, right behind a burst: what is read later was not said later.
TEST_F(Sockets, a_client_was_heard_when_its_words_arrived_and_not_when_they_were_read) {
  const auto p = peer();
  p->say(kStatus);
  const std::uint64_t client = turn().at(0).client;
  const std::size_t burst = p->say(std::string(150'000, '\n'));
  ASSERT_GT(burst, 100'000u);
  turn();
  const Time arrived = now_;
  int turns = 0;
  for (; turns < 10; ++turns) {
    turn();
    EXPECT_EQ(door_->heard(client), arrived);
  }
  p->say("\n");  // still behind what is unread
  turn();
  const Time later = now_;
  for (; turns < 200; ++turns) turn();
  EXPECT_EQ(door_->heard(client), later);
  p->say(kStatus);
  turn();
  EXPECT_EQ(door_->heard(client), now_);
}

TEST_F(Sockets, clients_take_turns) {
  std::vector<std::unique_ptr<Peer>> peers;
  for (std::size_t i = 0; i < OrderSocket::kMostClients; ++i) peers.push_back(peer());
  for (const auto& p : peers)
    for (int i = 0; i < 20; ++i) p->say(kStatus);
  std::map<std::uint64_t, std::size_t> served;
  for (std::size_t i = 0; i < 20; ++i)
    for (const auto& in : turn()) ++served[in.client];
  ASSERT_EQ(served.size(), peers.size());
  for (const auto& [client, n] : served) {
    EXPECT_GE(n, 9u);  // 20 turns of 8 lines among 16
    EXPECT_LE(n, 11u);
  }
}

TEST_F(Sockets, sixteen_idle_connections_lock_nobody_out) {
  std::vector<std::unique_ptr<Peer>> idle;
  for (std::size_t i = 0; i < OrderSocket::kMostClients; ++i) {
    idle.push_back(peer());
    turn();
  }
  idle.front()->say(kStatus);  // the first has spoken: the second is now the one that was silent for longest
  turn();
  idle.front()->hear();
  const auto late = peer();
  late->say(kAbort);
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(is(lines.front(), OrderKind::Abort));
  EXPECT_NE(late->hear().find("answer to"), std::string::npos);
  const std::string told = idle[1]->hear();
  EXPECT_NE(told.find("idle for longest"), std::string::npos) << told;
  EXPECT_NE(told.find(R"("ok":false)"), std::string::npos) << told;
  EXPECT_EQ(count(told, "<end>"), 1u);
  EXPECT_EQ(idle.front()->hear(), "");
}

TEST_F(Sockets, who_makes_room_is_not_one_whose_line_has_just_come) {
  std::vector<std::unique_ptr<Peer>> all;
  for (std::size_t i = 0; i < OrderSocket::kMostClients; ++i) {
    all.push_back(peer());
    turn();
    now_ += 1ms;
  }
  all.front()->say(kStatus);  // silent for longest, until now
  const auto late = peer();
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 1u) << "it is not lost";
  EXPECT_TRUE(is(lines.front(), OrderKind::Status));
  EXPECT_NE(all.front()->hear().find("answer to"), std::string::npos);
  EXPECT_NE(all[1]->hear().find("idle for longest"), std::string::npos);
}

TEST_F(Sockets, a_client_with_an_order_under_way_keeps_its_place_and_who_is_refused_is_told_why) {
  std::vector<std::unique_ptr<Peer>> busy;
  for (std::size_t i = 0; i < OrderSocket::kMostClients; ++i) {
    busy.push_back(peer());
    busy.back()->say(kStatus);
    const auto lines = turn();
    ASSERT_EQ(lines.size(), 1u);
    door_->set_busy(lines.front().client, true);
  }
  const auto late = peer();
  turn();
  const std::string told = late->hear();
  EXPECT_NE(told.find("every place is taken"), std::string::npos) << told;
  EXPECT_EQ(count(told, "\n"), 1u);
  EXPECT_EQ(count(told, "<end>"), 1u);
  now_ += 10min;
  turn();
  EXPECT_EQ(door_->clients(), OrderSocket::kMostClients) << "a job may last longer than an idle connection may";
}

TEST_F(Sockets, an_idle_connection_is_dropped_after_a_minute_also_one_that_sends_half_lines) {
  const auto silent = peer(), slow = peer(), lively = peer();
  for (int s = 0; s < 62; ++s) {
    slow->say("x");
    lively->say(kStatus);
    now_ += 1s;
    turn();
    lively->hear();
  }
  EXPECT_EQ(door_->clients(), 1u);
  for (const Peer* dropped : {silent.get(), slow.get()}) {
    const std::string told = dropped->hear();
    EXPECT_NE(told.find("idle"), std::string::npos) << told;
    EXPECT_EQ(count(told, "<end>"), 1u);
  }
}

TEST_F(Sockets, a_long_answer_comes_whole_to_a_client_that_reads_slowly) {
  const auto slow = peer();
  slow->say(kStatus);
  now_ += 1ms;
  const auto lines = door_->turn(now_);
  ASSERT_EQ(lines.size(), 1u);
  const std::string long_answer(250'000, 'x');  // more than the system buffers for a socket
  door_->reply(lines.front().client, long_answer);
  std::string all;
  for (int i = 0; i < 100 && all.size() < long_answer.size() + 1; ++i) {
    all += slow->hear();
    turn();
  }
  EXPECT_EQ(all, long_answer + "\n");
}

TEST_F(Sockets, who_never_reads_loses_its_connection_and_its_abort_is_heard_all_the_same) {
  const auto deaf = peer(), other = peer();
  int heard = 0, others = 0;
  for (int i = 0; i < 3000; ++i) {
    deaf->say(kStatus);
    if (i == 100) deaf->say(kAbort);
    if (i % 10 == 0) other->say(kStatus);
    for (const auto& in : turn(200)) heard += is(in, OrderKind::Abort);
    others += static_cast<int>(count(other->hear(), "answer to")) / 200;
  }
  EXPECT_EQ(heard, 1);
  EXPECT_EQ(others, 300);
  EXPECT_EQ(door_->clients(), 1u);
}

TEST_F(Sockets, a_line_of_64_KiB_is_one_order_and_a_longer_one_is_refused) {
  for (const std::size_t length : {kLongestLine, kLongestLine + 1}) {
    const auto p = peer();
    const std::string order = R"({"order":"status"})";
    const std::string line = order + std::string(length - order.size(), ' ') + "\n";
    std::size_t sent = 0, got = 0;
    std::string told;
    for (int i = 0; i < 100 && count(told, "<end>") == 0; ++i) {
      sent += p->say(std::string_view(line).substr(sent));
      for (const auto& in : door_->turn(now_ += 1ms)) got += is(in, OrderKind::Status);
      told += p->hear();
    }
    if (length == kLongestLine) {
      EXPECT_EQ(got, 1u);
    } else {
      EXPECT_EQ(got, 0u);
      EXPECT_NE(told.find("64 KiB"), std::string::npos) << told;
      EXPECT_EQ(count(told, "<end>"), 1u);
    }
  }
}

TEST_F(Sockets, who_sends_no_more_still_hears_its_answers) {
  const auto p = peer();  // as `echo ... | socat - UNIX:...` does
  p->say(kStatus + kStatus);
  p->send_no_more();
  turn();
  turn();
  turn();
  const std::string told = p->hear();
  EXPECT_EQ(count(told, "answer to"), 2u);
  EXPECT_EQ(count(told, "<end>"), 1u);
  EXPECT_EQ(door_->clients(), 0u);
}

TEST_F(Sockets, a_client_is_heard_of_until_it_closes) {
  const auto p = peer();
  p->say(kStatus);
  const auto lines = turn();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(door_->heard(lines.front().client), now_);
  const Time before = now_;
  turn();
  EXPECT_EQ(door_->heard(lines.front().client), before);
  p->hang_up();
  turn();
  EXPECT_FALSE(door_->heard(lines.front().client));
}

TEST_F(Sockets, any_mixture_of_clients_is_served_in_bounded_turns) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto chance = [&](unsigned of) { return random() % of == 0; };
  struct One {
    std::unique_ptr<Peer> peer;
    unsigned kind = 0;
  };
  std::vector<One> ones;
  for (int i = 0; i < 4000; ++i) {
    if (ones.size() < 24 && chance(8)) ones.push_back({peer(), static_cast<unsigned>(random() % 6)});
    for (One& one : ones) switch (one.kind) {
        case 0: one.peer->say(kStatus), one.peer->hear(); break;                                      // fast
        case 1: chance(50) && one.peer->say(kStatus), one.peer->hear(); break;                        // slow
        case 2: break;                                                                                // silent
        case 3: one.peer->say(R"({"order")"); break;                                                  // half lines
        case 4: one.peer->say(std::string(random() % 70'000, 'z') + (chance(2) ? "\n" : "")); break;  // long ones
        default: one.peer->say(std::string(random() % 300, static_cast<char>(random()))); break;      // garbage, deaf
      }
    Peer* aborting = nullptr;
    if (!ones.empty() && chance(20))
      if (One& one = ones[random() % ones.size()]; one.kind <= 2 && one.peer->hear().find("<end>") == std::string::npos)
        aborting = one.peer->say(kAbort) == kAbort.size() ? one.peer.get() : nullptr;
    const auto lines = turn();
    EXPECT_LE(lines.size(), OrderSocket::kLinesPerTurn + OrderSocket::kMostClients);
    EXPECT_LE(door_->clients(), OrderSocket::kMostClients);
    if (aborting != nullptr) {
      ASSERT_FALSE(lines.empty()) << "turn " << i;
      EXPECT_TRUE(is(lines.front(), OrderKind::Abort)) << "turn " << i;
    }
    std::erase_if(
        ones, [&](const One& one) { return chance(300) || (one.kind <= 1 && count(one.peer->hear(), "<end>") > 0); });
  }
}

TEST_F(Sockets, three_thousand_lines_at_once_are_answered_or_the_connection_ends) {
  const auto p = peer();
  std::string all, told;
  for (int i = 0; i < 3000; ++i) all += kStatus;
  std::size_t sent = 0;
  for (int i = 0; i < 200; ++i) {
    if (sent < all.size()) sent += p->say(std::string_view(all).substr(sent));
    turn();
    if (count(told, "<end>") == 0) told += p->hear();
  }
  const std::size_t answers = count(told, "answer to") + count(told, "G702");
  EXPECT_GT(answers, 100u);
  EXPECT_TRUE(count(told, "<end>") == 1 ? door_->clients() == 0 : answers == 3000) << answers;
}

TEST_F(Sockets, a_second_owner_is_refused_and_the_first_unharmed) {
  const auto second = OrderSocket::listen(path());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().fault, Fault::SecondOwner);
  const auto p = peer();
  p->say(kStatus);
  EXPECT_EQ(turn().size(), 1u);
}

TEST_F(Sockets, a_link_that_stands_for_the_lock_is_not_followed) {
  const auto target = folder_ / "victim", planted = folder_ / "planted.sock.lock";
  std::filesystem::create_symlink(target, planted);
  const auto door = OrderSocket::listen(folder_ / "planted.sock");
  ASSERT_FALSE(door);
  EXPECT_FALSE(std::filesystem::exists(target));
}

TEST_F(Sockets, only_its_user_may_connect) {
  struct stat found {};
  ASSERT_EQ(stat(path().c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777u, 0600u);
}

TEST_F(Sockets, one_may_be_open_to_a_group_and_is_found_in_the_state_folder_too) {
  const auto mode = [](const std::string& file) {
    struct stat found {};
    return stat(file.c_str(), &found) == 0 ? found.st_mode & 0777u : 0u;
  };
  EXPECT_EQ(mode(path()), 0600u) << "of one that is not shared";
  const std::string shared = folder_ / "run.sock", state = folder_ / "state.sock", other = folder_ / "other.sock";
  auto door = OrderSocket::listen(state, shared);
  ASSERT_TRUE(door) << to_text(door.error());
  EXPECT_EQ(mode(shared), 0660u);
  EXPECT_TRUE(std::filesystem::is_symlink(state));
  EXPECT_TRUE(Peer(shared).connected());
  EXPECT_TRUE(Peer(state).connected());
  for (const auto& [mine, theirs] : {std::pair{other, shared}, {state, other}}) {
    const auto second = OrderSocket::listen(mine, theirs);
    ASSERT_FALSE(second) << "another owner of the same state, or of the same socket";
    EXPECT_EQ(second.error().fault, Fault::SecondOwner);
  }
  EXPECT_TRUE(Peer(shared).connected()) << "a second owner takes nothing away";
  EXPECT_TRUE(Peer(state).connected());
  door->reset();
  EXPECT_FALSE(std::filesystem::exists(shared));
  EXPECT_FALSE(std::filesystem::is_symlink(state));
  EXPECT_TRUE(OrderSocket::listen(state, shared)) << "its locks went with it";
}

}  // namespace
}  // namespace gantry::desk
