// Every refusal, as an operator reads it: orders by states, and by what is under way. Whether an order is taken is told
// here once more, from docs/owner-socket.md, so that no refusal proposes what is refused itself.
#include "app/run/refusal.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <set>

namespace gantry::run {
namespace {

using cycle::State;

bool moves_by_itself(const Standing& s) {
  return s.undertaking == Undertaking::Jog || s.undertaking == Undertaking::Park || s.undertaking == Undertaking::Job ||
         s.undertaking == Undertaking::Walk;
}

/// As docs/operating.md says of a hold before the first motion.
bool waits_on_hold(const Standing& s) {
  return s.undertaking == Undertaking::Jog || s.undertaking == Undertaking::Park || s.undertaking == Undertaking::Job ||
         s.undertaking == Undertaking::Home;
}

bool taken(OrderKind order, const Standing& s) {
  const bool idle = s.undertaking == Undertaking::None;
  const bool stands = s.state == State::Ready || s.state == State::Disabled;
  switch (order) {
    case OrderKind::Status:
    case OrderKind::Abort:
    case OrderKind::Quit: return true;
    case OrderKind::PartRemoved: return s.on_bus && idle;
    case OrderKind::Disable: return s.on_bus && idle && (stands || s.state == State::Stopped);
    case OrderKind::Enable:
    case OrderKind::Home:
    case OrderKind::Jog:
    case OrderKind::Park:
    case OrderKind::Run: return s.on_bus && idle && stands;
    case OrderKind::Hold:
    case OrderKind::Override:
      if (!s.on_bus || s.aborting) return false;
      if (s.state == State::Running || s.state == State::Holding || s.state == State::Held || s.held) return true;
      if (s.undertaking == Undertaking::Job && s.state == State::Homing) return true;
      return waits_on_hold(s) && (stands || s.state == State::Enabling);
    case OrderKind::Resume: return s.held && !s.stopped && !s.aborting;
    case OrderKind::Reset:
      if (!s.on_bus || s.aborting) return false;
      if (idle) return stands || s.state == State::Stopped || s.state == State::Held || s.state == State::Offline;
      return s.undertaking == Undertaking::Job && s.held && (s.state == State::Held || s.state == State::Stopped);
  }
  return false;
}

/// What there can be at all.
bool possible(const Standing& s) {
  const bool idle = s.undertaking == Undertaking::None;
  if (!s.on_bus)
    return s.state == State::Offline && !s.held && !s.stopped && !s.aborting &&
           (idle || s.undertaking == Undertaking::BringUp);
  if (idle && (s.held || s.stopped || s.aborting)) return false;
  if (s.held && !moves_by_itself(s) && !waits_on_hold(s)) return false;
  if (s.undertaking == Undertaking::Home && (s.state == State::Held || s.state == State::Holding)) return false;
  if ((s.state == State::Held || s.state == State::Holding) && !s.held) return false;
  if (s.stopped && (s.undertaking != Undertaking::Job || !s.held)) return false;
  if (s.stopped && s.state != State::Stopped && s.state != State::Stopping) return false;
  return !(s.stopped && s.aborting);
}

std::vector<Standing> standings() {
  std::vector<Standing> all;
  for (std::size_t state = 0; state < cycle::kStates; ++state)
    for (int what = 0; what <= static_cast<int>(Undertaking::Walk); ++what)
      for (int bits = 0; bits < 16; ++bits) {
        const Standing s{.state = static_cast<State>(state),
                         .undertaking = static_cast<Undertaking>(what),
                         .on_bus = (bits & 1) == 0,
                         .held = (bits & 2) != 0,
                         .stopped = (bits & 4) != 0,
                         .aborting = (bits & 8) != 0};
        if (possible(s)) all.push_back(s);
      }
  return all;
}

/// The orders in backticks.
std::vector<std::string> proposed(const std::string& words) {
  std::vector<std::string> out;
  for (auto open = words.find('`'); open != std::string::npos; open = words.find('`', open)) {
    const auto shut = words.find('`', open + 1);
    if (shut == std::string::npos) break;
    out.push_back(words.substr(open + 1, shut - open - 1));
    open = shut + 1;
  }
  return out;
}

TEST(Refusal, names_what_was_asked_for_the_state_and_what_may_be_done_and_proposes_nothing_that_is_refused) {
  std::set<std::string> read;
  int pairs = 0;
  for (const Standing& s : standings())
    for (const std::string_view order_name : order_names()) {
      const OrderKind order = *order_named(order_name);
      if (taken(order, s)) continue;
      ++pairs;
      const std::string words = refusal(order, s);
      read.insert(words);
      EXPECT_TRUE(words.starts_with(fmt::format("'{}' is refused: the machine is ", order_name))) << words;
      EXPECT_NE(words.find(cycle::name(s.state)), std::string::npos) << words;
      if (s.undertaking != Undertaking::None) {
        EXPECT_NE(words.find(in_quotes(s.undertaking)), std::string::npos) << words;
      }
      const auto what_to_do = words.rfind("; ");
      ASSERT_NE(what_to_do, std::string::npos) << words;
      const std::string rest = words.substr(what_to_do);
      EXPECT_TRUE(rest.find('`') != std::string::npos || rest.find("wait") != std::string::npos ||
                  rest.find("give the order again when") != std::string::npos ||
                  rest.find("give the order again") != std::string::npos || rest.ends_with("nothing has to be done") ||
                  rest.ends_with("by themselves"))
          << words;
      const auto orders = proposed(words);
      for (std::size_t i = 0; i < orders.size(); ++i) {
        const auto kind = order_named(orders[i]);
        ASSERT_TRUE(kind) << words;
        const bool behind_another = words.find("then `" + orders[i]) != std::string::npos ||
                                    words.find("and `" + orders[i] + "` is taken") != std::string::npos;
        EXPECT_TRUE(behind_another || taken(*kind, s)) << orders[i] << " is refused there itself: " << words;
        EXPECT_TRUE(behind_another || *kind != order) << words;
      }
    }
  EXPECT_GT(pairs, 500);
  for (const std::string& words : read)
    for (const char* nonsense : {"`park`", "`jog`", "`home`", "`part_removed`", "; ;", ",,", ";,"})
      EXPECT_EQ(words.find(nonsense), std::string::npos) << words;
  if (std::getenv("GANTRY_SHOW_REFUSALS") != nullptr)
    for (const std::string& words : read) fmt::print("{}\n", words);
}

TEST(Refusal, reads_well_in_the_situations_that_operators_meet) {
  using enum OrderKind;
  EXPECT_EQ(
      refusal(Hold, {.state = State::Ready}),
      "'hold' is refused: the machine is ready, and nothing is under way that could be held; nothing has to be done");
  EXPECT_EQ(refusal(Run, {.state = State::Running, .undertaking = Undertaking::Park}),
            "'run' is refused: the machine is busy with 'park' (running); wait for its end, or `abort` it");
  EXPECT_EQ(refusal(PartRemoved, {.state = State::Held, .undertaking = Undertaking::Job, .held = true}),
            "'part_removed' is refused: the machine is busy with 'run' (held), which is on hold; `resume` goes on, "
            "`abort` ends it");
  EXPECT_EQ(refusal(Resume, {.state = State::Stopped, .undertaking = Undertaking::Job, .held = true, .stopped = true}),
            "'resume' is refused: the machine is busy with 'run' (stopped), which a fault has stopped; `status` names "
            "it: `reset`, then `resume` goes on");
  EXPECT_EQ(refusal(Hold, {.state = State::Homing, .undertaking = Undertaking::Home}),
            "'hold' is refused: the machine is busy with 'home' (homing), which cannot be held; `abort` ends it");
  EXPECT_EQ(refusal(Reset, {.state = State::Running, .undertaking = Undertaking::Job}),
            "'reset' is refused: the machine is busy with 'run' (running), and a reset is for a machine that stands; "
            "wait for its end, or `abort` it");
  EXPECT_EQ(refusal(Undertaking::Walk, {.state = State::Running, .undertaking = Undertaking::Jog}),
            "a walk is refused: the machine is busy with 'jog' (running); wait for its end, or `abort` it");
}

}  // namespace
}  // namespace gantry::run
