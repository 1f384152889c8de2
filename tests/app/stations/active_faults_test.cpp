#include "app/stations/active_faults.hpp"

#include <gtest/gtest.h>

namespace gantry::stations {
namespace {

config::Machine with_inputs() {
  config::Machine machine;
  for (const auto input : {config::Input::SafetyOk, config::Input::Stop, config::Input::DoorClosed})
    machine.inputs[static_cast<std::size_t>(input)].emplace();
  return machine;
}

cycle::Snapshot latched(Fault fault, std::initializer_list<config::Input> high) {
  cycle::Snapshot s;
  s.latched = fault;
  for (const auto input : high) s.inputs |= config::bit(input);
  return s;
}

using config::Input;

TEST(ActiveFaults, NothingIsListedWhileNothingIsLatched) {
  EXPECT_TRUE(ActiveFaults().list(with_inputs(), latched(Fault::None, {})).empty());
}

TEST(ActiveFaults, TheLatchedOneIsFirstAndWhatIsOpenFollows) {
  const auto list = ActiveFaults().list(with_inputs(), latched(Fault::DriveFault, {Input::Stop}));
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].fault, Fault::DriveFault);
  EXPECT_EQ(list[1].fault, Fault::SafetyChainOpen);
  EXPECT_EQ(list[2].fault, Fault::DoorOpen);
}

TEST(ActiveFaults, AnOpenInterlockThatIsLatchedIsSaidOnce) {
  const auto pressed = latched(Fault::StopPressed, {Input::SafetyOk, Input::DoorClosed});
  const auto list = ActiveFaults().list(with_inputs(), pressed);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].message, info(Fault::StopPressed).text);
}

// An operator who reads "the stop button is pressed" after having released it looks for a second button.
TEST(ActiveFaults, AnInterlockThatIsClosedAgainSaysSo) {
  const auto released = latched(Fault::StopPressed, {Input::SafetyOk, Input::DoorClosed, Input::Stop});
  const auto list = ActiveFaults().list(with_inputs(), released);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].message, "the stop button is pressed - not any more");
}

}  // namespace
}  // namespace gantry::stations
