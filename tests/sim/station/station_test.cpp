// One station through its states, byte by byte: AL status codes (ETG.1000.6 table 11, ETG.1020), mailbox and SDO
// (ETG.1000.6, 5.6), PDO mapping, watchdog and distributed clock.
#include "sim/station/station.hpp"

#include <gtest/gtest.h>

#include "sim/segment/segment.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

constexpr std::uint16_t kStation = 0x1001;

struct OneAmd : ::testing::Test {
  config::Machine machine = one("drives/amd530b.yaml");
  VirtualClock clock;
  Segment segment{machine, clock};
  RawMaster bus{segment, clock};

  void SetUp() override { bus.address_all(); }
  void pre_op() {
    bus.mailboxes(kStation);
    ASSERT_EQ(bus.request(kStation, 2), 2);
  }
  /// 6040, 607A out (6 bytes); 6041, 6064 in: the mapping at power-on.
  void process_data() {
    bus.sync_manager(kStation, 2, 0x1100, 6, 0x64);
    bus.sync_manager(kStation, 3, 0x1400, 6, 0x20);
    bus.fmmu(kStation, 0, 0, 6, 0x1100, 2);
    bus.fmmu(kStation, 1, 0, 6, 0x1400, 1);
  }
  void safe_op() {
    pre_op();
    process_data();
    ASSERT_EQ(bus.request(kStation, 4), 4);
  }
  void op() {
    safe_op();
    bus.request(kStation, 8);
    bus.logical(12, 0, Raw(6));
    ASSERT_EQ(bus.state(kStation), 8);
  }
};

TEST_F(OneAmd, goes_up_and_down_through_its_states) {
  op();
  EXPECT_EQ(bus.request(kStation, 4), 4);
  EXPECT_EQ(bus.request(kStation, 2), 2);
  EXPECT_EQ(bus.request(kStation, 1), 1);
  EXPECT_EQ(bus.status_code(kStation), 0);
}

TEST_F(OneAmd, refuses_what_is_no_step_up) {
  for (const unsigned wanted : {4u, 8u}) {
    EXPECT_EQ(bus.request(kStation, wanted), 0x11);
    EXPECT_EQ(bus.status_code(kStation), 0x11);
    EXPECT_EQ(bus.request(kStation, 1 | 0x10), 1);  // acknowledged
  }
  EXPECT_EQ(bus.request(kStation, 5), 0x11);
  EXPECT_EQ(bus.status_code(kStation), 0x12);
  EXPECT_EQ(bus.request(kStation, 0x11), 1);
  EXPECT_EQ(bus.request(kStation, 3), 0x11);
  EXPECT_EQ(bus.status_code(kStation), 0x13);
}

TEST_F(OneAmd, bootstrap_is_not_supported_in_init_and_no_step_from_elsewhere) {
  EXPECT_EQ(bus.request(kStation, 3), 0x11);
  EXPECT_EQ(bus.status_code(kStation), 0x13);
  EXPECT_EQ(bus.request(kStation, 0x11), 1);
  pre_op();
  EXPECT_EQ(bus.request(kStation, 3), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x11);
  EXPECT_EQ(bus.request(kStation, 0x12), 2);
  process_data();
  ASSERT_EQ(bus.request(kStation, 4), 4);
  EXPECT_EQ(bus.request(kStation, 3), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x11);
}

TEST_F(OneAmd, an_error_stands_until_it_is_acknowledged) {
  EXPECT_EQ(bus.request(kStation, 2), 0x11);  // no mailboxes
  EXPECT_EQ(bus.status_code(kStation), 0x16);
  bus.mailboxes(kStation);
  EXPECT_EQ(bus.request(kStation, 2), 0x11);
  EXPECT_EQ(bus.request(kStation, 2 | 0x10), 2);
  EXPECT_EQ(bus.status_code(kStation), 0);
}

TEST_F(OneAmd, wants_its_mailboxes_where_the_sii_says) {
  bus.sync_manager(kStation, 0, 0x1000, 120, 0x26);
  bus.sync_manager(kStation, 1, 0x1080, 128, 0x22);
  EXPECT_EQ(bus.request(kStation, 2), 0x11);
  EXPECT_EQ(bus.status_code(kStation), 0x16);
}

TEST_F(OneAmd, sync_managers_must_be_as_long_as_what_is_mapped) {
  pre_op();
  process_data();
  bus.sync_manager(kStation, 2, 0x1100, 7, 0x64);
  EXPECT_EQ(bus.request(kStation, 4), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x1D);
  bus.sync_manager(kStation, 2, 0x1100, 6, 0x64);
  bus.sync_manager(kStation, 3, 0x1400, 4, 0x20);
  EXPECT_EQ(bus.request(kStation, 4 | 0x10), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x1E);
  bus.sync_manager(kStation, 3, 0x1400, 6, 0x20);
  EXPECT_EQ(bus.request(kStation, 4 | 0x10), 4);
}

TEST_F(OneAmd, op_waits_for_outputs_and_gives_up_in_the_end) {
  safe_op();
  EXPECT_EQ(bus.request(kStation, 8), 4);
  bus.wait(milliseconds(900));
  EXPECT_EQ(bus.state(kStation), 4);
  bus.wait(milliseconds(200));
  EXPECT_EQ(bus.state(kStation), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x1B);
}

TEST_F(OneAmd, a_working_counter_of_lrw_is_three) {
  safe_op();
  EXPECT_EQ(bus.logical(12, 0, Raw(6)).wkc, 3);
  EXPECT_EQ(bus.logical(10, 0, Raw(6)).wkc, 1);
  EXPECT_EQ(bus.logical(11, 0, Raw(6)).wkc, 1);
}

TEST_F(OneAmd, the_watchdog_takes_it_out_of_op_when_outputs_stop) {
  bus.write(kStation, 0x0400, 2498, 2);
  bus.write(kStation, 0x0420, 200, 2);  // 20 ms
  op();
  for (int i = 0; i < 50; ++i) bus.wait(milliseconds(15)), bus.logical(12, 0, Raw(6));
  EXPECT_EQ(bus.state(kStation), 8);
  EXPECT_EQ(value(bus.read(kStation, 0x0440, 1).data), 1u);
  bus.wait(milliseconds(19));
  EXPECT_EQ(bus.state(kStation), 8);
  bus.wait(milliseconds(2));
  EXPECT_EQ(bus.state(kStation), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x1B);
  EXPECT_EQ(value(bus.read(kStation, 0x0440, 1).data), 0u);
  EXPECT_EQ(value(bus.read(kStation, 0x0442, 1).data), 1u);
}

TEST_F(OneAmd, a_watchdog_of_zero_never_expires) {
  bus.write(kStation, 0x0420, 0, 2);
  op();
  bus.wait(milliseconds(5000));
  EXPECT_EQ(bus.state(kStation), 8);
}

TEST_F(OneAmd, taking_a_sync_manager_away_in_op_is_an_error_of_its_configuration) {
  op();
  bus.sync_manager(kStation, 3, 0x1400, 6, 0x20, false);
  EXPECT_EQ(bus.state(kStation), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x1E);
}

// --- Mailbox and SDO

TEST_F(OneAmd, a_full_mailbox_takes_no_other_and_an_empty_one_gives_none) {
  pre_op();
  EXPECT_EQ(bus.read(kStation, 0x1080, 128).wkc, 0);
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x13} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  request.resize(128);
  EXPECT_EQ(bus.write(kStation, 0x1000, request), 1);
  EXPECT_EQ(value(bus.read(kStation, 0x080D, 1).data), 0x09u);  // answered: send mailbox full
  const Answer reply = bus.read(kStation, 0x1080, 128);
  EXPECT_EQ(reply.wkc, 1);
  EXPECT_EQ(reply.data[5], 0x13);  // CoE, counter 1
  EXPECT_EQ(bus.read(kStation, 0x1080, 128).wkc, 0);
  EXPECT_EQ(value(bus.read(kStation, 0x080D, 1).data), 0x02u);  // read
}

TEST_F(OneAmd, a_lost_reply_is_given_again_on_the_repeat_bit) {
  pre_op();
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x13} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  request.resize(128);
  bus.write(kStation, 0x1000, request);
  const Answer lost = bus.read(kStation, 0x1080, 128);
  bus.write(kStation, 0x080E, 0x03, 1);  // toggle
  EXPECT_EQ(value(bus.read(kStation, 0x080F, 1).data) & 2u, 2u);
  const Answer again = bus.read(kStation, 0x1080, 128);
  EXPECT_EQ(again.wkc, 1);
  EXPECT_EQ(again.data, lost.data);
  // The same request with the same counter is not served twice.
  bus.write(kStation, 0x1000, request);
  EXPECT_EQ(bus.read(kStation, 0x1080, 128).wkc, 0);
}

TEST_F(OneAmd, init_forgets_what_was_in_the_mailbox) {
  pre_op();
  const Raw read_type = bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  ASSERT_TRUE(bus.mailbox(kStation, read_type));
  // A download in segments that does not get beyond its announcement.
  ASSERT_TRUE(bus.mailbox(kStation, bytes(0x2000, 2) + Raw{0x21, 0x7D, 0x60, 1} + bytes(4, 4)));
  bus.write(kStation, 0x080E, 0x03, 1);  // and an answer that is asked for again, and not fetched
  EXPECT_EQ(value(bus.read(kStation, 0x080D, 1).data) & 8u, 8u);
  ASSERT_EQ(bus.request(kStation, 1), 1);
  pre_op();  // clears the SyncManagers and their repeat bit
  EXPECT_EQ(value(bus.read(kStation, 0x080D, 1).data) & 8u, 0u);
  bus.write(kStation, 0x080E, 0x03, 1);
  EXPECT_EQ(value(bus.read(kStation, 0x080D, 1).data) & 8u, 0u);  // nothing to repeat
  EXPECT_EQ(value(bus.read(kStation, 0x080F, 1).data) & 2u, 2u);  // which is acknowledged all the same
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x13} + read_type;
  request.resize(128);
  EXPECT_EQ(bus.write(kStation, 0x1000, request), 1);
  const Answer first = bus.read(kStation, 0x1080, 128);
  EXPECT_EQ(first.wkc, 1);
  EXPECT_EQ(first.data[5] >> 4, 1);  // counted from the beginning
  const auto segment_reply = bus.mailbox(kStation, bytes(0x2000, 2) + Raw{0x01} + bytes(0, 7));
  ASSERT_TRUE(segment_reply);
  EXPECT_EQ((*segment_reply)[2], 0x80);
  EXPECT_EQ(value(*segment_reply, 6, 4), 0x05040001u);  // no transfer is under way
}

TEST_F(OneAmd, sdo_reads_and_writes_numbers) {
  pre_op();
  EXPECT_EQ(bus.sdo_read(kStation, 0x1018, 0), 4u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x1018, 1), machine.stations[0].profile.identity.vendor);
  EXPECT_EQ(bus.sdo_write(kStation, 0x6098, 0, 19, 1), 0u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x6098, 0), 19u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x607A, 0, 0xFFFFFF00, 4), 0u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x607A, 0), 0xFFFFFF00u);
}

TEST_F(OneAmd, sdo_refuses_with_the_codes_of_the_standard) {
  pre_op();
  EXPECT_EQ(bus.sdo_write(kStation, 0x5FFF, 0, 0, 2), 0x06020000u);    // no such object
  EXPECT_EQ(bus.sdo_write(kStation, 0x6099, 9, 0, 4), 0x06090011u);    // no such sub-index
  EXPECT_EQ(bus.sdo_write(kStation, 0x6041, 0, 0, 2), 0x06010002u);    // read only
  EXPECT_EQ(bus.sdo_write(kStation, 0x6040, 0, 0, 4), 0x06070012u);    // too long
  EXPECT_EQ(bus.sdo_write(kStation, 0x607A, 0, 0, 2), 0x06070013u);    // too short
  EXPECT_EQ(bus.sdo_write(kStation, 0x6098, 0, 100, 1), 0x06090031u);  // range 0..35
  EXPECT_FALSE(bus.sdo_read(kStation, 0x4000, 0));
  EXPECT_EQ(bus.abort, 0x06020000u);
  // Segments without a beginning are no command.
  const auto segment_first = bus.mailbox(kStation, bytes(0x2000, 2) + Raw{0x60, 0, 0, 0} + bytes(0, 4));
  EXPECT_EQ(value(*segment_first, 6, 4), 0x05040001u);
}

TEST_F(OneAmd, a_string_comes_in_one_mailbox_when_it_fits) {
  pre_op();
  const auto reply = bus.mailbox(kStation, bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));
  ASSERT_TRUE(reply);
  EXPECT_EQ((*reply)[2], 0x41);  // normal, size indicated
  const auto size = value(*reply, 6, 4);
  EXPECT_EQ(reply->size(), 10 + size);
  EXPECT_EQ(std::string(reply->begin() + 10, reply->end()), machine.stations[0].profile.title);
}

TEST_F(OneAmd, other_protocols_are_answered_with_a_mailbox_error) {
  pre_op();
  Raw foe = bytes(6, 2) + bytes(0, 2) + Raw{0, 0x14} + bytes(1, 2) + bytes(0, 4);
  foe.resize(128);
  bus.write(kStation, 0x1000, foe);
  const auto reply = bus.fetch(kStation);
  ASSERT_TRUE(reply);
  EXPECT_EQ(bus.mailbox_type, 0);
  EXPECT_EQ(*reply, bytes(1, 2) + bytes(2, 2));  // error reply: unsupported protocol
}

TEST(Storage, keeps_what_the_manual_says_through_a_power_cycle) {
  for (const auto& [file, save] : {std::pair{"drives/amd530b.yaml", true}, std::pair{"drives/std402ec.yaml", false}}) {
    config::Machine machine = one(file, 0);
    VirtualClock clock;
    Segment segment(machine, clock);
    RawMaster bus(segment, clock);
    const std::uint16_t kept = save ? 0x2000 : 0x20F1;
    const auto up = [&] {
      bus.address_all();
      bus.mailboxes(kStation);
      EXPECT_EQ(bus.request(kStation, 2), 2);
    };
    up();
    EXPECT_EQ(bus.sdo_write(kStation, kept, 0, 1234, 2), 0u);
    EXPECT_EQ(bus.sdo_write(kStation, 0x6098, 0, 19, 1), 0u);
    const auto cycle = [&] {
      segment.power_cycle(StationId{0}, milliseconds(5));
      bus.wait(milliseconds(6));
      up();
    };
    cycle();
    EXPECT_NE(bus.sdo_read(kStation, 0x6098, 0), 19u);
    if (save) {
      EXPECT_NE(bus.sdo_read(kStation, kept, 0), 1234u);
      EXPECT_EQ(bus.sdo_write(kStation, kept, 0, 1234, 2), 0u);
      EXPECT_EQ(bus.sdo_write(kStation, 0x1010, 2, 0x11111111, 4), 0x08000020u);
      EXPECT_EQ(bus.sdo_write(kStation, 0x1010, 2, 0x65766173, 4), 0u);
      cycle();
    }
    EXPECT_EQ(bus.sdo_read(kStation, kept, 0), 1234u);
  }
}

TEST_F(OneAmd, a_state_change_that_fails_is_an_emergency) {
  pre_op();
  EXPECT_EQ(bus.request(kStation, 4), 0x12);
  const auto message = bus.fetch(kStation);
  ASSERT_TRUE(message);
  EXPECT_EQ(value(*message, 0, 2), 0x1000u);  // CoE emergency
  EXPECT_EQ(value(*message, 2, 2), 0xA000u);  // PRE_OP to SAFE_OP
  EXPECT_EQ(value(*message, 5, 2), 0x1Du);    // diagnostic data: the AL status code
}

TEST_F(OneAmd, a_master_that_fetches_no_answers_finds_its_requests_not_taken) {
  pre_op();
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x03} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  request.resize(128);
  int taken = 0;
  while (taken < 100 && bus.write(kStation, 0x1000, request) == 1) ++taken;
  EXPECT_LT(taken, 30);
  int answers = 0;
  while (bus.fetch(kStation)) ++answers;
  EXPECT_EQ(answers, taken);
}

// --- Mapping

TEST_F(OneAmd, a_mapping_is_written_from_the_counts_inwards) {
  pre_op();
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 1, 0x60980008, 4), 0x06010003u);  // count is not 0
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 0, 0, 1), 0x06010000u);           // assigned
  bus.map(kStation, 0x1C12, 0x1600, {0x60400010, 0x60600008, 0x607A0020, 0x60B80010});
  bus.sync_manager(kStation, 2, 0x1100, 9, 0x64);
  bus.sync_manager(kStation, 3, 0x1400, 6, 0x20);
  EXPECT_EQ(bus.request(kStation, 4), 4);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1C12, 0, 0, 1), 0x08000022u);  // not in SAFE_OP
}

TEST_F(OneAmd, a_pdo_takes_what_its_limits_allow) {
  pre_op();
  EXPECT_EQ(bus.sdo_write(kStation, 0x1C12, 0, 0, 1), 0u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 0, 0, 1), 0u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 1, 0x5FFF0010, 4), 0x06020000u);  // no such object
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 1, 0x60410010, 4), 0x06040041u);  // an input
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 1, 0x60400020, 4), 0x06040041u);  // wrong width
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 1, 0x60980010, 4), 0x06040041u);
  for (unsigned i = 1; i <= 8; ++i)
    EXPECT_EQ(bus.sdo_write(kStation, 0x1600, static_cast<std::uint8_t>(i), 0x607A0020, 4), 0u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 9, 0x607A0020, 4), 0x06090011u);  // 8 entries at most (5.6.2)
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 0, 9, 1), 0x06040042u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1600, 0, 8, 1), 0u);  // 32 bytes exactly
}

// --- Distributed clock

struct Clocks : ::testing::Test {
  config::Machine machine = reference();
  VirtualClock clock;
  Segment segment{machine, clock};
  RawMaster bus{segment, clock};

  /// Delays and offsets as a master computes them from the receive times.
  void align() {
    const int n = bus.address_all();
    bus.send(8, 0, 0x0900, Raw(4));
    std::vector<std::int64_t> before(static_cast<std::size_t>(n)), span(before), local(before);
    for (int i = 0; i < n; ++i) {
      const auto station = static_cast<std::uint16_t>(0x1001 + i);
      const Raw times = bus.read(station, 0x0900, 8).data;
      const auto k = static_cast<std::size_t>(i);
      span[k] = i + 1 < n
                    ? static_cast<std::int32_t>(static_cast<std::uint32_t>(value(times, 4, 4) - value(times, 0, 4)))
                    : 0;
      local[k] = static_cast<std::int64_t>(value(bus.read(station, 0x0918, 8).data));
    }
    for (std::size_t i = 1; i < span.size(); ++i) before[i] = before[i - 1] + (span[i - 1] - span[i]) / 2;
    for (std::size_t i = 0; i < span.size(); ++i) {
      const auto station = static_cast<std::uint16_t>(0x1001 + i);
      // Local time when the frame passed, less the delay, is the reference's local time then.
      bus.write(station, 0x0920, static_cast<std::uint64_t>(local[0] - (local[i] - before[i])), 8);
      bus.write(station, 0x0928, static_cast<std::uint64_t>(before[i]), 4);
    }
    delays = before;
  }
  std::int64_t spread() {
    std::vector<std::int64_t> times;
    for (int i = 0; i < segment.station_count(); ++i)
      times.push_back(static_cast<std::int64_t>(segment.station(i).esc().dc().system(clock.now())));
    return *std::max_element(times.begin(), times.end()) - *std::min_element(times.begin(), times.end());
  }
  std::vector<std::int64_t> delays;
};

TEST_F(Clocks, receive_times_give_the_delay_of_each_hop) {
  align();
  for (std::size_t i = 1; i < delays.size(); ++i) EXPECT_EQ(delays[i] - delays[i - 1], delays[1]) << i;
  EXPECT_GT(delays[1], 300);
  EXPECT_LT(delays[1], 1500);
}

TEST_F(Clocks, offset_and_delay_bring_the_clocks_together) {
  EXPECT_GT(spread(), 100'000);
  align();
  EXPECT_LE(spread(), 1);
}

TEST_F(Clocks, drifting_clocks_are_held_by_the_reference_time_in_each_frame) {
  for (int i = 1; i < 6; ++i)
    segment.set_clock_drift(StationId{static_cast<std::uint16_t>(i)}, i % 2 == 0 ? 100.0 : -100.0);
  align();
  for (int i = 0; i < 5000; ++i) {
    bus.wait(milliseconds(1));
    bus.send(14, 0x1001, 0x0910, Raw(8));
  }
  EXPECT_LT(spread(), 1000);
  for (int i = 1; i < 6; ++i)
    EXPECT_LT(value(bus.read(static_cast<std::uint16_t>(0x1001 + i), 0x092C, 4).data) & 0x7FFFFFFF, 1000u) << i;
}

struct Hook final : WorldHook {
  std::vector<Time> at;
  void on_sync(std::uint64_t cycle, Time now) noexcept override {
    EXPECT_EQ(cycle, last + 1);
    last = cycle;
    at.push_back(now);
  }
  std::uint64_t last = static_cast<std::uint64_t>(-1);
};

TEST_F(Clocks, sync0_comes_at_its_start_and_then_every_cycle_whether_frames_come_or_not) {
  align();
  const std::uint64_t now = segment.station(0).esc().dc().system(clock.now());
  const std::uint64_t start = (now / 1'000'000 + 20) * 1'000'000;
  for (std::uint16_t s = 0x1001; s <= 0x1006; ++s) {
    bus.write(s, 0x0990, start, 8);
    bus.write(s, 0x09A0, 1'000'000, 4);
    bus.write(s, 0x0981, 3, 1);
  }
  const Time first = clock.now() + Time{static_cast<std::int64_t>(start - now)};
  bus.wait(first - clock.now() - microseconds(1));
  segment.advance();
  Hook hook;
  hook.last = segment.cycles() - 1;
  segment.set_world(&hook);
  bus.wait(milliseconds(50));
  bus.send(7, 0, 0, Raw(1));
  ASSERT_EQ(hook.at.size(), 50u);
  for (int i = 0; i < 50; ++i)
    EXPECT_LE(std::abs((hook.at[static_cast<std::size_t>(i)] - first - milliseconds(i)).count()), 2);
}

TEST_F(OneAmd, sync0_is_supervised) {
  pre_op();
  process_data();
  const auto system = [&] { return segment.station(0).esc().dc().system(clock.now()); };
  const auto start_sync = [&](std::uint64_t start, std::uint32_t cycle) {
    bus.write(kStation, 0x0981, 0, 1);
    bus.write(kStation, 0x0990, start, 8);
    bus.write(kStation, 0x09A0, cycle, 4);
    bus.write(kStation, 0x0981, 3, 1);
  };
  start_sync(system() + 1'000'000, 333'000);  // a cycle that the manual does not list
  EXPECT_EQ(bus.request(kStation, 4), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x36);
  start_sync(system() - 1000, 1'000'000);  // in the past: it never comes
  EXPECT_EQ(bus.request(kStation, 4 | 0x10), 4);
  EXPECT_EQ(bus.request(kStation, 8), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x2D);
  start_sync(system() + 1'000'000, 1'000'000);
  bus.write(kStation, 0x0120, 8 | 0x10, 2);
  for (int i = 0; i < 5; ++i) bus.wait(milliseconds(1)), bus.logical(12, 0, Raw(6));
  EXPECT_EQ(bus.state(kStation), 8);
  bus.write(kStation, 0x0981, 0, 1);
  EXPECT_EQ(bus.state(kStation), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x2C);
}

TEST_F(OneAmd, missed_outputs_count_up_to_the_limit_of_10f1) {
  pre_op();
  ASSERT_EQ(bus.sdo_write(kStation, 0x10F1, 2, 10, 4), 0u);
  process_data();
  bus.write(kStation, 0x0990, segment.station(0).esc().dc().system(clock.now()) + 1'000'000, 8);
  bus.write(kStation, 0x09A0, 1'000'000, 4);
  bus.write(kStation, 0x0981, 3, 1);
  bus.request(kStation, 4);
  bus.write(kStation, 0x0120, 8, 2);
  for (int i = 0; i < 20; ++i) bus.wait(milliseconds(1)), bus.logical(12, 0, Raw(6));
  EXPECT_EQ(bus.state(kStation), 8);
  bus.wait(milliseconds(3));
  EXPECT_EQ(bus.state(kStation), 8);
  bus.wait(milliseconds(3));
  EXPECT_EQ(bus.state(kStation), 0x14);
  EXPECT_EQ(bus.status_code(kStation), 0x1A);
}

// --- I/O station

TEST(InputsAndOutputs, show_at_the_terminals_only_in_op) {
  config::Machine machine = one("devices/dio16.yaml", 0);
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  bus.address_all();
  const StationId io{0};
  ASSERT_EQ(bus.request(kStation, 2), 2);
  bus.sync_manager(kStation, 0, 0x0F00, 2, 0x44);
  bus.sync_manager(kStation, 1, 0x1000, 2, 0x00);
  bus.fmmu(kStation, 0, 0, 2, 0x0F00, 2);
  bus.fmmu(kStation, 1, 2, 2, 0x1000, 1);
  ASSERT_EQ(bus.request(kStation, 4), 4);
  segment.set_io_inputs(io, 0xA55A);
  bus.wait(milliseconds(2));
  const Answer safe_op = bus.logical(12, 0, Raw{0x34, 0x12, 0, 0});
  EXPECT_EQ(safe_op.wkc, 3);
  EXPECT_EQ(value(safe_op.data, 2, 2), 0xA55Au);
  EXPECT_EQ(segment.io_outputs(io), 0);
  bus.request(kStation, 8);
  bus.logical(12, 0, Raw{0x34, 0x12, 0, 0});
  bus.wait(milliseconds(1));
  segment.advance();
  EXPECT_EQ(bus.state(kStation), 8);
  EXPECT_EQ(segment.io_outputs(io), 0x1234);
  bus.wait(milliseconds(101));  // watchdog
  segment.advance();
  EXPECT_EQ(segment.io_outputs(io), 0);
}

}  // namespace
}  // namespace gantry::sim::test
