// Stations whose mailboxes, EEPROMs, states and drives are not what they say: the machine works as well, or it is
// refused by name. Each row alters the simulated machine alone, and is used as a person would (mutated.hpp, whose judge
// is the virtual world).
#include <span>

#include "tests/altered.hpp"
#include "tests/machine/eeprom.hpp"
#include "tests/machine/mutated.hpp"
#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry::test {
namespace {

using config::ObjectAddress;
using config::ObjectType;
using devices::wire::AlState;
using sim::MailboxLies;
using sim::StationHabits;
using Twice = MailboxLies::Twice;

void expect(std::span<const Lie> lies) {
  for (const Lie& lie : lies) expect_as_well_or_refused(lie);
}

auto of_type(const char* name, ObjectAddress address, ObjectType type) {
  return [=](config::Machine& m) { object(m, name, address).type = type; };
}
auto without(const char* name, std::uint16_t index) {
  return [=](config::Machine& m) { remove_object(station(m, name).profile, index); };
}
auto begins_with(const char* name, ObjectAddress address, std::int64_t value) {
  return [=](config::Machine& m) { object(m, name, address).initial = value; };
}
MailboxLies::Abort refuses_writes(ObjectAddress address, std::uint32_t code) { return {address, code, false, true}; }

MailboxLies::Shown shown(ObjectAddress address, std::uint32_t value) {
  std::vector<std::byte> bytes(4);
  for (int i = 0; i < 4; ++i) bytes[static_cast<std::size_t>(i)] = static_cast<std::byte>(value >> (8 * i));
  return {address, bytes};
}

/// Padding between the entries of a mapping that is fixed.
void padded(config::Machine& m) {
  auto& entries = station(m, "y2").profile.tx_pdos[0].entries;
  entries.insert(entries.begin() + 1, config::PdoEntry{{0, 0}, 8});
  entries.insert(entries.begin() + 3, config::PdoEntry{{0, 0}, 16});
}

TEST(Liars, mailboxes) {
  const Lie lies[] = {
      {"by SDO, one answers after 200 ms",
       "x",
       {.mailbox_delay = milliseconds(200)},
       by_sdo,
       {"axis X", "limit switches"}},
      {"by SDO, one answers after 30 ms", "y2", {.mailbox_delay = milliseconds(30)}, by_sdo},
      {"by SDO, one answers after 2 s",
       "y2",
       {.mailbox_delay = milliseconds(2000)},
       by_sdo,
       {"station 3 'y2'", "no reply"}},
      {"6060h by SDO never answers",
       "x",
       {.mailbox = {.silent_at = ObjectAddress{0x6060, 0}}},
       by_sdo,
       {"station 1 'x'", "6060h"}},
      {"each answer twice, under one counter", "x", {.mailbox = {.twice = Twice::SameCounter}}},
      {"each answer twice, under two counters, by SDO", "y2", {.mailbox = {.twice = Twice::NewCounter}}, by_sdo},
      {"its counter stands still", "y2", {.mailbox = {.counter = 5}}},
      {"an emergency before each answer, by SDO", "x", {.mailbox = {.emergency_first = true}}, by_sdo},
      {"no answer is expedited", "y2", {.mailbox = {.never_expedited = true}}},
      {"all answers in segments, by SDO", "x", {.mailbox = {.in_segments = true}}, by_sdo},
      {"segments out of turn",
       "x",
       {.mailbox = {.in_segments = true, .wrong_toggle = true}},
       {},
       {"station 1 'x'", "1018h", "out of turn"}},
      {"expedited without a size", "x", {.mailbox = {.no_size = true}}},
      {"expedited without a size, two axes, by SDO", "cu", {.mailbox = {.no_size = true}}, by_sdo},
      {"expedited without a size, which nothing but a number of 32 bits can be",
       "x",
       {.mailbox = {.no_size = true, .shows = shown({0x2102, 0}, 0x1157C)}},
       {},
       {"station 1 'x'", "2102h", "71036"}},
      {"no SDO information, and a fixed assignment", "y2", {.assignment_fixed = true, .no_information = true}},
      {"1C13h has a count that is not written in PRE_OP",
       "x",
       {.mailbox = {.aborts = refuses_writes({0x1C13, 0}, 0x08000022)}}},
      {"1A00h has a count that is not written", "y2", {.mailbox = {.aborts = refuses_writes({0x1A00, 0}, 0x06010002)}}},
      {"1C13h cannot be read",
       "x",
       {.mailbox = {.aborts = MailboxLies::Abort{{0x1C13, 0}, 0x06060000, true, false}}},
       {},
       {"station 1 'x'", "1C13h", "06060000h"}},
      {"an abort code that nobody knows",
       "x",
       {.mailbox = {.aborts = refuses_writes({0x6098, 0}, 0xDEADBEEF)}},
       {},
       {"station 1 'x'", "6098h", "17", "DEADBEEFh"}},
      {"6099h:1 is ignored",
       "y2",
       {.ignores = ObjectAddress{0x6099, 1}},
       {},
       {"station 3 'y2'", "6099h:1", "83333", "60000"}},
      {"all writes are ignored", "x", {.ignores = ObjectAddress{0, 0}}, {}, {"station 1 'x'", "1C12h"}},
      {"605Ah holds 0 and is ignored",
       "y2",
       {.ignores = ObjectAddress{0x605A, 0}},
       [](auto& m) {
         holds(m, "y2", {0x605A, 0}, 0);
       },
       {"station 3 'y2'", "605Ah", "reads back as 0, written was 2"}},
      {"605Ah is another one once the drive is enabled",
       "y2",
       {.lies = {.reverts = ObjectAddress{0x605A, 0}}},
       begins_with("y2", {0x605A, 0}, 0),
       {"station 3 'y2'", "605Ah", "is 0 since", "was 2"}},
      {"607Ch is another one once the drive is enabled",
       "x",
       {.lies = {.reverts = ObjectAddress{0x607C, 0}}},
       begins_with("x", {0x607C, 0}, 5000),
       {"station 1 'x'", "607Ch", "5000"}},
      {"6064h of 16 bits", "x", {}, of_type("x", {0x6064, 0}, ObjectType::I16), {"station 1 'x'", "6064h", "16 bits"}},
      {"6064h has no sign", "y2", {}, of_type("y2", {0x6064, 0}, ObjectType::U32)},
      {"6041h of 32 bits", "x", {}, of_type("x", {0x6041, 0}, ObjectType::U32)},
      {"no 2116h: its brake is not known", "z", {}, without("z", 0x2116), {"station 4 'z'", "2116h", "declared"}},
      {"no 605Ah", "y1", {}, without("y1", 0x605A), {"station 2 'y1'", "605Ah", "declared"}},
      {"1018h says another product",
       "y2",
       {.mailbox = {.shows = shown({0x1018, 2}, 0x402)}},
       {},
       {"station 3 'y2'", "1018h", "00000402h", "gantry commission y2 --accept"}},
      {"1018h says another vendor",
       "cu",
       {.mailbox = {.shows = shown({0x1018, 1}, 7)}},
       {},
       {"station 5 'cu'", "1018h"}},
      {"1018h says nothing", "x", {.mailbox = {.shows = shown({0x1018, 2}, 0)}}},
      {"no 1018h", "z", {.mailbox = {.aborts = MailboxLies::Abort{{0x1018, 1}, 0x06020000, true, false}}}},
      {"a fixed mapping with padding", "y2", {.assignment_fixed = true, .mapping_fixed = true}, padded},
  };
  expect(lies);
}

TEST(Liars, eeproms_and_lines) {
  const Lie lies[] = {
      {"a wrong checksum", "io", {.eeprom = eeprom::with_byte(14, 0x55)}, {}, {"station 0 'io'", "0051h"}},
      {"cut within its first words", "x", {.eeprom = eeprom::cut_at(0x30)}, {}, {"station 1 'x'", "0016h"}},
      {"cut within its categories", "y2", {.eeprom = eeprom::cut_at(0x90)}},
      {"a chip that ends early",
       "io",
       {.eeprom = [](auto& image) { image.resize(0x90); }},
       {},
       {"station 0 'io'", "SII EEPROM"}},
      {"blank", "x", {.eeprom = eeprom::cut_at(0)}, {}, {"station 1 'x'", "FFFFFFFFh"}},
      {"no strings", "y2", {.eeprom = eeprom::without(10)}},
      {"no SyncManagers", "x", {.eeprom = eeprom::without(41)}},
      {"categories the other way round", "x", {.eeprom = eeprom::turned}},
      {"SM2 of another length", "y2", {.eeprom = eeprom::sync_manager(2, 2, 99)}},
      {"SM2 where there is none", "x", {.eeprom = eeprom::sync_manager(2, 1, 0x18)}, {}, {"station 1 'x'", "001Dh"}},
      {"SM2 on top of SM3", "x", {.eeprom = eeprom::sync_manager(2, 1, 0x14)}, {}, {"station 1 'x'", "SM2", "SM3"}},
      {"two stations of one alias",
       "z",
       {},
       [](auto& m) { station(m, "z").alias = station(m, "x").alias; },
       {"station 4 'z'", "that of 'x'"}},
      {"X and Y1 have changed places",
       "x",
       {},
       [](auto& m) { std::swap(station(m, "x").position, station(m, "y1").position); },
       {"station 1 'x'", "AMD530B stands there"}},
      {"one more on the line",
       "io",
       {},
       [](auto& m) {
         config::Station more = station(m, "io");
         more.id = StationId{static_cast<std::uint16_t>(m.stations.size())}, more.position = 6, more.name = "more";
         m.stations.push_back(more);
       },
       {"7 stations answer", "has 6", "gantry bus scan"}},
      {"falls to SAFE_OP in homing", "x", {.falls = StationHabits::Fall{1500, 0x001B}}, {}, {"station 1 'x'", "001Bh"}},
      {"falls as soon as it is in OP",
       "y2",
       {.falls = StationHabits::Fall{1, 0x002C, true}},
       {},
       {"station 3 'y2'", "002Ch"}},
      {"falls again and again", "z", {.falls = StationHabits::Fall{700, 0x8001, true}}, {}, {"station 4 'z'", "8001h"}},
      {"its AL status has bits of an application", "x", {.al_bits = 0xA500}},
      {"its AL status has the bit of an identification that nobody asked for", "y2", {.al_bits = 0x20}},
      {"does not enter OP",
       "x",
       {.refuses = StationHabits::Refusal{AlState::Op, 0x0030}},
       {},
       {"station 1 'x'", "0030h"}},
  };
  expect(lies);
}

TEST(Liars, drives) {
  const Lie lies[] = {
      {"6061h shows homing while it moves in CSP",
       "x",
       {.lies = {.mode_shown_in_motion = std::int8_t{6}}},
       {},
       {"station 1 'x'", "another mode"}},
      {"ready to switch on, never", "x", {.lies = {.status_never = 0x0001}}, {}, {"station 1 'x'", "within a second"}},
      {"ready to switch on, always", "y2", {.lies = {.status_always = 0x0001}}, {}, {"station 3 'y2'", "0651h"}},
      {"target reached, always", "x", {.lies = {.status_always = 0x0400}}},
      {"internal limit, always", "z", {.lies = {.status_always = 0x0800}}, {}, {"axis Z", "limit"}},
      {"enabled without an order", "x", {.lies = {.enables_unasked = true}}, {}, {"station 1 'x'", "statusword 1237h"}},
      {"enabled after 0.9 s", "y2", {.lies = {.enable_delay = 900}}},
      {"enabled after 3 s", "z", {.lies = {.enable_delay = 3000}}, {}, {"station 4 'z'", "within a second"}},
      {"6064h of the other sign", "z", {.lies = {.position_factor = -1}}, {}, {"axis Z", "does not follow"}},
      {"6064h twice what it is", "x", {.lies = {.position_factor = 2}}, {}, {"axis X", "faster in homing"}},
      {"6064h is half a millimetre off",
       "z",
       {.lies = {.position_off = 1000}},
       {},
       {"axis Z", "did not find its switch"}},
      {"6064h freezes after homing",
       "z",
       {.lies = {.position_dead = true, .after = 3000}},
       {},
       {"axis Z", "does not follow"}},
      {"6064h jumps by 2^16", "z", {.lies = {.position_off = 65536, .after = 3000}}, {}, {"station 4 'z'", "jumped"}},
      {"6064h wraps before the edge", "z", {.lies = {.counter_begin = 2147483600}}},
      {"6064h wraps the other way", "x", {.lies = {.counter_begin = -2147483600}}},
      {"limits are shown inverted", "x", {.lies = {.inputs_inverted = 3}}, {}, {"axis X", "limit switch"}},
      {"the far limit chatters", "y2", {.lies = {.input_noise = 2}}, {}, {"axis Y", "limit switch"}},
  };
  expect(lies);
}

/// An edge that is shown as soon as the probe is armed is no touch: nothing has moved yet.
TEST(Liars, a_probe_that_latches_when_it_is_armed) {
  const Said quiet;
  Rig rig({.placement = "dx=0.7 mm", .habits = {{"z", {.lies = {.probe = sim::ProbeLie::LatchedAtArming}}}}});
  const auto result = rig.run(load_recipe("recipes/demo-board.yaml"));
  ASSERT_FALSE(result.errors.empty());
  const Error& why = result.errors.front();
  EXPECT_EQ(why.fault, Fault::ProbeStale) << to_text(why);
  EXPECT_EQ(why.where, "axis Z");
  EXPECT_NE(why.message.find("touch 'front_left'"), std::string::npos) << to_text(why);
}

}  // namespace
}  // namespace gantry::test
