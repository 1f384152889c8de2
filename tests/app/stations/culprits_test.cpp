// Who a fault of the bus is about: asked of a bus whose stations are told what they have done.
#include "app/stations/culprits.hpp"

#include <gtest/gtest.h>

#include "tests/app/stations/told_bus.hpp"

namespace gantry::stations {
namespace {

constexpr std::uint64_t kLong = 100;  // cycles in which every station was looked at

cycle::Snapshot well() {
  cycle::Snapshot s;
  s.complete = s.operational = true;
  return s;
}

cycle::Event event(Fault fault, std::uint32_t id = 0) {
  return {.kind = cycle::EventKind::Fault, .fault = fault, .id = id};
}

TEST(Culprits, names_who_has_missed_cycles_since_all_was_well) {
  test::ToldBus bus{{"x", "y1", "y2"}};
  bus.row(0).presence.missed = 7;  // long ago
  Culprits culprits(bus);
  culprits.watch(well());
  culprits.ask(event(Fault::TooFewTookPart));
  bus.row(2).presence.missed = 1;
  bus.pass(kLong);
  const auto known = culprits.next();
  ASSERT_TRUE(known);
  EXPECT_EQ(known->event.fault, Fault::TooFewTookPart);
  EXPECT_EQ(known->where, "station 2 'y2'");
  EXPECT_EQ(known->what, "") << "it was not seen outside of OP";
  EXPECT_FALSE(culprits.next()) << "told once";
}

TEST(Culprits, waits_until_every_station_was_looked_at) {
  test::ToldBus bus{{"x", "y1"}};
  Culprits culprits(bus);
  culprits.watch(well());
  culprits.ask(event(Fault::StationSilent));
  EXPECT_TRUE(culprits.waiting(Fault::StationSilent));
  EXPECT_FALSE(culprits.waiting(Fault::StationLeftOp));
  bus.pass(bus.station_count());
  EXPECT_FALSE(culprits.next()) << "the last of them is asked about with the cycle after its own";
  bus.pass(kLong);
  EXPECT_TRUE(culprits.next());
  EXPECT_FALSE(culprits.waiting(Fault::StationSilent));
}

TEST(Culprits, a_loop_that_stands_brings_no_cycles_and_is_not_waited_for_for_ever) {
  test::ToldBus bus{{"x"}};
  Culprits culprits(bus);
  culprits.ask(event(Fault::StationSilent));
  int steps = 0;
  for (; steps < 10'000 && !culprits.next(); ++steps) culprits.watch({});
  EXPECT_LT(steps, 1000);
}

TEST(Culprits, says_in_which_state_it_was_seen) {
  test::ToldBus bus{{"x", "z"}};
  Culprits culprits(bus);
  culprits.watch(well());
  culprits.ask(event(Fault::StationLeftOp));
  bus.pass(kLong);
  bus.row(1).presence = {.missed = 0, .asked_at = kLong, .operational = false};
  bus.row(1).state = "in SAFE_OP: AL status code 001Bh";
  const auto known = culprits.next();
  ASSERT_TRUE(known);
  EXPECT_EQ(known->where, "station 1 'z'");
  EXPECT_EQ(known->what, "; station 1 'z' is in SAFE_OP: AL status code 001Bh");
}

TEST(Culprits, an_answer_of_long_ago_accuses_nobody) {
  test::ToldBus bus{{"x", "z"}};
  Culprits culprits(bus);
  culprits.watch(well());
  bus.row(1).presence = {.missed = 0, .asked_at = 1, .operational = false};
  bus.pass(10 * kLong);
  culprits.ask(event(Fault::StationLeftOp));
  bus.pass(kLong);
  const auto known = culprits.next();
  ASSERT_TRUE(known);
  EXPECT_EQ(known->where, "") << "over before it could be told who";
}

TEST(Culprits, names_four_and_counts_the_rest) {
  test::ToldBus bus{{"a", "b", "c", "d", "e", "f"}};
  Culprits culprits(bus);
  culprits.watch(well());
  culprits.ask(event(Fault::TooFewTookPart));
  for (std::size_t i = 0; i < bus.station_count(); ++i) bus.row(i).presence.missed = 1;
  bus.pass(kLong);
  const auto known = culprits.next();
  ASSERT_TRUE(known);
  EXPECT_EQ(known->where, "station 0 'a', station 1 'b', station 2 'c', station 3 'd' and 2 more");
}

TEST(Culprits, what_is_missed_while_it_waits_does_not_become_what_was_before) {
  test::ToldBus bus{{"x", "z"}};
  Culprits culprits(bus);
  culprits.watch(well());
  culprits.ask(event(Fault::TooFewTookPart, 1));
  bus.row(1).presence.missed = 2;
  culprits.watch(well());  // it takes part again at once
  culprits.ask(event(Fault::TooFewTookPart, 2));
  bus.pass(kLong);
  for (const std::uint32_t id : {1u, 2u}) {
    const auto known = culprits.next();
    ASSERT_TRUE(known);
    EXPECT_EQ(known->event.id, id) << "in the order in which they were asked";
    EXPECT_EQ(known->where, "station 1 'z'");
  }
}

TEST(Culprits, a_station_that_was_never_looked_at_is_nobody) {
  test::ToldBus bus{{"x"}};
  bus.row(0).looked_at = false;
  bus.row(0).presence.missed = 9;
  Culprits culprits(bus);
  culprits.ask(event(Fault::TooFewTookPart));
  bus.pass(kLong);
  const auto known = culprits.next();
  ASSERT_TRUE(known);
  EXPECT_EQ(known->where, "");
}

}  // namespace
}  // namespace gantry::stations
