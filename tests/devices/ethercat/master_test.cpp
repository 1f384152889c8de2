// The master against the virtual segment with the reference machine on it, in virtual time.
#include "devices/ethercat/master.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "devices/profiles/homing_objects.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/rt/homing.hpp"
#include "tests/devices/ethercat/bring_back_all.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"
#include "tests/devices/ethercat/pcap_tap.hpp"

namespace gantry::devices {
namespace {

TEST(Master, brings_the_reference_machine_from_scan_to_op) {
  BusBench b;
  const Time begin = b.clock.now();
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  RecordProperty("bring_up_ms", static_cast<int>((b.clock.now() - begin) / milliseconds(1)));
  b.cycle();
  EXPECT_EQ(b.last.fault, Fault::None) << code(b.last.fault).text;
  EXPECT_EQ(b.last.ethercat.al_states, 4);
  EXPECT_EQ(b.last.ethercat.expected, 3 * 6);  // six stations with outputs and inputs
  b.cycles(20);
  ASSERT_TRUE(b.master->request_operation());
  EXPECT_LT(b.until([&] { return b.last.ethercat.al_states == 8; }, 1000), 1000);
  for (int i = 0; i < 1000; ++i) {
    b.cycle();
    ASSERT_EQ(b.last.fault, Fault::None) << "cycle " << i << " " << code(b.last.fault).text;
    ASSERT_TRUE(b.last.inputs_fresh);
    ASSERT_EQ(b.last.ethercat.al_states, 8);
  }
  const auto all = b.master->check_operation();
  EXPECT_TRUE(all) << to_text(all.error());
  RecordProperty("until_op_ms", static_cast<int>((b.clock.now() - begin) / milliseconds(1)) - 1000);
  EXPECT_TRUE(b.master->notes().empty()) << b.master->notes().front();
  b.master->shut_down();
}

// Bus time as the virtual segment accounts it: bytes at 100 Mbit/s, the line there and back, and what stations take.
TEST(Master, eight_stations_come_from_scan_to_op_in_the_time_that_they_may_take) {
  for (const bool dc : {false, true}) {
    BusBench b;
    config::Machine eight;
    eight.bus = b.machine.bus;
    for (int i = 0; i < 8; ++i) {
      auto s = b.machine.stations[2];  // AMD530B: mailbox, PDO mapping, start-up objects
      s.id = StationId{static_cast<std::uint16_t>(i)};
      s.position = i;
      s.name = "s" + std::to_string(i);
      s.profile.dc = dc;
      eight.stations.push_back(s);
    }
    sim::Segment segment(eight, b.clock);
    sim::SegmentPort port(segment, b.clock);
    EthercatMaster master(eight, port, b.clock);
    const Time begin = b.clock.now();
    const auto up = master.bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    Time due = master.first_cycle(b.clock.now());
    Exchange e;
    const auto cycle = [&] {
      b.clock.sleep_until(due);
      e = master.exchange(due + microseconds(400));
      due += milliseconds(1);
    };
    cycle();
    cycle();
    ASSERT_TRUE(master.request_operation());
    for (int i = 0; i < 2000 && e.ethercat.al_states != 8; ++i) cycle();
    ASSERT_EQ(e.ethercat.al_states, 8);
    const Time took = b.clock.now() - begin;
    RecordProperty(dc ? "eight_with_dc_ms" : "eight_without_dc_ms", static_cast<int>(took / milliseconds(1)));
    EXPECT_LT(took, dc ? milliseconds(600) : milliseconds(100));
  }
}

TEST(Master, the_bus_time_passes_half_a_cycle_before_sync0) {
  BusBench b;
  b.operate();
  b.cycles(3000);
  EXPECT_LT(std::abs(b.lock.error().count()), 1000);
  EXPECT_NEAR(static_cast<double>(b.last.reference_ns % 1'000'000), 500'000, 1000);
}

TEST(Master, clocks_that_drift_are_followed) {
  BusBench b;
  for (const auto& s : b.wired.stations)
    if (s.bus == config::BusKind::EtherCat) b.segment.set_clock_drift(s.id, s.position % 2 == 0 ? 60 : -80);
  b.operate();
  b.cycles(3000);
  EXPECT_LT(std::abs(b.lock.error().count()), 2000);
  EXPECT_EQ(b.last.ethercat.al_states, 8);
}

TEST(Master, drives_enable_without_a_step_and_follow_their_targets) {
  BusBench b;
  b.operate();
  std::vector<std::int64_t> before;
  for (const auto& d : b.drives) before.push_back(d.drive.feedback().counts.value);
  b.enable();
  for (std::size_t i = 0; i < b.drives.size(); ++i)
    EXPECT_LE(std::abs(b.drives[i].drive.feedback().counts.value - before[i]), 1) << "drive " << i;

  auto& x = b.of("X");
  const double from = x.drive.commanded();
  for (int i = 1; i <= 1000; ++i) {
    x.command.target = from + 5.0 * (1 - std::cos(std::numbers::pi * i / 1000));
    b.cycle();
    ASSERT_EQ(x.drive.feedback().fault, Fault::None);
    ASSERT_LT(std::abs(x.drive.feedback().position - x.command.target), 0.5);
  }
  b.cycles(100);
  EXPECT_NEAR(x.drive.feedback().position, from + 10.0, 0.002);
}

TEST(Master, an_axis_homes_and_its_switch_has_the_configured_coordinate) {
  BusBench b;
  b.operate();
  for (const char* name : {"Z", "X", "U"}) {
    const auto* axis = config::find_axis(b.machine, name);
    const auto& ref = axis->drives.front();
    const auto& profile = b.machine.stations[ref.station.value].profile;
    const auto rows = homing_objects(profile, ref.slot, *axis);
    ASSERT_TRUE(rows) << to_text(rows.error());
    for (const auto& row : *rows) {
      const auto ok = b.master->write_object(ref.station, row.address, to_bytes(row.type, row.value));
      ASSERT_TRUE(ok) << name << " " << to_text(ok.error());
    }
    auto& d = b.of(name);
    d.command = {.goal = DriveGoal::Enabled, .target = d.drive.commanded()};
    b.until([&] { return d.command.target = d.drive.commanded(), d.drive.feedback().takes_targets; }, 1000);
    HomingRun run;
    const double span = axis->p_max - axis->p_min;
    run.start({.timeout_cycles = 60'000, .travel_counts = std::llround(1.5 * span * axis->counts_per_unit)},
              d.drive.feedback());
    b.until([&] { return d.command = run.step(d.drive.feedback()), !run.busy(); }, 70'000);
    ASSERT_EQ(run.phase(), HomingRun::Phase::Done) << name << " " << code(run.fault()).text;
    d.drive.set_reference(Counts{0}, axis->homing->position);
    d.command = {.goal = DriveGoal::Enabled, .target = d.drive.commanded()};
    b.cycles(50);
    EXPECT_EQ(d.drive.feedback().fault, Fault::None);
    EXPECT_NEAR(d.drive.feedback().position, b.segment.motor(axis->id).position(), 0.02) << name;
    EXPECT_NEAR(d.drive.feedback().position, axis->homing->position, 0.5) << name;
  }
}

TEST(Master, the_probe_latches_the_place_of_the_touch) {
  BusBench b;
  b.operate();
  b.enable();
  b.touches();
}

TEST(Master, a_drive_that_is_swapped_with_another_kind_is_refused_with_both_names) {
  BusBench b;
  for (auto& s : b.machine.stations) {
    if (s.name == "x") s.position = 2;
    if (s.name == "y1") s.position = 1;
  }
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::IdentityMismatch);
  const std::string text = to_text(up.error());
  EXPECT_NE(text.find("position 1"), std::string::npos) << text;
  EXPECT_NE(text.find("'y1'"), std::string::npos) << text;
  EXPECT_NE(text.find("AMD530B"), std::string::npos) << text;
  EXPECT_NE(text.find("iD286"), std::string::npos) << text;
}

TEST(Master, an_identity_that_nobody_has_is_refused_and_accepted_only_where_it_is_assumed) {
  for (const bool assumed : {true, false}) {
    BusBench b;
    for (auto& s : b.machine.stations) {
      s.profile.identity.product ^= s.name == "x" || s.name == "z" ? 0x1000u : 0u;
      s.profile.identity.assumed = assumed;
    }
    const auto refused = b.bring_up();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::IdentityMismatch);
    EXPECT_NE(to_text(refused.error()).find("station 1 'x'"), std::string::npos) << to_text(refused.error());
    EXPECT_EQ(refused.error().message.find("--accept") != std::string::npos, assumed) << refused.error().message;
  }
}

TEST(Master, a_missing_station_is_named) {
  BusBench b;
  b.segment.cut_link(5);
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::StationMissing);
  EXPECT_NE(up.error().message.find("'cu'"), std::string::npos) << up.error().message;
}

TEST(Master, a_station_without_output_watchdog_is_refused) {
  BusBench b;
  for (auto& s : b.machine.stations)
    if (s.name == "io") s.profile.watchdog_ms = 0;
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::WatchdogDisabled);
  EXPECT_NE(up.error().where.find("'io'"), std::string::npos) << up.error().where;
}

TEST(Master, a_dead_cable_is_told_as_such) {
  BusBench b;
  b.segment.cut_link(0);
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::BusDown);
}

TEST(Master, objects_are_read_and_written_also_while_the_bus_cycles) {
  BusBench b;
  b.operate();
  const auto y1 = b.machine.stations[2].id;
  ASSERT_TRUE(b.master->write_object(y1, {0x6099, 1}, to_bytes(config::ObjectType::U32, 12345)));
  b.cycles(3);
  const auto back = b.master->read_object(y1, {0x6099, 1});
  ASSERT_TRUE(back) << to_text(back.error());
  EXPECT_EQ(to_number(config::ObjectType::U32, *back), 12345);
  const auto name = b.master->read_object(y1, {0x1008, 0});
  EXPECT_TRUE(name) << to_text(name.error());
  const auto none = b.master->read_object(y1, {0x5FFF, 0});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, Fault::SdoAbort);
  EXPECT_NE(none.error().message.find("object does not exist"), std::string::npos) << none.error().message;
  const auto io = b.master->read_object(StationId{0}, {0x1008, 0});  // no mailbox
  ASSERT_FALSE(io);
  EXPECT_EQ(io.error().fault, Fault::MailboxProtocol);
  b.cycles(10);
  EXPECT_EQ(b.last.ethercat.al_states, 8);
}

TEST(Master, a_lost_frame_a_cut_link_and_a_drive_fault_are_told_apart) {
  BusBench b;
  b.operate();
  b.enable();
  b.segment.lose_frames(1);
  b.cycle();
  EXPECT_EQ(b.last.fault, Fault::FrameLost);
  b.cycle();
  EXPECT_EQ(b.last.fault, Fault::None);

  b.segment.drive_fault(config::find_axis(b.machine, "Y")->id, 1, 0x3210);
  auto& y2 = b.of("Y", 1);
  b.until([&] { return y2.drive.feedback().state == DriveState::Fault; }, 2000);
  EXPECT_EQ(y2.drive.feedback().fault, Fault::DriveFault);
  EXPECT_EQ(y2.drive.feedback().error_code, 0x3210);
  y2.command = {.goal = DriveGoal::FaultReset};
  EXPECT_LT(b.until([&] { return y2.drive.feedback().state == DriveState::SwitchOnDisabled; }, 100), 100);

  b.segment.cut_link(4);
  b.cycle();
  EXPECT_EQ(b.last.fault, Fault::TooFewTookPart);
  EXPECT_FALSE(b.last.inputs_fresh);
  const auto check = b.master->check_operation();
  ASSERT_FALSE(check);
  EXPECT_NE(check.error().where.find("'z'"), std::string::npos) << to_text(check.error());
}

TEST(Master, a_station_that_lost_its_power_comes_back_with_its_whole_record_while_the_others_go_on) {
  for (const char* name : {"cu", "z", "y1"}) {
    SCOPED_TRACE(name);
    BusBench b;
    b.operate();
    const auto& lost = *std::ranges::find(b.machine.stations, name, &config::Station::name);
    const auto& before = *std::ranges::find(b.machine.stations, 0, &config::Station::position);
    b.segment.power_cycle(lost.id, milliseconds(300));
    const Time power_returns = b.clock.now() + milliseconds(300);
    int stale_before = 0;
    b.master->step_by([&] {
      b.cycle();
      stale_before += !b.master->fresh(before.id);
    });
    b.cycles(20);
    EXPECT_FALSE(b.master->fresh(lost.id));
    EXPECT_TRUE(b.master->fresh(before.id));
    const auto gone = bring_back_all(*b.master);  // it is still dark
    ASSERT_FALSE(gone);
    EXPECT_EQ(gone.error().fault, Fault::StationMissing);
    b.until([&] { return b.clock.now() >= power_returns; }, 1000);
    const Time answers = b.clock.now();
    stale_before = 0;
    const auto back = bring_back_all(*b.master);
    ASSERT_TRUE(back) << to_text(back.error());
    RecordProperty(std::string("recovered_ms_") + name, static_cast<int>((b.clock.now() - answers) / milliseconds(1)));
    EXPECT_LT(b.clock.now() - answers, milliseconds(500));
    EXPECT_EQ(stale_before, 0);  // the station before the gap exchanged in every cycle
    b.cycles(200);
    EXPECT_EQ(b.last.fault, Fault::None);
    EXPECT_EQ(b.last.ethercat.working_counter, b.last.ethercat.expected);
    EXPECT_EQ(b.last.ethercat.al_states, 8);
    // What the record wrote is there again: start-up objects, PDO map, SYNC0, clock.
    for (const auto& row : lost.profile.startup) {
      const auto value = b.master->read_object(lost.id, row.address);
      ASSERT_TRUE(value) << to_text(value.error());
      EXPECT_EQ(to_number(row.type, *value), row.value) << std::hex << row.address.index;
    }
    const auto map = b.master->read_pdo_map(lost.id);
    ASSERT_TRUE(map) << to_text(map.error());
    std::size_t bits = 0, wanted = 0;
    for (const auto& pdo : map->pdos) bits += pdo.bits();
    for (const auto* pdos : {&lost.profile.rx_pdos, &lost.profile.tx_pdos}) wanted += 8 * image_bytes(*pdos);
    EXPECT_EQ(bits, wanted);
    const auto clocks = b.master->dc_status();
    ASSERT_TRUE(clocks) << to_text(clocks.error());
    const DcStatus& clock = (*clocks)[static_cast<std::size_t>(lost.position)];
    EXPECT_EQ(clock.activation, wire::kDcActivateCyclic | wire::kDcActivateSync0);
    EXPECT_LT(std::abs(clock.difference_ns), 1000);
    EXPECT_EQ(clock.next_sync0_ns % 1'000'000, 0u);  // in step with the others
    b.enable();                                      // and it works
  }
}

TEST(Master, a_cable_that_was_cut_and_healed_is_picked_up_without_writing_everything_again) {
  BusBench b;
  b.operate();
  b.segment.cut_link(4);
  b.cycles(300);
  b.master->step_by([&] { b.cycle(); });
  EXPECT_FALSE(bring_back_all(*b.master));
  b.segment.heal_link(4);
  b.cycles(5);
  const Time begin = b.clock.now();
  const auto back = bring_back_all(*b.master);
  ASSERT_TRUE(back) << to_text(back.error());
  RecordProperty("picked_up_ms", static_cast<int>((b.clock.now() - begin) / milliseconds(1)));
  b.cycles(150);
  EXPECT_EQ(b.last.fault, Fault::None);
  EXPECT_EQ(b.last.ethercat.al_states, 8);
}

TEST(Master, another_device_at_the_place_of_one_that_went_away_is_not_taken) {
  BusBench b;
  b.operate();
  auto& z = *std::ranges::find(b.machine.stations, "z", &config::Station::name);
  b.segment.power_cycle(z.id, milliseconds(100));
  b.cycles(200);
  const auto index = static_cast<std::size_t>(z.position);
  const_cast<StationRecord&>(b.master->stations()[index]).sii.serial += 1;  // it was another one
  b.master->step_by([&] { b.cycle(); });
  const auto back = bring_back_all(*b.master);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().fault, Fault::IdentityMismatch);
  EXPECT_NE(back.error().where.find("'z'"), std::string::npos) << back.error().where;
}

TEST(Master, objects_errors_and_clocks_are_asked_while_the_bus_cycles_and_no_cycle_is_lost) {
  BusBench b;
  b.operate();
  int bad = 0;
  b.master->step_by([&] {
    b.cycle();
    bad += b.last.fault != Fault::None;
  });
  const auto y1 = b.machine.stations[2].id;
  EXPECT_TRUE(b.master->read_object(y1, {0x1018, 0}, SdoAccess::Complete));
  EXPECT_TRUE(b.master->read_pdo_map(y1));
  EXPECT_TRUE(b.master->error_counters());
  const auto clocks = b.master->dc_status();
  ASSERT_TRUE(clocks);
  EXPECT_EQ(clocks->size(), 6u);
  EXPECT_TRUE(b.master->take_emergencies().empty());
  StationHealth h;
  b.cycles(12);
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(b.master->health(i, h));
    EXPECT_EQ(h.stale_cycles, 0u);
  }
  EXPECT_EQ(bad, 0);
}

TEST(Master, a_machine_file_without_stations_takes_strangers_by_what_they_say_of_themselves) {
  for (const MapKind map : {MapKind::Separate, MapKind::Overlapped}) {
    BusBench b;
    b.machine = {};
    const auto up = b.bring_up({.map = map, .strangers = true});
    ASSERT_TRUE(up) << to_text(up.error());
    ASSERT_EQ(b.master->stations().size(), 6u);
    b.cycles(20);
    EXPECT_EQ(b.last.fault, Fault::None) << b.last.ethercat.working_counter << " of " << b.last.ethercat.expected;
    ASSERT_TRUE(b.master->request_operation());
    b.cycles(200);
    EXPECT_EQ(b.last.fault, Fault::None);
    EXPECT_EQ(b.last.ethercat.al_states, 8);
    const auto all = b.master->check_operation();
    EXPECT_TRUE(all) << to_text(all.error());
    b.master->shut_down();
  }
}

TEST(Master, every_drive_stops_by_quick_stop_and_can_be_enabled_again) {
  BusBench b;
  b.operate();
  b.enable();
  // AMD530B with 605Ah = 6 stays in quick stop and wants its controlword switched back (manual 8.4).
  const auto y1 = b.machine.stations[2].id;
  ASSERT_TRUE(b.master->write_object(y1, {0x605A, 0}, to_bytes(config::ObjectType::I16, 6)));
  for (auto& d : b.drives) d.command.goal = DriveGoal::QuickStop;
  b.until(
      [&] {
        return std::ranges::all_of(b.drives,
                                   [](auto& d) { return reached(d.drive.feedback().state, DriveGoal::QuickStop); });
      },
      2000);
  b.cycles(100);
  for (const auto& d : b.drives) {
    const DriveState s = d.drive.feedback().state;
    EXPECT_TRUE(s == DriveState::QuickStopActive || s == DriveState::SwitchOnDisabled) << name(s);
    EXPECT_EQ(d.drive.feedback().fault, Fault::None) << code(d.drive.feedback().fault).text;
  }
  EXPECT_EQ(b.of("Y").drive.feedback().state, DriveState::QuickStopActive);
  b.enable();
}

TEST(Master, a_station_whose_outputs_stop_falls_back_by_its_watchdog_and_says_why) {
  BusBench b;
  b.operate();
  b.clock.sleep_until(b.due + milliseconds(500));
  b.due = b.master->first_cycle(b.clock.now());
  b.cycles(3);
  EXPECT_NE(b.last.ethercat.al_states & wire::kAlStateMask, 8);
  const auto check = b.master->check_operation();
  ASSERT_FALSE(check);
  EXPECT_EQ(check.error().fault, Fault::StationLeftOp);
  EXPECT_NE(check.error().message.find("watchdog"), std::string::npos) << check.error().message;
}

// In a real run the loop is a thread of its own, and what the run thread asks rides in its frames.
TEST(Master, objects_are_reached_through_the_loops_frames_when_it_runs_in_a_thread_of_its_own) {
  config::Machine machine = reference_machine();
  MonotonicClock clock;
  sim::Segment segment(machine, clock);
  sim::SegmentPort port(segment, clock);
  EthercatMaster master(machine, port, clock);
  const auto up = master.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  std::atomic<bool> running{false}, stop{false};
  std::thread loop([&] {
    while (!stop) {
      master.exchange(clock.now() + milliseconds(1));
      running = true;
      clock.sleep_until(clock.now() + microseconds(200));
    }
  });
  while (!running) std::this_thread::yield();
  const auto y1 = machine.stations[2].id;
  for (int i = 0; i < 10; ++i) {
    const auto wrote = master.write_object(y1, {0x6099, 1}, to_bytes(config::ObjectType::U32, 1000 + i));
    EXPECT_TRUE(wrote) << to_text(wrote.error());
    const auto back = master.read_object(y1, {0x6099, 1});
    ASSERT_TRUE(back) << to_text(back.error());
    EXPECT_EQ(to_number(config::ObjectType::U32, *back), 1000 + i);
  }
  EXPECT_FALSE(master.check_operation());  // still in SAFE_OP, and nobody hangs
  stop = true;
  loop.join();
  const auto after = master.read_object(y1, {0x6041, 0});  // the loop stands: named, in bounded time
  EXPECT_FALSE(after);
  master.shut_down();
}

// Wireshark's dissectors are the judge of every byte that both sides send.
TEST(Master, tshark_finds_nothing_malformed_in_a_bring_up) {
  ASSERT_EQ(std::system("command -v tshark >/dev/null 2>&1"), 0) << "scripts/setup installs it";
  BusBench b;
  const std::string file = std::string(GANTRY_BINARY_DIR) + "/bring_up.pcap";
  PcapTap tap(b.port, b.clock, file);
  b.port_used = &tap;
  b.operate();
  b.cycles(50);
  tap.flush();
  const auto number = [&](const std::string& tshark_and_what_counts) {
    const std::string command = "tshark -r " + file + " " + tshark_and_what_counts;
    FILE* pipe = popen(command.c_str(), "r");
    int n = -1;
    if (pipe == nullptr || std::fscanf(pipe, "%d", &n) != 1) n = -1;
    if (pipe != nullptr) pclose(pipe);
    return n;
  };
  const auto count = [&](const std::string& filter) { return number("-Y '" + filter + "' 2>/dev/null | wc -l"); };
  // Stations come up side by side: one frame carries the mailboxes of several.
  const auto messages = [&](const std::string& field) {
    return number("-T fields -E occurrence=a -e " + field + " 2>/dev/null | tr ',' '\\n' | grep -c .");
  };
  EXPECT_EQ(count("_ws.malformed || _ws.expert.severity == error"), 0);
  EXPECT_EQ(count("ecat"), static_cast<int>(tap.frames()));
  EXPECT_GT(messages("ecat_mailbox.coe.sdoreq"), 100);
  EXPECT_GT(messages("ecat_mailbox.coe.sdores"), 100);
  EXPECT_GT(count("ecat.cmd == 12"), 100);  // LRW
}

}  // namespace
}  // namespace gantry::devices
