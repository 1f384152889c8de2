// The virtual drives as a controller meets them: everything goes through the process image, values are those of the
// manuals' tables of typical values (iD286 10.1, AMD530B 6.2, STD402EC 11.1) and of IEC 61800-7-201.
#include <cmath>
#include <gtest/gtest.h>
#include <memory>

#include "sim/drive/drive402.hpp"
#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

/// One axis of a station in OP with SYNC0 at 1 kHz, stepped a cycle at a time. Process image of an axis: out 6040 (2),
/// 6060 (1), 607A (4), 60B8 (2); in 6041 (2), 6061 (1), 6064 (4), 603F (2), 60B9 (2), 60BA (4), 60FD (4).
struct Bench {
  static constexpr std::uint16_t kStation = 0x1001;
  static constexpr std::size_t kOut = 9, kIn = 19;

  /// As its machine file has it: the probe's input has the probe's function.
  void give_to_probe() {
    const config::StationProfile& profile = machine.stations[0].profile;
    for (const config::Parameter& p : profile.parameters)
      if (p.name == profile.drive->probe_input.parameter) {
        EXPECT_TRUE(segment->set_object(machine.stations[0].id, p.address, profile.drive->probe_input.value));
      }
  }
  explicit Bench(const std::string& file, int slots = 1, bool invert = false, double coast_mm_s2 = 0)
      : axes(static_cast<std::size_t>(slots)) {
    machine = one(file, slots);
    machine.sim.axes[0].coast = coast_mm_s2;
    machine.axes[0].drives[0].invert = invert;
    segment = std::make_unique<Segment>(machine, clock);
    give_to_probe();
    bus = std::make_unique<RawMaster>(*segment, clock);
    bus->address_all();
    bus->write(kStation, 0x0420, 1000, 2);
    bus->mailboxes(kStation);
    EXPECT_EQ(bus->request(kStation, 2), 2);
    map(0x1C12, 0x1600, {0x60400010, 0x60600008, 0x607A0020, 0x60B80010});
    map(0x1C13, 0x1A00, {0x60410010, 0x60610008, 0x60640020, 0x603F0010, 0x60B90010, 0x60BA0020, 0x60FD0020});
    const std::size_t n = axes.size();
    bus->sync_manager(kStation, 2, 0x1100, kOut * n, 0x64);
    bus->sync_manager(kStation, 3, 0x1400, kIn * n, 0x20);
    bus->fmmu(kStation, 0, 0, kOut * n, 0x1100, 2);
    bus->fmmu(kStation, 1, static_cast<std::uint32_t>(kOut * n), kIn * n, 0x1400, 1);
    bus->write(kStation, 0x0990, segment->station(0).esc().dc().system(clock.now()) + 1'500'000, 8);
    bus->write(kStation, 0x09A0, 1'000'000, 4);
    bus->write(kStation, 0x0981, 3, 1);
    EXPECT_EQ(bus->request(kStation, 4), 4);
    bus->write(kStation, 0x0120, 8, 2);
    step(5);
    EXPECT_EQ(bus->state(kStation), 8);
    for (auto& each : axes) each.target = each.position();
  }

  void map(std::uint16_t assignment, std::uint16_t pdo, const std::vector<std::uint32_t>& entries) {
    EXPECT_EQ(bus->sdo_write(kStation, assignment, 0, 0, 1), 0u);
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const auto index = static_cast<std::uint16_t>(pdo + k);
      EXPECT_EQ(bus->sdo_write(kStation, index, 0, 0, 1), 0u);
      for (std::size_t i = 0; i < entries.size(); ++i)
        EXPECT_EQ(bus->sdo_write(kStation, index, static_cast<std::uint8_t>(i + 1),
                                 entries[i] + (static_cast<std::uint32_t>(k) * 0x800 << 16), 4),
                  0u);
      EXPECT_EQ(bus->sdo_write(kStation, index, 0, entries.size(), 1), 0u);
      EXPECT_EQ(bus->sdo_write(kStation, assignment, static_cast<std::uint8_t>(k + 1), index, 2), 0u);
    }
    EXPECT_EQ(bus->sdo_write(kStation, assignment, 0, axes.size(), 1), 0u);
  }

  struct Axis {
    std::uint16_t control = 0;
    std::int8_t mode = 8;
    std::int32_t target = 0;
    std::uint16_t probe = 0;
    Raw in = Raw(kIn);
    [[nodiscard]] std::uint16_t status() const { return static_cast<std::uint16_t>(value(in, 0, 2)); }
    [[nodiscard]] std::int8_t mode_shown() const { return static_cast<std::int8_t>(in[2]); }
    [[nodiscard]] std::int32_t position() const { return static_cast<std::int32_t>(value(in, 3, 4)); }
    [[nodiscard]] std::uint16_t error() const { return static_cast<std::uint16_t>(value(in, 7, 2)); }
    [[nodiscard]] std::uint16_t probe_status() const { return static_cast<std::uint16_t>(value(in, 9, 2)); }
    [[nodiscard]] std::int32_t probe_value() const { return static_cast<std::int32_t>(value(in, 11, 4)); }
    [[nodiscard]] std::uint32_t inputs() const { return static_cast<std::uint32_t>(value(in, 15, 4)); }
  };

  void step(int cycles = 1) {
    for (int i = 0; i < cycles; ++i) {
      bus->wait(milliseconds(1));
      Raw image;
      for (const auto& each : axes)
        image = image + bytes(each.control, 2) + bytes(static_cast<std::uint8_t>(each.mode), 1) +
                bytes(static_cast<std::uint32_t>(each.target), 4) + bytes(each.probe, 2);
      for (const auto& each : axes) image = image + each.in;
      const Answer answer = bus->logical(12, 0, image);
      EXPECT_EQ(answer.wkc, 3);
      for (std::size_t k = 0; k < axes.size(); ++k) {
        const auto at = answer.data.begin() + static_cast<std::ptrdiff_t>(kOut * axes.size() + kIn * k);
        axes[k].in = Raw(at, at + kIn);
      }
    }
  }
  void command(std::uint16_t control, std::size_t k = 0) { axes[k].control = control, step(5); }
  void enable(std::int8_t mode = 8, std::size_t k = 0) {
    axes[k].mode = mode;
    axes[k].target = axes[k].position();
    for (const int control : {0x00, 0x06, 0x07, 0x0F}) command(static_cast<std::uint16_t>(control), k);
  }
  /// Straight to a target in CSP.
  void move_to(std::int32_t target, int cycles, std::size_t k = 0) {
    const std::int32_t from = axes[k].target;
    for (int i = 1; i <= cycles; ++i)
      axes[k].target = from + static_cast<std::int32_t>(std::int64_t{target - from} * i / cycles), step();
  }
  void homing_speeds(unsigned fast, unsigned slow, unsigned acceleration) {
    EXPECT_EQ(bus->sdo_write(kStation, 0x6099, 1, fast, 4), 0u);
    EXPECT_EQ(bus->sdo_write(kStation, 0x6099, 2, slow, 4), 0u);
    EXPECT_EQ(bus->sdo_write(kStation, 0x609A, 0, acceleration, 4), 0u);
  }
  void home(int method, int cycles) {
    EXPECT_EQ(bus->sdo_write(kStation, 0x6098, 0, static_cast<unsigned>(method), 1), 0u);
    enable(6);
    axes[0].control = 0x1F;
    step(cycles);
  }
  Motor& motor(std::size_t k = 0) { return segment->motor(AxisId{static_cast<std::uint8_t>(k)}); }

  config::Machine machine;
  VirtualClock clock;
  std::vector<Axis> axes;
  std::unique_ptr<Segment> segment;
  std::unique_ptr<RawMaster> bus;
  Axis& a = axes[0];
};

struct Words {
  const char* file;
  std::int8_t mode;
  int disabled, ready, on, enabled, fault;
};
class Statusword : public ::testing::TestWithParam<Words> {};

TEST_P(Statusword, is_what_the_manuals_table_prints) {
  const Words& w = GetParam();
  Bench b(w.file);
  b.a.mode = w.mode;
  b.command(0x00);
  EXPECT_EQ(b.a.status(), w.disabled) << std::hex << b.a.status();
  b.command(0x06);
  EXPECT_EQ(b.a.status(), w.ready) << std::hex << b.a.status();
  b.command(0x07);
  EXPECT_EQ(b.a.status(), w.on) << std::hex << b.a.status();
  b.command(0x0F);
  EXPECT_EQ(b.a.status(), w.enabled) << std::hex << b.a.status();
  EXPECT_EQ(b.a.mode_shown(), w.mode);
  b.segment->drive_fault(AxisId{0}, 0, 0x3210);
  b.step(5);
  EXPECT_EQ(b.a.status(), w.fault) << std::hex << b.a.status();
  EXPECT_EQ(b.a.error(), 0x3210);
  b.command(0x80);
  b.command(0x00);
  EXPECT_EQ(b.a.status(), w.disabled) << std::hex << b.a.status();
  EXPECT_EQ(b.a.error(), 0);
}
INSTANTIATE_TEST_SUITE_P(Manuals, Statusword,
                         ::testing::Values(Words{"drives/id286.yaml", 8, 0x250, 0x231, 0x233, 0x1237, 0x238},
                                           Words{"drives/id286.yaml", 6, 0x250, 0x231, 0x233, 0x8337, 0x238},
                                           Words{"drives/amd530b.yaml", 8, 0x650, 0x631, 0x633, 0x1637, 0x218},
                                           Words{"drives/amd530b.yaml", 6, 0x650, 0x631, 0x633, 0x8737, 0x638}));

TEST(Drive, moves_through_the_standards_states_only_along_its_transitions) {
  Bench b("drives/id286.yaml");
  b.command(0x0F);  // from switch-on disabled only 06h leads on
  EXPECT_EQ(b.a.status() & 0x4F, 0x40);
  b.command(0x06);
  b.command(0x0F);  // ready: 0Fh goes through switched on
  EXPECT_EQ(b.a.status() & 0x6F, 0x27);
  b.command(0x07);
  EXPECT_EQ(b.a.status() & 0x6F, 0x23);
  b.command(0x06);
  EXPECT_EQ(b.a.status() & 0x6F, 0x21);
  b.command(0x00);
  EXPECT_EQ(b.a.status() & 0x4F, 0x40);
}

TEST(Drive, follows_its_targets_and_shows_the_motor_in_closed_loop) {
  Bench b("drives/id286.yaml");
  b.enable();
  EXPECT_EQ(b.a.position(), 0);  // the counter begins where the motor stood: at 50 mm
  b.move_to(20000, 100);         // 10 mm in 0.1 s
  EXPECT_NEAR(b.a.target - b.a.position(), 100 * 2000 * (0.004 + 0.002),
              100 * 2000 * 0.0012);  // v * (lag + two cycles)
  b.step(200);
  EXPECT_EQ(b.a.position(), 20000);
  EXPECT_EQ(b.motor().position(), 60.0);
}

TEST(Drive, runs_backwards_when_it_is_inverted) {
  Bench b("drives/id286.yaml", 1, true);
  b.enable();
  b.move_to(20000, 100);
  b.step(200);
  EXPECT_EQ(b.motor().position(), 40.0);
}

TEST(Drive, in_open_loop_shows_the_command_it_has_carried_out) {
  Bench b("drives/std402ec.yaml", 2);
  b.enable(8, 1);
  b.axes[1].target = 100;
  b.step(3);
  EXPECT_EQ(b.axes[1].position(), 100);           // the command
  EXPECT_LT(b.motor(1).position(), 50.0 + 0.05);  // the motor is behind it
  EXPECT_EQ(b.axes[0].position(), 0);
}

TEST(Drive, two_axes_of_a_station_have_states_of_their_own) {
  Bench b("drives/std402ec.yaml", 2);
  b.enable(8, 0);
  EXPECT_EQ(b.axes[0].status(), 0x1237);
  EXPECT_EQ(b.axes[1].status(), 0x250);
  b.enable(8, 1);
  b.segment->drive_fault(AxisId{1}, 0, 0x2211);
  b.step(5);
  EXPECT_EQ(b.axes[0].status(), 0x1237);
  EXPECT_EQ(b.axes[1].status(), 0x238);
}

TEST(Drive, does_not_move_at_enabling) {
  Bench b("drives/id286.yaml");
  b.a.target = 1'000'000;  // rubbish until enabled
  for (const int control : {0x00, 0x06, 0x07}) b.command(static_cast<std::uint16_t>(control));
  EXPECT_EQ(b.motor().position(), 50.0);
  b.a.target = b.a.position();
  b.command(0x0F);
  EXPECT_EQ(b.motor().position(), 50.0);
}

TEST(Drive, wraps_its_32_bit_counter) {
  Bench b("drives/id286.yaml");
  b.segment->restore(AxisId{0}, 0, {.position = 50, .count_zero = 50 - 2147483600 / 2000.0});
  b.step(2);
  EXPECT_EQ(b.a.position(), 2147483600);
  b.enable();
  b.a.target = static_cast<std::int32_t>(2147483647u + 53u);
  b.step(100);
  EXPECT_EQ(b.a.position(), static_cast<std::int32_t>(2147483700u));
  EXPECT_NEAR(b.motor().position(), 50.05, 1e-6);
}

TEST(Drive, brakes_with_6085_and_disables_on_quick_stop_option_2) {
  Bench b("drives/amd530b.yaml");
  EXPECT_EQ(b.bus->sdo_write(Bench::kStation, 0x605A, 0, 2, 2), 0u);
  EXPECT_EQ(b.bus->sdo_write(Bench::kStation, 0x6085, 0, 2'000'000, 4), 0u);  // 1000 mm/s^2
  b.enable();
  b.move_to(20000, 100);  // 100 mm/s
  b.a.control = 0x02;
  const double from = b.motor().position();
  b.step(3);
  EXPECT_EQ(b.a.status(), 0x0217);
  b.step(300);
  EXPECT_EQ(b.a.status(), 0x0650);
  EXPECT_NEAR(b.motor().position() - from, 100 * 100 / 2000.0 + 100 * 0.0045, 0.15);  // v^2/2a and what was on the way
}

// CiA 402: 605Ah = 0 takes the torque. The AMD530B's manual says otherwise of its own 0 (8.4), STD402EC has no 605Ah.
TEST(Drive, a_quick_stop_that_takes_the_torque_lets_the_motor_run_out) {
  struct Stop {
    const char* file;
    int slots;
    std::uint16_t control;
    double runs_on_mm;  ///< at 100 mm/s and 500 mm/s^2: v^2/2a; besides, 5 ms of lag and cycle are on the way
  };
  for (const Stop& s : {Stop{"drives/id286.yaml", 1, 0x02, 10}, Stop{"drives/std402ec.yaml", 2, 0x02, 10},
                        Stop{"drives/id286.yaml", 1, 0x00, 10}, Stop{"drives/amd530b.yaml", 1, 0x00, 10},
                        Stop{"drives/amd530b.yaml", 1, 0x02, 0}}) {
    Bench b(s.file, s.slots, false, 500);
    if (std::string(s.file) == "drives/amd530b.yaml") {
      EXPECT_EQ(b.bus->sdo_write(Bench::kStation, 0x605A, 0, 0, 2), 0u);
    }
    b.enable();
    b.move_to(b.a.target + 20000, 100);  // 100 mm/s
    b.a.control = s.control;
    b.step(1);  // the word is taken at the next SYNC0
    const double from = b.motor().position();
    b.step(600);
    EXPECT_NEAR(b.motor().position() - from, s.runs_on_mm, 0.6) << s.file << ", word " << s.control;
    EXPECT_EQ(b.a.status() & 0x4F, 0x40) << "without torque";
    // Torque comes back where it stands.
    const double stood = b.motor().position();
    b.a.control = 0;
    b.step(5);
    b.enable();
    b.step(20);
    EXPECT_NEAR(b.motor().position(), stood, 1e-3) << s.file;
  }
}

// R54.
TEST(Drive, after_quick_stop_option_6_the_amd530b_wants_the_controlword_back_at_zero) {
  Bench b("drives/amd530b.yaml");
  EXPECT_EQ(b.bus->sdo_write(Bench::kStation, 0x605A, 0, 6, 2), 0u);
  b.enable();
  b.command(0x02);
  EXPECT_EQ(b.a.status(), 0x0217);
  b.command(0x0F);
  EXPECT_EQ(b.a.status(), 0x0217);
  b.command(0x00);
  b.a.target = b.a.position();
  for (const int control : {0x06, 0x07, 0x0F}) b.command(static_cast<std::uint16_t>(control));
  EXPECT_EQ(b.a.status(), 0x1637);
}

TEST(Drive, a_fault_is_reset_by_a_rising_edge_only) {
  Bench b("drives/std402ec.yaml", 2);
  b.enable();
  b.a.control = 0x8F;
  b.step(3);
  b.segment->drive_fault(AxisId{0}, 0, 0x8611);
  b.step(5);
  EXPECT_EQ(b.a.status(), 0x0238);
  b.step(20);  // bit 7 stands
  EXPECT_EQ(b.a.status(), 0x0238);
  b.command(0x00);
  b.command(0x80);
  EXPECT_EQ(b.a.status(), 0x0250);
}

TEST(Drive, over_current_of_the_amd530b_wants_a_power_cycle) {
  Bench b("drives/amd530b.yaml");
  b.enable();
  b.segment->drive_fault(AxisId{0}, 0, 0x2310);
  b.step(5);
  b.command(0x00);
  b.command(0x80);
  EXPECT_EQ(b.a.status() & 0x4F, 0x08);
}

TEST(Drive, a_fault_sends_an_emergency_with_its_code) {
  Bench b("drives/id286.yaml");
  b.enable();
  b.segment->drive_fault(AxisId{0}, 0, 0x000A);
  b.step(3);
  const auto emergency = b.bus->fetch(Bench::kStation);
  ASSERT_TRUE(emergency);
  EXPECT_EQ(value(*emergency, 0, 2), 0x1000u);  // service 1
  EXPECT_EQ(value(*emergency, 2, 2), 0x000Au);
  EXPECT_EQ((*emergency)[4], 1);
  EXPECT_EQ(b.bus->sdo_read(Bench::kStation, 0x1001, 0), 1u);
}

TEST(Drive, warnings_of_the_id286_show_in_603f_without_a_fault) {
  Bench b("drives/id286.yaml");
  b.enable();
  for (const unsigned code : {0x100u, 0x200u}) {
    b.segment->drive_fault(AxisId{0}, 0, code);
    b.step(3);
    EXPECT_EQ(b.a.error(), code);
    EXPECT_EQ(b.a.status(), 0x1237);
  }
}

TEST(Drive, stops_at_a_limit_shows_it_and_comes_back_from_it) {
  Bench b("drives/id286.yaml");
  b.motor().restore(499);
  b.segment->restore(AxisId{0}, 0, {499, 499});
  b.step(2);
  b.enable();
  b.move_to(10000, 100);  // 5 mm, the limit is at 1 mm
  b.step(100);
  EXPECT_NEAR(b.motor().position(), 500, 0.3);  // 50 mm/s * lag beyond it
  EXPECT_GE(b.motor().position(), 500);
  EXPECT_NE(b.a.status() & 0x0800, 0);
  EXPECT_EQ(b.a.error(), 0x0800);
  EXPECT_EQ(b.a.inputs() & 7, 2u);
  b.move_to(0, 100);
  b.step(100);
  EXPECT_EQ(b.a.position(), 0);
  EXPECT_EQ(b.a.status(), 0x1237);
  EXPECT_EQ(b.a.error(), 0);
}

TEST(Drive, faults_when_its_motor_cannot_follow) {
  Bench b("drives/id286.yaml");
  b.enable();
  b.motor().set_stalled(true);
  b.move_to(20000, 100);
  b.step(10);
  EXPECT_EQ(b.a.status(), 0x0238);
  EXPECT_EQ(b.a.error(), 0x0019);
}

TEST(Drive, stops_and_faults_when_the_outputs_end_while_enabled) {
  Bench b("drives/std402ec.yaml", 2);
  b.enable();
  b.bus->wait(milliseconds(150));  // watchdog 100 ms
  EXPECT_EQ(b.bus->state(Bench::kStation), 0x14);
  EXPECT_EQ(b.segment->station(0).drive(0)->state(), devices::wire::DriveState::Fault);
  b.segment->station(0).sample();
  ASSERT_TRUE(b.bus->fetch(Bench::kStation));  // its emergency comes first
  EXPECT_EQ(b.bus->sdo_read(Bench::kStation, 0x603F, 0), 0xFF32u);
}

// --- Homing

struct Case {
  int method;
  bool closed_below;      // home: closed at and below 0, or at and above 100
  double start, edge_at;  // mm; where the counter must read 607Ch
};
class Homing : public ::testing::TestWithParam<Case> {};

void set_home(Bench& b, bool closed_below, double start) {
  config::SimAxis truth = b.machine.sim.axes[0];
  truth.home_active_below = closed_below, truth.home_switch = closed_below ? 0 : 100;
  b.motor() = Motor(truth);
  b.segment->restore(AxisId{0}, 0, {start, start});
  b.step(2);
}

// Limits at -10 and 500.
TEST_P(Homing, finds_the_edge_exactly_wherever_it_starts) {
  const Case& c = GetParam();
  Bench b("drives/amd530b.yaml");
  set_home(b, c.closed_below, c.start);
  EXPECT_EQ(b.bus->sdo_write(Bench::kStation, 0x607C, 0, 12345, 4), 0u);
  b.homing_speeds(200'000, 20'000, 2'000'000);  // 100 mm/s, 10 mm/s, 1000 mm/s^2
  b.home(c.method, 12'000);
  EXPECT_EQ(b.a.status(), 0x1637) << std::hex << b.a.status();
  EXPECT_NEAR(b.segment->memory(AxisId{0}).count_zero, c.edge_at - 12345 / 2000.0, 1e-9);
  EXPECT_NEAR(b.a.position() - 12345, (b.motor().position() - c.edge_at) * 2000, 0.5001);
  // Back to CSP: nothing moves.
  const double at = b.motor().position();
  b.a.target = b.a.position();
  b.a.mode = 8, b.a.control = 0x0F;
  b.step(50);
  EXPECT_EQ(b.a.status(), 0x1637);
  EXPECT_NEAR(b.motor().position(), at, 0.51 / 2000);
}
INSTANTIATE_TEST_SUITE_P(
    Methods, Homing,
    ::testing::Values(Case{17, true, 50, -10}, Case{17, true, -10.5, -10}, Case{18, true, 450, 500},
                      Case{18, true, 500.5, 500}, Case{19, false, 50, 100}, Case{19, false, 105, 100},
                      Case{20, false, 50, 100}, Case{20, false, 105, 100}, Case{21, true, 50, 0}, Case{21, true, -5, 0},
                      Case{22, true, 20, 0}, Case{22, true, -5, 0}, Case{23, false, 50, 100}, Case{23, false, 105, 100},
                      Case{24, false, 50, 100}, Case{24, false, 105, 100}, Case{25, true, 50, 0}, Case{26, true, 50, 0},
                      Case{27, true, 50, 0}, Case{27, true, -5, 0}, Case{28, true, 50, 0}, Case{28, true, -5, 0},
                      Case{29, false, 50, 100}, Case{30, false, 50, 100}, Case{35, true, 33, 33}),
    [](const auto& param) {
      return "method_" + std::to_string(param.param.method) + "_case_" + std::to_string(param.index);
    });

TEST(HomingError, a_limit_in_the_way_is_bit_13_and_an_immediate_stop) {
  Bench b("drives/amd530b.yaml");
  set_home(b, true, -5);  // on the switch, which 19 wants to leave downwards: it never opens there
  b.homing_speeds(400'000, 20'000, 1'000'000);
  b.home(19, 2000);
  EXPECT_EQ(b.a.status() & ~0x0900, 0x2637) << std::hex << b.a.status();  // but for limit bits
  EXPECT_NEAR(b.motor().position(), -10, 0.1);
}

TEST(HomingError, the_id286_warns_with_2000h) {
  Bench b("drives/id286.yaml");
  b.homing_speeds(400'000, 20'000, 1'000'000);
  b.home(1, 100);  // needs an index pulse, which the virtual drive has not
  EXPECT_NE(b.a.status() & 0x2000, 0);
  EXPECT_EQ(b.a.status() & 0x1000, 0);
  EXPECT_EQ(b.a.error(), 0x2000);
}

TEST(HomingError, taking_the_start_bit_back_stops_it) {
  Bench b("drives/id286.yaml");
  b.homing_speeds(100'000, 20'000, 1'000'000);
  b.home(21, 200);
  EXPECT_EQ(b.a.status(), 0x0237);
  b.a.control = 0x0F;
  b.step(300);
  const double at = b.motor().position();
  b.step(100);
  EXPECT_EQ(b.motor().position(), at);
  EXPECT_EQ(b.a.status(), 0x8337);
}

TEST(HomingError, method_17_of_an_inverted_drive_goes_to_the_upper_end) {
  Bench b("drives/amd530b.yaml", 1, true);
  set_home(b, true, 450);
  b.homing_speeds(400'000, 20'000, 1'000'000);
  b.home(17, 8000);
  EXPECT_EQ(b.a.status(), 0x1637);
  EXPECT_NEAR(b.segment->memory(AxisId{0}).count_zero, 500, 1e-9);
}

// --- Touch probe

/// Lets the axis creep down on a surface; returns the true count of the contact.
double touch(Bench& b, double contact_mm, int step_counts = 20) {
  b.motor().set_contact(contact_mm);
  for (int i = 0; i < 400 && b.motor().position() > contact_mm - 0.5; ++i) b.a.target -= step_counts, b.step();
  return (contact_mm - 50) * 2000;
}

// iD286: IN6 with 17, AMD530B 7.2: DI4 with 5.
TEST(Probe, latches_nothing_where_its_input_has_another_function) {
  for (const auto& [file, object] :
       {std::pair{"drives/id286.yaml", config::ObjectAddress{0x2190, 6}}, {"drives/amd530b.yaml", {0x2152, 4}}}) {
    Bench b(file);
    EXPECT_TRUE(b.segment->set_object(b.machine.stations[0].id, object, 4));
    b.enable();
    b.a.probe = 0x11;
    b.step(3);
    touch(b, 49.12345);
    EXPECT_EQ(b.a.probe_status() & 0x02, 0) << file;
  }
}

TEST(Probe, latches_the_counter_at_the_instant_of_contact) {
  Bench b("drives/id286.yaml");
  b.enable();
  b.a.probe = 0x11;
  b.step(3);
  EXPECT_EQ(b.a.probe_status(), 0x01);
  const double counts = touch(b, 49.12345);
  EXPECT_EQ(b.a.probe_status(), 0x43);  // enabled, rising latched, level in bit 6
  EXPECT_EQ(b.a.probe_value(), std::lround(counts));
}

TEST(Probe, takes_only_the_first_edge_until_it_is_armed_again) {
  Bench b("drives/id286.yaml");
  b.enable();
  b.a.probe = 0x11;
  b.step(3);
  const double first = touch(b, 49.5);
  b.move_to(0, 50);
  b.step(50);
  EXPECT_EQ(b.a.probe_status(), 0x03);  // still latched, level open
  touch(b, 49.8);
  EXPECT_EQ(b.a.probe_value(), std::lround(first));
  b.move_to(0, 50);
  b.step(50);
  b.a.probe = 0x10;  // a new edge of bit 0 is enough
  b.step(3);
  b.a.probe = 0x11;
  b.step(3);
  EXPECT_EQ(b.a.probe_status(), 0x01);
  const double second = touch(b, 49.7);
  EXPECT_EQ(b.a.probe_value(), std::lround(second));
}

TEST(Probe, of_the_amd530b_arms_again_only_after_zero) {
  Bench b("drives/amd530b.yaml");
  b.enable();
  b.a.probe = 0x11;
  b.step(3);
  const double first = touch(b, 49.5);
  EXPECT_EQ(b.a.probe_status(), 0x83);  // level in bit 7
  b.move_to(0, 50);
  b.step(50);
  b.a.probe = 0x10;
  b.step(3);
  b.a.probe = 0x11;
  b.step(3);
  touch(b, 49.7);
  EXPECT_EQ(b.a.probe_value(), std::lround(first));
  b.move_to(0, 50);
  b.a.probe = 0;
  b.step(50);
  EXPECT_EQ(b.a.probe_status(), 0);
  b.a.probe = 0x11;
  b.step(3);
  const double second = touch(b, 49.8);
  EXPECT_EQ(b.a.probe_value(), std::lround(second));
}

TEST(Probe, falling_edge_is_latched_on_the_way_up) {
  Bench b("drives/id286.yaml");
  EXPECT_EQ(b.bus->sdo_read(Bench::kStation, 0x60BB, 0), 0u);
  b.enable();
  touch(b, 49.5);
  b.a.probe = 0x21;
  b.step(3);
  b.move_to(0, 100);
  b.step(50);
  EXPECT_EQ(b.a.probe_status(), 0x05);
  EXPECT_EQ(static_cast<std::int32_t>(*b.bus->sdo_read(Bench::kStation, 0x60BB, 0)), -1000);
}

}  // namespace
}  // namespace gantry::sim::test
