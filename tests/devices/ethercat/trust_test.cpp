// What the master believes of a station: each test alters the station alone, never what the controller reads.
#include <algorithm>
#include <gtest/gtest.h>
#include <utility>

#include "devices/ethercat/parameters.hpp"
#include "devices/ethercat/restart_note.hpp"
#include "devices/passing_port.hpp"
#include "devices/profiles/homing_objects.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/wire/bytes.hpp"
#include "sim/station/habits.hpp"
#include "tests/altered.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

using test::holds;
using test::object;
using test::station;

struct Trust : testing::Test {
  std::unique_ptr<BusBench> bench = std::make_unique<BusBench>();
  BusBench& b() { return *bench; }
  void wired(const BusBench::Change& change) { bench = std::make_unique<BusBench>(change); }

  std::vector<Error> doubts(std::string_view name) {
    const auto up = b().bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    for (const auto& s : b().master->stations())
      if (s.config != nullptr && s.config->name == name) return s.doubts;
    return {};
  }
  void expect_doubt(std::string_view name, std::initializer_list<const char*> words,
                    Fault fault = Fault::ParameterDiffers) {
    const auto found = doubts(name);
    ASSERT_EQ(found.size(), 1u) << (found.empty() ? "none" : to_text(found[1]));
    EXPECT_EQ(found[0].fault, fault);
    for (const char* word : words)
      EXPECT_NE(to_text(found[0]).find(word), std::string::npos) << to_text(found[0]) << ", " << word;
  }
  std::int64_t now(std::string_view name, config::ObjectAddress address, config::ObjectType type) {
    const auto value = b().master->read_object(station(b().machine, name).id, address);
    EXPECT_TRUE(value);
    return value ? to_number(type, *value).value_or(-1) : -1;
  }
};

TEST_F(Trust, the_machine_as_shipped_leaves_no_doubt) {
  ASSERT_TRUE(b().bring_up());
  for (const auto& s : b().master->stations()) EXPECT_TRUE(s.doubts.empty()) << to_text(s.doubts.front());
}

TEST_F(Trust, a_value_that_acts_at_power_up_is_compared_and_never_written) {
  // STD402EC 10.1, note 6. 8000 for 10000 would scale every move by 1.25.
  wired([](auto& m) { holds(m, "cu", {0x20F2, 0}, 8000); });
  expect_doubt("cu", {"'cu'", "20F2h", "8000", "10000", "gantry commission cu --write"});
  EXPECT_EQ(now("cu", {0x20F2, 0}, config::ObjectType::U32), 8000);
}

TEST_F(Trust, the_second_axis_of_a_station_has_parameters_of_its_own) {
  wired([](auto& m) {
    for (auto& row : station(m, "cu").profile.startup)
      if (row.address.index == 0x22F1) row.value = 3900;
  });
  expect_doubt("cu", {"22F1h", "3900", "1200"});
}

TEST_F(Trust, a_motor_type_is_never_written) {
  wired([](auto& m) { holds(m, "cu", {0x20DA, 0}, 5); });
  const auto found = doubts("cu");
  ASSERT_FALSE(found.empty());
  EXPECT_NE(found[0].message.find("never written"), std::string::npos) << found[0].message;
  EXPECT_EQ(now("cu", {0x20DA, 0}, config::ObjectType::U16), 5);
}

TEST_F(Trust, a_write_that_is_ignored_is_seen) {
  for (const config::ObjectAddress address : {config::ObjectAddress{0x2190, 1}, config::ObjectAddress{0x6098, 0}}) {
    BusBench other;
    if (address.index == 0x6098)
      station(other.machine, "x").profile.startup.push_back({address, config::ObjectType::I8, 17, "homing method"});
    other.segment.ignore_writes(station(other.machine, "x").id, address);
    ASSERT_TRUE(other.bring_up());
    const auto& x = other.master->stations()[1];
    ASSERT_EQ(x.doubts.size(), 1u) << std::hex << address.index;
    EXPECT_NE(x.doubts[0].message.find("ignores"), std::string::npos) << x.doubts[0].message;
  }
}

TEST_F(Trust, a_write_that_is_refused_is_told_with_its_abort) {
  wired([](auto& m) { object(m, "x", {0x2190, 1}).writable = false; });
  expect_doubt("x", {"2190h:1", "refused", "06010002h"});
}

TEST_F(Trust, an_object_that_is_absent_is_declared_or_refused) {
  wired([](auto& m) { test::remove_object(station(m, "y1").profile, 0x2010); });
  expect_doubt("y1", {"2010h", "filter", "declared: [filter]"});
  for (auto& row : station(b().machine, "y1").profile.startup)
    if (row.name == "filter") row.declared = true;
  EXPECT_TRUE(doubts("y1").empty());
}

/// By 9.1.2 of the iD286 6099h has no sub-index 2, by 10.1 it has.
TEST_F(Trust, a_row_of_homing_that_is_absent_is_declared_or_refused) {
  wired([](auto& m) { test::remove_object(station(m, "x").profile, 0x6099); });
  auto& x = station(b().machine, "x").profile;
  const auto before = x.startup;
  for (const bool declared : {false, true}) {
    x.startup = before;
    x.declared = declared ? std::vector<std::string>{"homing_fast", "homing_slow"} : std::vector<std::string>{};
    const auto rows = homing_objects(x, 0, b().machine.axes[0]);
    ASSERT_TRUE(rows) << to_text(rows.error());
    x.startup.insert(x.startup.end(), rows->begin(), rows->end());
    const auto found = doubts("x");
    ASSERT_EQ(found.size(), declared ? 0u : 2u);
    if (declared) continue;
    for (const char* word : {"6099h:2", "homing_slow", "declared: [homing_slow]"})
      EXPECT_NE(to_text(found[1]).find(word), std::string::npos) << to_text(found[1]);
  }
}

/// Counts SDO downloads to one object.
class Downloads final : public PassingPort {
 public:
  Downloads(FramePort& port, config::ObjectAddress of) : PassingPort(port), of_(of) {}
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    // ETG.1000.6, 5.6.2.2: the command byte of an initiated download is 0010xxxxb, then index and sub-index; the CoE
    // header of a request (2000h) stands before it.
    // A request that is sent again has the counter of the mailbox header before that.
    for (std::size_t i = 3; i + 3 < frame.size(); ++i) {
      const auto at = [&](std::size_t k) { return std::to_integer<unsigned>(frame[k]); };
      if (at(i - 2) == 0x00 && at(i - 1) == 0x20 && (at(i) & 0xF0u) == 0x20 && at(i + 1) == (of_.index & 0xFFu) &&
          at(i + 2) == of_.index >> 8u && at(i + 3) == of_.sub)
        seen_ += std::exchange(counter_, at(i - 3)) != at(i - 3);
    }
    return PassingPort::send(port, frame);
  }
  [[nodiscard]] int seen() const { return seen_; }

 private:
  config::ObjectAddress of_;
  unsigned counter_ = 0;
  int seen_ = 0;
};

/// A station that comes back is tried every ten seconds; what it ignores would wear its EEPROM each time.
TEST(IgnoredWrites, are_not_repeated_before_the_next_power_up) {
  const config::ObjectAddress object{0x2190, 0};
  BusBench b;
  Downloads tap(b.port, object);
  b.port_used = &tap;
  b.segment.ignore_writes(station(b.machine, "cu").id, object);
  b.operate();
  EXPECT_EQ(tap.seen(), 1);
  const std::size_t cu = 5;
  StationRecord copy = b.master->stations()[cu];
  ASSERT_EQ(copy.doubts.size(), 1u);
  const std::string first = to_text(copy.doubts[0]);
  {
    Link link(tap, b.clock);
    copy.mailbox.count = MailboxState::Count::Foreign;
    for (int again = 0; again < 3; ++again) {
      ASSERT_TRUE(write_startup(link, copy));
      ASSERT_EQ(copy.doubts.size(), 1u);
      EXPECT_EQ(to_text(copy.doubts[0]), first);
    }
    EXPECT_EQ(tap.seen(), 1);
    std::ranges::find(copy.startup, object, &config::StartupRow::address)->value ^=
        1;  // another value is another write
    ASSERT_TRUE(write_startup(link, copy));
    EXPECT_EQ(tap.seen(), 2);
  }
  b.segment.power_cycle(b.master->stations()[cu].id, milliseconds(20));
  b.cycles(500);
  static_cast<void>(b.master->recover(cu));
  EXPECT_EQ(tap.seen(), 3) << "since its power-up it was not tried";
}

TEST_F(Trust, a_station_may_hold_an_object_in_another_size) {
  // 6098h: I8 in one table of the iD286's manual, a word in another (10.1, 9.1.2).
  wired([](auto& m) { object(m, "x", {0x6098, 0}).type = config::ObjectType::I16; });
  auto& startup = station(b().machine, "x").profile.startup;
  startup.push_back({{0x6098, 0}, config::ObjectType::I8, 17, "homing method"});
  EXPECT_TRUE(doubts("x").empty());
  EXPECT_EQ(now("x", {0x6098, 0}, config::ObjectType::I16), 17);
}

TEST_F(Trust, nothing_is_written_that_is_right_already) {
  // STD402EC note 11: its EEPROM takes a million writes. A write here would be refused, and told.
  wired([](auto& m) {
    auto& row = object(m, "cu", {0x2190, 0});
    row.initial = 10, row.writable = false;
  });
  EXPECT_TRUE(doubts("cu").empty());
}

TEST_F(Trust, a_foreign_device_is_refused_before_anything_is_written) {
  wired([](auto& m) { station(m, "y2").profile.identity.vendor = 0x00005A5A; });
  const std::uint32_t product = station(b().machine, "y2").profile.identity.product;
  const auto up = b().bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::IdentityMismatch);
  for (const char* word : {"y2", "00005A5A", "gantry commission y2 --accept"})
    EXPECT_NE(to_text(up.error()).find(word), std::string::npos) << to_text(up.error());
  // Accepted, it is taken; changed since, it is not.
  auto& accepted = station(b().machine, "y2").accepted;
  accepted = config::Accepted{.vendor = 0x5A5A, .product = product, .date = "2026-11-22"};
  EXPECT_TRUE(b().bring_up());
  accepted->product = product + 1;
  const auto changed = b().bring_up();
  ASSERT_FALSE(changed);
  EXPECT_NE(changed.error().message.find("2026-11-22"), std::string::npos) << changed.error().message;
}

// ---- what a station's firmware says of it (1018h), beside its EEPROM ----

Error refusal(BusBench& b) {
  const auto up = b.bring_up();
  EXPECT_FALSE(up);
  return up ? Error{} : up.error();
}
void expect_words(const Error& why, Fault fault, std::initializer_list<const char*> words) {
  EXPECT_EQ(why.fault, fault) << to_text(why);
  for (const char* word : words) EXPECT_NE(to_text(why).find(word), std::string::npos) << to_text(why) << ", " << word;
}

/// AMD530B, 8.2: 1 is the default of 1018h:2, and the EEPROM says so here; the firmware says 530h.
TEST_F(Trust, a_firmware_of_another_device_than_the_eeprom_is_refused_before_anything_is_written) {
  wired([](auto& m) {
    object(m, "y1", {0x1018, 2}).initial = 0x530;
    holds(m, "y1", {0x605A, 0}, 0);  // the one station that this is written to
  });
  Downloads startup(b().port, {0x605A, 0});
  b().port_used = &startup;
  const auto& id = station(b().machine, "y1").profile.identity;
  auto& accepted = station(b().machine, "y1").accepted;
  const std::initializer_list<const char*> both{"station 2 'y1'",
                                                "EEPROM",
                                                "product 00000001h",
                                                "1018h",
                                                "product 00000530h",
                                                "HCFA AMD530B",
                                                "gantry commission y1 --accept"};
  expect_words(refusal(b()), Fault::IdentityMismatch, both);
  EXPECT_EQ(startup.seen(), 0);
  // Accepted before anybody looked at 1018h, it is refused all the same; accepted with it, it is taken.
  accepted = config::Accepted{.vendor = id.vendor, .product = id.product, .date = "2026-11-26"};
  expect_words(refusal(b()), Fault::IdentityMismatch, both);
  accepted->object = {.vendor = id.vendor, .product = 0x530};
  EXPECT_TRUE(b().bring_up());
  EXPECT_EQ(startup.seen(), 1);
  accepted->object.product = 0x531;
  expect_words(refusal(b()), Fault::IdentityMismatch,
               {"'y1' has changed since 2026-11-26", "product 00000531h", "product 00000530h", "1018h",
                "gantry commission y1 --accept"});
}

TEST_F(Trust, a_firmware_of_another_vendor_is_refused) {
  wired([](auto& m) { object(m, "cu", {0x1018, 1}).initial = 0x5A5A; });
  expect_words(refusal(b()), Fault::IdentityMismatch, {"station 5 'cu'", "1018h", "vendor 00005A5Ah"});
}

/// CiA 301 has 1018h:2 to :4 as optional; the ISS57's manual prints 0 for all of them.
TEST_F(Trust, a_station_that_does_not_say_what_it_is_is_what_its_eeprom_says) {
  for (const std::uint8_t sub : {std::uint8_t{1}, std::uint8_t{2}}) {
    for (const std::uint32_t code : {0x06020000u, 0x06090011u, 0x08000020u, 0u}) {
      SCOPED_TRACE(testing::Message() << int{sub} << ", abort " << std::hex << code);
      BusBench other;
      other.segment.set_habits(station(other.machine, "x").id,
                               {.mailbox = {.aborts = sim::MailboxLies::Abort{{0x1018, sub}, code, true, false}}});
      const auto up = other.bring_up();
      EXPECT_TRUE(up) << to_text(up.error());
    }
    BusBench zero([&](auto& m) { object(m, "x", {0x1018, sub}).initial = 0; });
    const auto up = zero.bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
  }
}

TEST_F(Trust, a_product_code_of_16_bits_is_that_number) {
  wired([](auto& m) { object(m, "y1", {0x1018, 2}).type = config::ObjectType::U16; });
  EXPECT_TRUE(b().bring_up());
}

TEST_F(Trust, a_station_that_does_not_answer_what_it_is_is_named_in_bounded_time) {
  b().segment.set_habits(station(b().machine, "x").id, {.mailbox = {.silent_at = config::ObjectAddress{0x1018, 2}}});
  const Time before = b().clock.now();
  expect_words(refusal(b()), Fault::MailboxTimeout, {"station 1 'x'", "1018h:02"});
  EXPECT_LT(b().clock.now() - before, milliseconds(5000));
}

/// Its EEPROM is the same, and it has another firmware: a board that was exchanged with its chip moved over.
TEST_F(Trust, a_station_that_comes_back_with_another_firmware_is_not_set_up) {
  b().operate();
  const std::size_t y1 = 2;
  std::vector<std::byte> other(4, std::byte{0x77});
  b().segment.power_cycle(b().master->stations()[y1].id, milliseconds(20));
  b().segment.set_habits(b().master->stations()[y1].id,
                         {.mailbox = {.shows = sim::MailboxLies::Shown{{0x1018, 2}, other}}});
  b().cycles(500);
  const auto back = b().master->recover(y1);
  ASSERT_FALSE(back);
  expect_words(back.error(), Fault::IdentityMismatch, {"station 2 'y1'", "1018h", "77777777h"});
}

TEST_F(Trust, swapped_cables_of_stations_that_look_alike_are_named) {
  wired([](auto& m) { std::swap(station(m, "x").alias, station(m, "z").alias); });
  const auto up = b().bring_up();
  ASSERT_FALSE(up);
  EXPECT_NE(to_text(up.error()).find("'z'"), std::string::npos) << to_text(up.error());
}

TEST_F(Trust, without_an_alias_the_accepted_serials_tell_them_apart) {
  wired([](auto& m) {
    for (auto& s : m.stations) s.alias = 0;
  });
  for (auto& s : b().machine.stations) s.alias = 0;
  ASSERT_TRUE(b().bring_up());
  std::uint32_t serials[2] = {};
  for (const auto& s : b().master->stations()) {
    if (s.config->name == "x") serials[0] = s.sii.serial;
    if (s.config->name == "z") serials[1] = s.sii.serial;
  }
  ASSERT_NE(serials[0], serials[1]);
  const auto& id = station(b().machine, "x").profile.identity;
  station(b().machine, "x").accepted = config::Accepted{id.vendor, id.product, id.revision, serials[1], "2026-11-22"};
  station(b().machine, "z").accepted = config::Accepted{id.vendor, id.product, id.revision, serials[0], "2026-11-22"};
  const auto up = b().bring_up();
  ASSERT_FALSE(up);
  EXPECT_NE(to_text(up.error()).find("swapped"), std::string::npos) << to_text(up.error());
  // Another serial of the same product is a spare part: taken, and told.
  station(b().machine, "x").accepted->serial = 424242;
  station(b().machine, "z").accepted->serial = serials[1];
  EXPECT_TRUE(b().bring_up());
  EXPECT_FALSE(b().master->notes().empty());
}

TEST_F(Trust, what_acts_at_power_up_waits_for_it) {
  station(b().machine, "x").restart_pending = true;
  EXPECT_TRUE(doubts("x").empty());  // its supply has just come
  b().master->shut_down();
  expect_doubt("x", {"supply off and on"}, Fault::RestartNeeded);
}

/// x and y1 wait for their supply; that it was off is known to the next start by the address that they have lost.
struct Waiting : BusBench {
  Waiting() {
    for (const char* name : {"x", "y1"}) station(machine, name).restart_pending = true;
  }
  int waiting() {
    EXPECT_TRUE(bring_up());
    int n = 0;
    for (const auto& s : master->stations()) n += s.doubts.empty() ? 0 : 1;
    master->shut_down();
    return n;
  }
};

TEST(Restarted, a_look_at_the_bus_leaves_it_to_the_next_start) {
  Waiting b;
  {
    Survey survey(b.port, b.clock);
    for (int times = 0; times < 2; ++times) {
      const auto found = survey.scan();
      ASSERT_TRUE(found);
      for (const auto& s : *found) EXPECT_TRUE(s.record.since_power_up) << s.record.where;
    }
    ASSERT_TRUE(survey.read_object(1, {0x1018, 1}));  // by its mailbox, in PRE_OP
  }
  EXPECT_EQ(b.waiting(), 0);
  EXPECT_EQ(b.waiting(), 2) << "since then it was not off";
  EXPECT_TRUE(Survey(b.port, b.clock).scan());
  EXPECT_EQ(b.waiting(), 2) << "and a look does not say that it was";
}

TEST(Restarted, a_start_that_fails_leaves_it_to_the_next_one) {
  for (const bool in_the_scan : {true, false}) {
    Waiting b;
    auto& z = station(b.machine, "z").profile;
    const auto before = z;
    if (in_the_scan)
      z.identity.product ^= 1;
    else
      z.max_pdo_entries = 1;
    EXPECT_FALSE(b.bring_up());
    z = before;
    EXPECT_EQ(b.waiting(), 0) << in_the_scan;
  }
}

TEST(Restarted, what_acts_at_power_up_and_was_written_after_it_waits_for_the_next_one) {
  Waiting b;
  const auto& startup = station(b.machine, "x").profile.startup;
  const auto row = std::ranges::find(startup, config::ActsAt::PowerUp, &config::StartupRow::acts);
  ASSERT_NE(row, startup.end());
  {
    Survey survey(b.port, b.clock);
    ASSERT_TRUE(survey.write_held(1, *row, static_cast<std::size_t>(config::bits(row->type)) / 8));
  }
  EXPECT_EQ(b.waiting(), 1);
}

/// A value that acts at power-up is written to x, which takes it, refuses it, or does not answer; some drives have
/// stored it then (note 11 of the STD402EC), so that only a refusal takes the note back.
TEST(RestartNote, stays_unless_the_station_says_that_it_has_not_taken_the_value) {
  enum class Answers { Taken, Refused, Nothing, TooLarge };
  for (const auto answers : {Answers::Taken, Answers::Refused, Answers::Nothing, Answers::TooLarge}) {
    SCOPED_TRACE(static_cast<int>(answers));
    BusBench b;
    auto& x = station(b.machine, "x");
    auto row = *std::ranges::find(x.profile.startup, config::ActsAt::PowerUp, &config::StartupRow::acts);
    if (answers == Answers::TooLarge) row.value = std::int64_t{1} << 40;
    sim::StationHabits habits;
    if (answers == Answers::Refused) habits.mailbox.aborts = {.address = row.address, .code = 0x08000022};
    if (answers == Answers::Nothing) habits.mailbox.silent_at = row.address;
    std::vector<bool> kept;
    const auto keep = [&]() -> Result<void> { return kept.push_back(x.restart_pending), Result<void>{}; };
    b.segment.set_habits(x.id, habits);
    Survey survey(b.port, b.clock);
    RestartNote note(x, keep);
    const auto write = [&] {
      EXPECT_EQ(kept, std::vector<bool>{true}) << "before the value goes out";
      return survey.write_held(1, row, static_cast<std::size_t>(config::bits(row.type)) / 8);
    };
    const auto wrote = note.under(write);
    EXPECT_EQ(wrote.has_value(), answers == Answers::Taken);
    const std::string why = wrote ? "" : to_text(wrote.error());
    EXPECT_EQ(why.find("is not known") != std::string::npos, answers == Answers::Nothing) << why;
    ASSERT_TRUE(note.settle());
    const bool stays = answers == Answers::Taken || answers == Answers::Nothing;
    EXPECT_EQ(x.restart_pending, stays);
    EXPECT_EQ(kept, stays ? std::vector<bool>({true}) : std::vector<bool>({true, false}));
    if (!stays) continue;
    row.value = std::int64_t{1} << 40;  // of two, one is enough
    EXPECT_FALSE(note.under(write));
    ASSERT_TRUE(note.settle());
    EXPECT_TRUE(x.restart_pending);
  }
}

TEST(RestartNote, that_cannot_be_kept_leaves_the_value_unwritten) {
  config::Station s;
  RestartNote note(s, [] { return Result<void>(fail(Fault::FileUnwritable, "full")); });
  EXPECT_FALSE(note.under([] { return ADD_FAILURE() << "written", Result<void>{}; }));
  EXPECT_FALSE(s.restart_pending);
  EXPECT_TRUE(note.settle());
}

/// AMD530B 8.1: 1010h:1 saves 6000h, 1010h:2 saves 2000h. What nobody has written is not saved along with the rest.
TEST(Saving, is_of_the_groups_that_were_written) {
  struct Case {
    std::vector<config::ObjectAddress> written;
    int profile, vendor;
  };
  for (const Case& c : {Case{{}, 0, 0}, Case{{{0x2000, 0}}, 0, 1}, Case{{{0x605A, 0}}, 1, 0},
                        Case{{{0x2000, 0}, {0x605A, 0}, {0x2024, 0}}, 1, 1}}) {
    BusBench b;
    Downloads first(b.port, {0x1010, 1});
    Downloads second(first, {0x1010, 2});
    Survey survey(second, b.clock);
    const auto& y1 = station(b.machine, "y1");
    ASSERT_TRUE(survey.save_parameters(y1.position, y1.profile, c.written));
    EXPECT_EQ(first.seen(), c.profile);
    EXPECT_EQ(second.seen(), c.vendor);
  }
}

/// "save" (1010h) of a drive that refuses it, and of one that says that it has saved and has not: the one is named at
/// once, the other when its supply was off and on.
TEST(Saving, that_is_refused_or_forgotten_is_named) {
  for (const auto saving : {sim::Saving::Refuses, sim::Saving::Forgets, sim::Saving::Keeps}) {
    SCOPED_TRACE(static_cast<int>(saving));
    BusBench b([](auto& m) { holds(m, "y1", {0x2000, 0}, 8000); });
    const auto& y1 = station(b.machine, "y1");
    b.segment.set_habits(y1.id, {.save = saving});
    const auto row =
        std::ranges::find(y1.profile.startup, config::ObjectAddress{0x2000, 0}, &config::StartupRow::address);
    ASSERT_NE(row, y1.profile.startup.end());
    {
      Survey survey(b.port, b.clock);
      ASSERT_TRUE(survey.write_held(y1.position, *row, 2));
      const auto saved = survey.save_parameters(y1.position, y1.profile, std::array{row->address});
      ASSERT_EQ(saved.has_value(), saving != sim::Saving::Refuses);
      const std::string why = saved ? "" : to_text(saved.error());
      for (const char* word : {"station 2", "1010h", "0800002"})
        EXPECT_EQ(why.find(word) != std::string::npos, !saved) << why;
    }
    b.segment.power_off(y1.id);
    b.segment.power_on(y1.id);
    ASSERT_TRUE(b.bring_up());
    const auto found = std::ranges::find(b.master->stations(), y1.id, &StationRecord::id);
    ASSERT_NE(found, b.master->stations().end());
    EXPECT_EQ(found->doubts.empty(), saving == sim::Saving::Keeps);
    if (found->doubts.empty()) continue;
    EXPECT_EQ(found->doubts[0].fault, Fault::ParameterDiffers);
    for (const char* word : {"'y1'", "2000h", "8000", "4200", "gantry commission y1 --write"})
      EXPECT_NE(to_text(found->doubts[0]).find(word), std::string::npos) << to_text(found->doubts[0]);
  }
}

TEST(Restarted, it_is_told_by_whichever_attempt_brings_the_station_back) {
  BusBench b;
  b.operate();
  const std::size_t x = 1;
  b.segment.power_cycle(b.master->stations()[x].id, milliseconds(20));
  b.cycles(500);
  EXPECT_FALSE(b.master->recover(x)) << "nobody exchanges meanwhile, so that it cannot be seen to take part";
  b.due = b.master->first_cycle(b.clock.now());
  b.cycles(5);
  b.master->step_by([&] { b.cycle(); });
  const auto back = b.master->recover(x);
  ASSERT_TRUE(back) << to_text(back.error());
  ASSERT_TRUE(*back);
  EXPECT_TRUE((*back)->restarted);
  const auto again = b.master->recover(x);
  ASSERT_TRUE(again);
  EXPECT_FALSE(*again);
}

}  // namespace
}  // namespace gantry::devices
