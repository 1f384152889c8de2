// Drives under load whose mode comes or shows late: the machine works as well, or it is refused by name (mutated.hpp),
// and no axis sinks meanwhile.
#include "tests/machine/mutated.hpp"

namespace gantry::test {
namespace {

constexpr double kSunk_mm = 0.02;  // that an axis under load may stand elsewhere: a few times the load

TEST(LiarsInMotion, modes_and_loads) {
  const Lie lies[] = {
      {"a load, mode at once", "z", {.lies = {.load = 3}}},
      {"a load, and a mode that comes 90 ms late", "z", {.lies = {.load = 3, .mode_delay = 90}}},
      {"a load, and a mode that shows 90 ms late", "z", {.lies = {.load = 3, .mode_shown_after = 90}}},
      {"a load, and a mode that comes 300 ms late",
       "z",
       {.lies = {.load = 3, .mode_delay = 300}},
       {},
       {"station 4 'z'"}},
      {"a load, and modes by SDO", "z", {.lies = {.load = 3}}, by_sdo},
      {"a load, and modes by SDO that come 300 ms late", "z", {.lies = {.load = 3, .mode_delay = 300}}, by_sdo},
      {"a load, modes by SDO that show 300 ms late", "z", {.lies = {.load = 3, .mode_shown_after = 300}}, by_sdo},
      {"one side of the beam with a load, by SDO",
       "y2",
       {.mailbox_delay = milliseconds(30), .lies = {.load = 3}},
       by_sdo},
      {"a load the other way", "z", {.lies = {.load = -3, .mode_shown_after = 90}}},
  };
  const double z_mm = drive([](config::Machine&) {}).z_mm;
  for (const Lie& lie : lies) {
    const Outcome out = expect_as_well_or_refused(lie);
    if (out.works) {
      EXPECT_NEAR(out.z_mm, z_mm, kSunk_mm) << lie.station << ": " << lie.what;
    }
  }
}

}  // namespace
}  // namespace gantry::test
