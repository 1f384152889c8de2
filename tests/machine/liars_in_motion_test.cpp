// Stations that are what they say while nothing moves: what they do with a mode, a load, a stop or a flood of messages
// later is not what the manuals have. The machine works as well, or it is refused by name (mutated.hpp), and no axis
// sinks meanwhile.
#include <utility>

#include "tests/altered.hpp"
#include "tests/machine/mutated.hpp"

namespace gantry::test {
namespace {

using config::ObjectAddress;
using sim::MailboxLies;
using sim::StationHabits;

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

MailboxLies::Shown shown_byte(ObjectAddress address, std::uint8_t value) {
  return {address, {static_cast<std::byte>(value)}};
}

TEST(LiarsInMotion, by_script_and_by_two_lies_at_once) {
  using Twice = MailboxLies::Twice;
  const Lie lies[] = {
      {"each answer twice, and in segments",
       "x",
       {.mailbox = {.twice = Twice::NewCounter, .in_segments = true}},
       {},
       {"station 1 'x'", "1018h", "no segment"}},
      {"each answer twice, an emergency before it",
       "y2",
       {.mailbox = {.twice = Twice::SameCounter, .emergency_first = true}},
       by_sdo},
      {"its counter is always 0", "cu", {.mailbox = {.counter = 0}}, by_sdo},
      {"its mailbox gets slow while it homes",
       "x",
       {},
       by_sdo,
       {"axis X", "station 1 'x'", "another mode"},
       "- {at: cycle 1500, do: slow_mailbox, station: x, by: 900 ms}"},
      {"6060h is not heeded any more",
       "z",
       {},
       by_sdo,
       {"axis Z", "station 4 'z'", "another mode"},
       "- {at: cycle 1500, do: ignore_writes, station: z, object: 0x6060}"},
      {"6060h cannot be written",
       "z",
       {.mailbox = {.aborts = MailboxLies::Abort{{0x6060, 0}, 0x08000022, false, true}}},
       by_sdo,
       {"station 4 'z'", "6060h", "08000022h"}},
      {"6061h is 1 by SDO",
       "y1",
       {.mailbox = {.shows = shown_byte({0x6061, 0}, 1)}},
       by_sdo,
       {"axis Y", "station 2 'y1'", "another mode"}},
      {"6098h reads as asked and is another method",
       "x",
       {.mailbox = {.shows = shown_byte({0x6098, 0}, 17)}, .ignores = ObjectAddress{0x6098, 0}},
       [](auto& m) {
         object(m, "x", {0x6098, 0}).initial = 18;
       },
       {"axis X", "limit switch"}},
      {"it is held while it homes",
       "x",
       {},
       {},
       {"axis X", "station 1 'x'", "position deviation", "mechanics"},
       "- {at: cycle 1500, do: stall, axis: X}"},
      {"its beam is held while it homes",
       "y1",
       {},
       {},
       {"axis Y", "station 2 'y1'", "position deviation"},
       "- {at: cycle 2500, do: stall, axis: Y}"},
      {"its brake does not hold", "z", {}, {}, {}, "- {do: slip_brake, axis: Z, speed: -5 mm/s}"},
      {"another master sends", "x", {}, {}, {}, "- {at: cycle 1500, do: foreign_frames, count: 500}"},
      {"remote never shows", "y2", {.lies = {.status_never = 0x0200}}},
      {"a warning always shows", "x", {.lies = {.status_always = 0x0080}}},
      {"quick stop always shows", "z", {.lies = {.status_never = 0x0020}}, {}, {"axis Z", "station 4 'z'", "0211h"}},
      {"its emergency input is met while it homes",
       "x",
       {},
       {},
       {"axis X", "station 1 'x'", "release the emergency stop"},
       "- {at: cycle 1500, do: drive_fault, axis: X, code: 0x0400}"},
      {"it does not enter PRE_OP",
       "y1",
       {.refuses = StationHabits::Refusal{devices::wire::AlState::PreOp, 0x0011}},
       {},
       {"station 2 'y1'", "PRE_OP", "0011h"}},
      {"four habits at once",
       "cu",
       {.needs_eeprom = true, .assignment_fixed = true, .even_pdos = true, .no_information = true}},
      {"a load of 0.4 mm on one side of the beam", "y2", {.lies = {.load = 400}}, {}, {"axis Y", "apart"}},
      {"its own fault in homing",
       "cu",
       {},
       {},
       {"axis C", "station 5 'cu'", "under-voltage", "motor supply"},
       "- {at: cycle 1500, do: drive_fault, axis: C, code: 0x3220}"},
      {"its motor turns the other way",
       "x",
       {},
       [](auto& m) {
         m.axes[0].drives[0].invert ^= true;
         auto& facts = *station(m, "x").profile.drive;
         std::swap(facts.input_neg_limit, facts.input_pos_limit);
       },
       {"axis X", "limit switch"}},
      {"its home switch is closed from far within the travel",
       "cu",
       {},
       [](auto& m) { m.sim.axes[3].home_switch = 3.2; },
       {"axis C", "reference switch"}},
      {"its home switch is closed for half of a short travel",
       "cu",
       {},
       [](auto& m) { m.sim.axes[4].home_switch = 20, m.sim.axes[4].start = 2; },
       {"axis U", "reference switch"}},
      {"6064h counts twice, and its mode shows late",
       "z",
       {.lies = {.position_factor = 2, .mode_shown_after = 90}},
       {},
       {"axis Z", "faster in homing"}},
  };
  for (const Lie& lie : lies) expect_as_well_or_refused(lie);
}

/// The drive's mode alone does not tell why it is another one.
TEST(LiarsInMotion, what_is_set_by_sdo_while_the_loop_runs_and_is_not_taken_is_named) {
  const Outcome silent = expect_as_well_or_refused({"its mailbox is silent while it homes",
                                                    "x",
                                                    {},
                                                    by_sdo,
                                                    {"axis X", "another mode"},
                                                    "- {at: cycle 1500, do: slow_mailbox, station: x, by: 6 s}"});
  EXPECT_NE(silent.said.find("station 1 'x': 6060h is set by SDO, and that failed: writing"), std::string::npos)
      << silent.said;
  const Outcome deaf = expect_as_well_or_refused({"6060h is not heeded any more",
                                                  "z",
                                                  {},
                                                  by_sdo,
                                                  {"axis Z", "another mode"},
                                                  "- {at: cycle 1500, do: ignore_writes, station: z, object: 0x6060}"});
  EXPECT_NE(deaf.said.find("station 4 'z': 6060h is set by SDO, and that failed: writing"), std::string::npos)
      << deaf.said;
  EXPECT_NE(deaf.said.find("was acknowledged, and it holds"), std::string::npos) << deaf.said;
}

}  // namespace
}  // namespace gantry::test
