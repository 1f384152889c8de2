// Bring-up that bends: stations that are not quite what their profiles say, altered on the simulator's side only. Each
// works as well, or is refused with its name, the object and what was asked of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "devices/ethercat/states.hpp"
#include "sim/station/station.hpp"
#include "tests/devices/ethercat/bent_bench.hpp"

namespace gantry::devices {
namespace {

using config::Machine;
using config::ObjectType;
using config::SyncManagerKind;

constexpr auto kAsIs = [](Machine&) {};

testing::AssertionResult refused(const Result<void>& up, std::initializer_list<std::string_view> words) {
  if (up) return testing::AssertionFailure() << "it was brought up";
  const std::string text = to_text(up.error());
  for (const auto word : words)
    if (text.find(word) == std::string::npos) return testing::AssertionFailure() << "no '" << word << "' in: " << text;
  return testing::AssertionSuccess();
}

/// The frames that a program which dies has ready, with one change to them; and the station has taken them.
void send_last_word(BentBench& b, const ImageChange& change) {
  std::array<FrameBytes, kMaxCyclicFrames> frames{};
  const std::size_t n = b.master->spare_frames(std::span(&change, 1), frames);
  ASSERT_GT(n, 0u);
  for (std::size_t i = 0; i < n; ++i)
    ASSERT_TRUE(b.port.send(PortIndex::Primary, std::span(frames[i].bytes).first(frames[i].size)));
  b.clock.sleep_until(b.clock.now() + milliseconds(2));
  b.segment.advance();
}

// --- States ----

/// Each step up, refused with each code of ETG.1020 and with one of a vendor: station, step, code, its text and what to
/// do.
TEST(Bend, a_state_that_is_refused_is_told_with_its_code_and_what_to_do) {
  using wire::AlState;
  std::vector<std::uint16_t> codes{0x8012, 0x0777};
  for (const auto& row : wire::kAlStatusCodes) codes.push_back(row.code);
  std::size_t n = 0;
  for (const auto& [state, stays] :
       {std::pair{AlState::PreOp, "INIT"}, {AlState::SafeOp, "PRE_OP"}, {AlState::Op, "SAFE_OP"}})
    for (const std::uint16_t code : codes) {
      const char* const name = n++ % 2 == 0 ? "x" : "cu";
      SCOPED_TRACE(fmt::format("{} {} {:04X}h", name, wire::name(state), code));
      BentBench b(kAsIs);
      b.habits(name, {.refuses = sim::StationHabits::Refusal{state, code}});
      Result<void> up = b.bring_up();
      if (state == AlState::Op) {
        ASSERT_TRUE(up) << to_text(up.error());
        b.cycles(20);
        ASSERT_TRUE(b.master->request_operation());
        b.cycles(300);
        up = b.master->check_operation();
      }
      EXPECT_TRUE(refused(up, {fmt::format("'{}'", name), wire::name(state), fmt::format("in {}", stays),
                               fmt::format("AL status code {:04X}h, {}; ", code, wire::al_status_text(code)),
                               remedy_of_al_code(code)}));
    }
}

// --- Mapping ---------------------------------------------------------------------------------------------------------

TEST(Bend, a_mode_that_is_in_no_pdo_goes_by_sdo) {
  for (const bool display_too : {false, true}) {
    SCOPED_TRACE(display_too);
    BentBench b([&](Machine& wired) {
      object(station(wired, "y1").profile, 0x6060).mappable = false;
      auto& x = station(wired, "x").profile;
      object(x, 0x6060).mappable = false;
      if (display_too) object(x, 0x6061).mappable = false;
    });
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
    EXPECT_TRUE(b.noted("'x'", "6060h")) << b.all_notes();
    EXPECT_TRUE(b.noted("'y1'", "6060h")) << b.all_notes();
    EXPECT_EQ(b.noted("'x'", "6061h"), display_too) << b.all_notes();
  }
}

TEST(Bend, optional_objects_that_cannot_be_mapped_are_left_out_and_told) {
  for (const int index : {0x603F, 0x60B8, 0x60B9, 0x60BA, 0x60FD}) {
    SCOPED_TRACE(index);
    BentBench b([&](Machine& wired) {
      object(station(wired, "x").profile, static_cast<std::uint16_t>(index)).mappable = false;
    });
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
    EXPECT_TRUE(b.noted("'x'", fmt::format("{:04X}h", index))) << b.all_notes();
  }
}

TEST(Bend, objects_that_the_station_does_not_have_are_left_out_and_told) {
  for (const int index : {0x603F, 0x6061, 0x60B9, 0x60FD}) {
    SCOPED_TRACE(index);
    BentBench b([&](Machine& wired) { remove_object(station(wired, "x").profile, static_cast<std::uint16_t>(index)); });
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
    EXPECT_TRUE(b.noted("'x'", fmt::format("{:04X}h", index))) << b.all_notes();
  }
}

TEST(Bend, inputs_that_are_in_no_pdo_are_polled) {
  BentBench b([&](Machine& wired) {
    object(station(wired, "x").profile, 0x60FD).mappable = false;
    object(station(wired, "x").profile, 0x603F).mappable = false;
  });
  b.operate();
  auto& x = b.of("X");
  EXPECT_FALSE(x.drive.feedback().home || x.drive.feedback().pos_limit || x.drive.feedback().neg_limit);
  const AxisId id = config::find_axis(b.machine, "X")->id;
  b.segment.set_object(station(b.wired, "x").id, {0x60FD, 0}, 0);
  b.segment.motor(id).restore(1e6);  // beyond its positive limit switch
  b.served_until([&] { return x.drive.feedback().pos_limit; }, 1000);
  EXPECT_TRUE(x.drive.feedback().pos_limit);
  const auto& errors = station(b.machine, "x").profile.drive->errors;
  b.segment.drive_fault(id, 0, errors.front().code);
  b.served_until([&] { return x.drive.feedback().error_code == errors.front().code; }, 1000);
  EXPECT_EQ(x.drive.feedback().error_code, errors.front().code);
}

TEST(Bend, the_probes_objects_are_needed_where_the_probe_is) {
  for (const int index : {0x60B8, 0x60B9, 0x60BA}) {
    BentBench b([&](Machine& wired) {
      object(station(wired, "z").profile, static_cast<std::uint16_t>(index)).mappable = false;
    });
    EXPECT_TRUE(refused(b.bring_up(), {"'z'", fmt::format("{:04X}h", index), "probe"}));
  }
}

TEST(Bend, what_a_drive_needs_in_every_cycle_has_to_be_mapped) {
  for (const int index : {0x6040, 0x607A, 0x6041, 0x6064}) {
    for (const char* name : {"x", "cu"}) {
      SCOPED_TRACE(fmt::format("{} {:04X}h", name, index));
      BentBench b([&](Machine& wired) {
        object(station(wired, name).profile, static_cast<std::uint16_t>(index)).mappable = false;
      });
      EXPECT_TRUE(refused(b.bring_up(), {fmt::format("'{}'", name), fmt::format("{:04X}h", index), "mapp", "axis 0"}));
    }
  }
}

TEST(Bend, sizes_are_the_stations) {
  BentBench b([&](Machine& wired) {
    auto& x = station(wired, "x").profile;
    object(x, 0x60B9).type = ObjectType::U32;
    object(x, 0x6060).type = ObjectType::I16;
    object(x, 0x6061).type = ObjectType::I16;
    object(x, 0x6098).type = ObjectType::I16;
    object(x, 0x60FD).type = ObjectType::U16;
  });
  ASSERT_NO_FATAL_FAILURE(b.works("X"));
}

TEST(Bend, a_probe_status_of_32_bits_touches_as_well) {
  BentBench b([&](Machine& wired) { object(station(wired, "z").profile, 0x60B9).type = ObjectType::U32; });
  ASSERT_NO_FATAL_FAILURE(b.works("Z"));
  b.touches();
}

TEST(Bend, a_drive_without_a_homing_acceleration_homes_with_its_own) {
  BentBench b([&](Machine& wired) { remove_object(station(wired, "x").profile, 0x609A); });
  ASSERT_NO_FATAL_FAILURE(b.works("X"));
  EXPECT_TRUE(b.noted("'x'", "609Ah")) << b.all_notes();
}

TEST(Bend, the_second_axis_may_have_its_pdos_elsewhere) {
  for (const bool information : {true, false}) {
    SCOPED_TRACE(information);
    BentBench b([&](Machine& wired) {
      auto& p = station(wired, "cu").profile;
      p.rx_pdos[1].index = 0x1610;
      p.tx_pdos[1].index = 0x1A10;
    });
    b.habits("cu", {.no_information = !information});
    ASSERT_NO_FATAL_FAILURE(b.works("U"));
  }
}

/// The station's own mapping: others than the profile's, in another order, with gaps.
void own_mapping(Machine& wired, bool with_target) {
  auto& p = station(wired, "x").profile;
  p.pdo_fixed = true;
  p.max_pdo_entries = 16;
  p.rx_pdos = {{0x1601, 0, {{{0x6060, 0}, 8}, {{0, 0}, 8}}}};
  if (with_target) p.rx_pdos[0].entries.push_back({{0x607A, 0}, 32});
  p.rx_pdos[0].entries.push_back({{0x60FF, 0}, 32});
  p.rx_pdos[0].entries.push_back({{0x6040, 0}, 16});
  p.tx_pdos = {{0x1A02, 0, {{{0x6064, 0}, 32}, {{0x606C, 0}, 32}, {{0x6061, 0}, 8}}},
               {0x1A03, 0, {{{0, 0}, 8}, {{0x6041, 0}, 16}}}};
}

TEST(Bend, a_fixed_mapping_is_taken_if_it_holds_what_is_needed) {
  BentBench b([&](Machine& wired) { own_mapping(wired, true); });
  ASSERT_NO_FATAL_FAILURE(b.works("X"));
  for (const char* left_out : {"60B8h", "60B9h", "603Fh", "60FDh"})
    EXPECT_TRUE(b.noted("'x'", left_out)) << b.all_notes();
  BentBench poor([&](Machine& wired) { own_mapping(wired, false); });
  EXPECT_TRUE(refused(poor.bring_up(), {"'x'", "607Ah", "fixed"}));
}

/// 6080h of the AMD530B bounds its speed (8.4): a zero there and nothing moves.
TEST(Bend, outputs_that_are_not_known_here_keep_what_the_station_has) {
  const auto own = [](Machine& wired) {
    auto& p = station(wired, "y1").profile;
    p.pdo_fixed = true;
    p.rx_pdos[0].entries.push_back({{0x6098, 0}, 8});
    p.rx_pdos[0].entries.push_back({{0x6080, 0}, 32});
  };
  BentBench b(own);
  const StationId id = station(b.machine, "y1").id;
  const auto held = [&](std::uint16_t index) {
    return b.segment.station(station(b.machine, "y1").position).objects().value({index, 0});
  };
  for (int start = 0; start < 2; ++start) {
    SCOPED_TRACE(start);
    ASSERT_NO_FATAL_FAILURE(b.operate());
    b.cycles(50);
    EXPECT_EQ(held(0x6080), 833'333);
    EXPECT_EQ(held(0x6098), 17);
    EXPECT_TRUE(b.noted("'y1'", "6080h")) << b.all_notes();
    ASSERT_NO_FATAL_FAILURE(send_last_word(b, {id, 0, std::byte{0xFF}, std::byte{0}}));
    EXPECT_EQ(held(0x6080), 833'333) << "also after the last word";
    b.master->shut_down();
    EXPECT_EQ(held(0x6080), 833'333) << "also after the end";
  }
  BentBench unread([&](Machine& wired) {
    own(wired);
    object(wired, "y1", {0x6080, 0}).readable = false;
  });
  EXPECT_TRUE(refused(unread.bring_up(), {"'y1'", "6080h"}));
}

TEST(Bend, a_mapping_of_which_only_one_half_can_be_written_is_bent_to) {
  // 1C12h and 1C13h are fixed, and carry at power-on what the axes need, or the mapping objects themselves are.
  for (const bool assignment : {true, false}) {
    SCOPED_TRACE(assignment);
    BentBench b(kAsIs);
    b.habits("x", {.assignment_fixed = assignment, .mapping_fixed = !assignment});
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
  }
}

TEST(Bend, entries_of_8_bits_come_last_and_are_padded_where_the_station_needs_it) {
  for (const char* name : {"x", "cu"}) {
    BentBench b(kAsIs);
    b.habits(name, {.even_pdos = true});
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
    EXPECT_TRUE(b.master->notes().empty()) << b.all_notes();  // nothing is lost by it
  }
}

TEST(Bend, a_station_that_is_bent_comes_back_after_a_loss_of_power) {
  BentBench b([&](Machine& wired) {
    object(station(wired, "x").profile, 0x6060).mappable = false;
    auto& p = station(wired, "cu").profile;
    p.rx_pdos[1].index = 0x1610;
    p.tx_pdos[1].index = 0x1A10;
  });
  b.habits("x", {.needs_eeprom = true, .even_pdos = true});
  b.operate();
  for (const char* name : {"x", "cu"}) {
    const StationId id = station(b.wired, name).id;
    b.segment.power_cycle(id);
    b.cycles(400);
    b.master->step_by([&b] { b.cycle(); });
    const auto back = b.master->bring_back(id);
    b.master->step_by({});
    ASSERT_TRUE(back) << to_text(back.error());
  }
  b.served_until([&] { return b.last.ethercat.al_states == 8; }, 2000);
  auto& x = b.of("X");
  x.command = {.goal = DriveGoal::Enabled, .target = x.drive.feedback().position};
  b.served_until([&] { return x.command.target = x.drive.commanded(), x.drive.feedback().takes_targets; }, 2000);
  EXPECT_TRUE(x.drive.feedback().takes_targets);
}

TEST(Bend, the_last_word_reaches_a_bent_station) {
  BentBench b([&](Machine& wired) { own_mapping(wired, true); });
  b.operate();
  b.enable();
  const auto layout = map_drive(station(b.machine, "x").profile, 0);
  ASSERT_TRUE(layout);
  const auto at = static_cast<std::uint16_t>(layout->controlword.offset);
  const ImageChange stop{station(b.machine, "x").id, at, std::byte{0}, std::byte{0x02}};  // quick stop
  ASSERT_NO_FATAL_FAILURE(send_last_word(b, stop));
  EXPECT_NE(b.segment.station(station(b.machine, "x").position).objects().value({0x6041, 0}) & 0x6F, 0x27);
}

// --- Where things lie ------------------------------------------------------------------------------------------------

TEST(Bend, sync_managers_lie_where_the_eeprom_says) {
  const auto at = [](config::StationProfile& p, SyncManagerKind kind) -> config::SyncManagerRow& {
    return *std::ranges::find(p.sync_managers, kind, &config::SyncManagerRow::kind);
  };
  BentBench b([&](Machine& wired) {
    auto& x = station(wired, "x").profile;
    at(x, SyncManagerKind::ProcessOut).start = 0x1800;
    at(x, SyncManagerKind::ProcessIn).start = 0x1C00;
    auto& y = station(wired, "y1").profile;  // as a servo of SOEM #427
    y.sync_managers = {{SyncManagerKind::MailboxOut, 0x1000, 256},
                       {SyncManagerKind::MailboxIn, 0x1400, 256},
                       {SyncManagerKind::ProcessOut, 0x1800, 0},
                       {SyncManagerKind::ProcessIn, 0x1C00, 0}};
    auto& cu = station(wired, "cu").profile;
    cu.sync_managers = {{SyncManagerKind::MailboxOut, 0x1000, 512},
                        {SyncManagerKind::MailboxIn, 0x1200, 512},
                        {SyncManagerKind::ProcessOut, 0x1400, 0},
                        {SyncManagerKind::ProcessIn, 0x1600, 0}};
    auto& io = station(wired, "io").profile;
    at(io, SyncManagerKind::ProcessOut).start = 0x1400;
  });
  ASSERT_NO_FATAL_FAILURE(b.works("X"));
}

TEST(Bend, mailboxes_of_512_bytes_alone) {
  BentBench b([&](Machine& wired) {
    for (auto& s : wired.stations)
      for (auto& row : s.profile.sync_managers) {
        if (row.kind == SyncManagerKind::MailboxOut) row = {row.kind, 0x1000, 512};
        if (row.kind == SyncManagerKind::MailboxIn) row = {row.kind, 0x1200, 512};
        if (row.kind == SyncManagerKind::ProcessOut && s.profile.drive) row.start = 0x1400;
        if (row.kind == SyncManagerKind::ProcessIn && s.profile.drive) row.start = 0x1700;
      }
  });
  ASSERT_NO_FATAL_FAILURE(b.works("X"));
}

TEST(Bend, clocks_are_activated_as_the_eeprom_says) {
  for (const sim::ClockMode& mode :
       {sim::ClockMode{.activate = 0x0700, .shift0_ns = 0, .shift1_ns = 250'000, .factor1 = 0},
        sim::ClockMode{.activate = 0x0300, .shift0_ns = 125'000}, sim::ClockMode{.activate = 0x0730, .factor1 = 2}}) {
    SCOPED_TRACE(mode.activate);
    BentBench b(kAsIs);
    b.habits("x", {.clock = mode});
    ASSERT_NO_FATAL_FAILURE(b.works("X"));
    const auto position = station(b.wired, "x").position;
    std::array<std::byte, 8> cycles{};
    b.segment.station(position).esc().read(0x09A0, cycles, b.clock.now());
    EXPECT_EQ(wire::get_le<std::uint32_t>(cycles, 0), 1'000'000u);
    EXPECT_EQ(wire::get_le<std::uint32_t>(cycles, 4),
              mode.factor1 == 2 ? 1'000'000u : mode.shift1_ns);  // SYNC1 behind SYNC0
    EXPECT_EQ(b.segment.station(position).esc().dc().next_sync0_system() % 1'000'000, mode.shift0_ns);
  }
  BentBench b(kAsIs);
  b.habits("x", {.clock = sim::ClockMode{.activate = 0, .factor0 = 0}});
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_TRUE(b.noted("'x'", "SYNC0")) << b.all_notes();
}

// --- What a station waits for or was left with -----------------------------------------------------------------------

TEST(Bend, an_abort_is_known_by_its_upper_three_bits) {
  BentBench b(kAsIs);
  for (const auto& s : b.wired.stations)
    if (s.profile.drive && s.bus == config::BusKind::EtherCat) b.habits(s.name, {.abort_command = 0x83});
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  const auto value = b.master->read_object(station(b.wired, "x").id, {0x5FFF, 0});
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().fault, Fault::SdoAbort) << to_text(value.error());
}

TEST(Bend, the_eeprom_belongs_to_the_stations_processor_from_pre_op_on) {
  BentBench b(kAsIs);
  for (const auto& s : b.wired.stations)
    if (s.bus == config::BusKind::EtherCat) b.habits(s.name, {.needs_eeprom = true});
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  for (int i = 0; i < b.segment.station_count(); ++i) EXPECT_TRUE(b.segment.station(i).esc().sii_is_stations()) << i;
  // The next bring-up takes them back to read.
  b.master->shut_down();
  const auto again = b.bring_up();
  ASSERT_TRUE(again) << to_text(again.error());
}

TEST(Bend, alias_addressing_that_was_left_on_is_ended) {
  BentBench b([&](Machine& wired) { station(wired, "x").alias = 0x1003; });  // the address that y1 will get
  station(b.machine, "x").alias = 0x1003;
  std::array<std::byte, 1> on{std::byte{1}};
  for (int i = 0; i < b.segment.station_count(); ++i) b.segment.station(i).esc().write(0x0103, on, b.clock.now());
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
}

// --- Side by side ----------------------------------------------------------------------------------------------------

TEST(Bend, stations_come_up_side_by_side) {
  const auto took = [](std::string_view only, bool all_slow) {
    config::Machine m = reference_machine();
    std::erase_if(m.stations, [&](const auto& s) { return s.bus != config::BusKind::EtherCat; });
    m.axes.clear();
    m.sim.axes.clear();
    m.probe = {};
    if (!only.empty()) {
      std::erase_if(m.stations, [&](const auto& s) { return s.name != only; });
      m.stations.front().position = 0;
      m.stations.front().id = StationId{0};
    }
    VirtualClock clock;
    sim::Segment segment(m, clock);
    sim::SegmentPort port(segment, clock);
    for (const auto& s : m.stations)
      if (s.name == "cu" || (all_slow && s.profile.drive))
        segment.set_habits(s.id, {.mailbox_delay = milliseconds(10)});
    EthercatMaster master(m, port, clock);
    const Time begin = clock.now();
    const auto up = master.bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    return seconds(clock.now() - begin);
  };
  const double alone_s = took("cu", false);
  const double one_slow_s = took("", false), all_slow_s = took("", true);
  RecordProperty("alone_ms", static_cast<int>(1000 * alone_s));
  RecordProperty("all_slow_ms", static_cast<int>(1000 * all_slow_s));
  EXPECT_GT(alone_s, 0.2);
  EXPECT_LE(one_slow_s, 1.2 * alone_s);
  EXPECT_LE(all_slow_s, 1.2 * alone_s);
}

// --- Words -----------------------------------------------------------------------------------------------------------

TEST(Bend, a_refusal_names_station_object_and_what_was_asked) {
  BentBench b([&](Machine& wired) { object(station(wired, "y1").profile, 0x6085).max = 5; });
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  const auto& doubts = b.master->stations()[2].doubts;  // which keep torque from it
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(
      refused(tl::unexpected(doubts[0]), {"station 2 'y1'", "6085h:00", "003D0900h", "value too high", "06090031h"}));
}

}  // namespace
}  // namespace gantry::devices
