// The simulated machine as a whole: a master on its bus, a controller's questions in process and over the socket.
#include "sim/machine/simulated_machine.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "devices/ethercat/master.hpp"
#include "recipes/job.hpp"
#include "sim/machine/world_client.hpp"
#include "sim/machine/world_server.hpp"
#include "sim/world/world_log.hpp"
#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

using sample::temporary;

const config::Machine& machine() {
  static const config::Machine m = [] {
    auto loaded = config::load_machine("config/machines/dispenser.yaml");
    EXPECT_TRUE(loaded) << (loaded ? "" : to_text(loaded.error().front()));
    return loaded ? *loaded : config::Machine{};
  }();
  return m;
}
const recipes::Recipe& recipe() {
  static const recipes::Recipe r = [] {
    auto loaded = recipes::load("recipes/demo-board.yaml");
    EXPECT_TRUE(loaded) << (loaded ? "" : to_text(loaded.error().front()));
    return loaded ? *loaded : recipes::Recipe{};
  }();
  return r;
}

/// A master that exchanges one frame a millisecond of virtual time.
struct Controller {
  VirtualClock clock;
  std::unique_ptr<SimulatedMachine> simulated;
  std::unique_ptr<devices::EthercatMaster> master;
  Time next{};

  explicit Controller(const SimulatedMachineOptions& options) {
    auto opened = SimulatedMachine::open(machine(), clock, options);
    EXPECT_TRUE(opened) << (opened ? "" : to_text(opened.error()));
    simulated = std::move(*opened);
    master = std::make_unique<devices::EthercatMaster>(machine(), simulated->bus(), clock);
  }
  /// Operational, with all outputs off.
  void start() {
    const auto up = master->bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    next = master->first_cycle(clock.now() + milliseconds(2));
    cycles(20);
    const auto requested = master->request_operation();
    ASSERT_TRUE(requested) << to_text(requested.error());
    for (int k = 0; k < 2000 && last.ethercat.al_states != 8; ++k) cycles(1);
    ASSERT_EQ(last.ethercat.al_states, 8);
  }
  devices::Exchange last;
  void cycles(int n) {
    for (int k = 0; k < n; ++k) {
      clock.sleep_until(next);
      last = master->exchange(next + microseconds(800));
      next += milliseconds(1);
    }
  }
  static const config::Channel& channel(config::Output o) { return *machine().outputs[static_cast<std::size_t>(o)]; }
  void set(config::Output o, bool on) {
    auto image = master->outputs(channel(o).station);
    const auto bit = static_cast<std::byte>(1u << (channel(o).bit % 8));
    auto& byte = image[channel(o).bit / 8];
    byte = on != channel(o).invert ? byte | bit : byte & ~bit;
  }
  [[nodiscard]] bool get(config::Input i) const {
    const auto& c = *machine().inputs[static_cast<std::size_t>(i)];
    const auto image = master->inputs(c.station);
    return (std::to_integer<unsigned>(image[c.bit / 8]) >> (c.bit % 8) & 1) != (c.invert ? 1u : 0u);
  }
};

TEST(SimulatedMachine, outputs_of_the_bus_reach_the_world_and_its_inputs_come_back) {
  Controller c({});
  c.start();
  ASSERT_TRUE(c.simulated->load_board(recipe()));
  ASSERT_TRUE(c.simulated->begin_job());
  EXPECT_TRUE(c.get(config::Input::DoorClosed));
  EXPECT_FALSE(c.get(config::Input::Start));
  EXPECT_FALSE(c.get(config::Input::ClampClosed));
  c.set(config::Output::Clamp, true);
  c.cycles(5);
  EXPECT_TRUE(c.get(config::Input::ClampClosed));

  EXPECT_EQ(c.simulated->camera().latest(), 0u);
  c.set(config::Output::CameraLight, true);
  c.set(config::Output::CameraTrigger, true);
  c.cycles(5);
  EXPECT_EQ(c.simulated->camera().latest(), 1u);
  const auto frame = c.simulated->camera().fetch(0, {});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.width, machine().camera.width_px);

  c.set(config::Output::Valve, true);
  c.cycles(50);
  c.set(config::Output::Valve, false);
  c.cycles(50);
  const auto d = c.simulated->deposits();
  ASSERT_EQ(d->size(), 1u) << "high over the board, but it came out";
  EXPECT_GT((*d)[0].board_mm[0].z, 10);
  EXPECT_NEAR(static_cast<double>((*d)[0].closed_cycle - (*d)[0].opened_cycle), 48, 1.01) << "8 ms and 6 ms of lag";

  ASSERT_TRUE(c.simulated->add_script("{do: press, input: start, hold: 10 ms}"));
  c.cycles(4);
  EXPECT_TRUE(c.get(config::Input::Start));
  c.cycles(15);
  EXPECT_FALSE(c.get(config::Input::Start));
}

TEST(SimulatedMachine, scripts_reach_the_bus_between_frames) {
  Controller c({});
  c.start();
  ASSERT_TRUE(c.simulated->add_script("{do: lose_frames, count: 3}"));
  int lost = 0;
  for (int k = 0; k < 20; ++k) {
    c.cycles(1);
    lost += c.last.fault == Fault::FrameLost;
  }
  EXPECT_EQ(lost, 3);
  ASSERT_TRUE(c.simulated->add_script("{do: cut_link, station: cu}"));
  c.cycles(5);
  EXPECT_LT(c.last.ethercat.working_counter, c.last.ethercat.expected);
  ASSERT_TRUE(c.simulated->add_script("{do: power_cycle, station: z}"));
  c.cycles(5);
  const auto missing = c.simulated->add_script("{do: cut_link, station: nowhere}");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().where, "script:1:25");
}

/// The simulated machine and frames put on its bus by hand: one broadcast read each, known by the datagram's index.
struct ByHand {
  VirtualClock clock;
  std::unique_ptr<SimulatedMachine> simulated;
  ByHand() { simulated = std::move(*SimulatedMachine::open(machine(), clock, {})); }
  void pass(Time t) {
    for (const Time end = clock.now() + t; clock.now() < end;) {
      clock.sleep_until(std::min(end, clock.now() + milliseconds(1)));
      simulated->pass_time();
    }
  }
  /// An entry that has happened when this returns, or is to at the next frame.
  void script(const std::string& entry) {
    const auto added = simulated->add_script(entry);
    ASSERT_TRUE(added) << to_text(added.error());
    pass(milliseconds(2));
  }
  /// The answer to a datagram of `size` bytes; the working counter behind it.
  std::vector<std::uint8_t> ask(std::uint8_t command, std::uint16_t adp, std::uint16_t ado, std::size_t size,
                                std::uint8_t number = 0) {
    send(command, adp, ado, size, number);
    std::array<std::byte, devices::kMaxFrameBytes> buffer;
    const auto got = simulated->bus().receive(buffer, clock.now() + milliseconds(1));
    if (got.size == 0) return {};
    std::vector<std::uint8_t> out;
    for (std::size_t i = 0; i < size + 2; ++i) out.push_back(std::to_integer<std::uint8_t>(buffer[26 + i]));
    return out;
  }
  void send(std::uint8_t command, std::uint16_t adp, std::uint16_t ado, std::size_t size, std::uint8_t number) {
    std::vector<std::uint8_t> f(60);
    std::fill_n(f.begin(), 6, std::uint8_t{0xFF});
    f[6] = 0x10, f[12] = 0x88, f[13] = 0xA4;
    f[14] = static_cast<std::uint8_t>(size + 12), f[15] = 0x10;
    f[16] = command, f[17] = number;
    f[18] = static_cast<std::uint8_t>(adp), f[19] = static_cast<std::uint8_t>(adp >> 8);
    f[20] = static_cast<std::uint8_t>(ado), f[21] = static_cast<std::uint8_t>(ado >> 8);
    f[22] = static_cast<std::uint8_t>(size);
    simulated->bus().send(devices::PortIndex::Primary, std::as_bytes(std::span(f)));
    clock.sleep_until(clock.now() + microseconds(10));  // no two frames leave at once
  }
  /// Stations that answer.
  int count() {
    const auto answer = ask(7, 0, 0, 1);
    return answer.empty() ? -1 : answer[1];
  }
  /// Numbers of the frames that come within `t`, and when.
  std::vector<std::pair<int, Time>> come(Time t) {
    std::vector<std::pair<int, Time>> out;
    std::array<std::byte, devices::kMaxFrameBytes> buffer;
    for (const Time until = clock.now() + t;;) {
      const auto got = simulated->bus().receive(buffer, until);
      if (got.size == 0) return out;
      out.emplace_back(std::to_integer<int>(buffer[17]), clock.now());
    }
  }
  std::vector<int> numbers(Time t) {
    std::vector<int> out;
    for (const auto& [number, at] : come(t)) out.push_back(number);
    return out;
  }
};

TEST(Script, duplicated_reordered_and_delayed_frames_are_just_those_that_were_named) {
  ByHand bus;
  bus.script("{do: duplicate_frames, count: 2}");
  for (std::uint8_t n = 1; n <= 3; ++n) bus.send(7, 0, 0, 1, n);
  EXPECT_EQ(bus.numbers(milliseconds(1)), (std::vector{1, 1, 2, 2, 3}));
  bus.script("{do: reorder_frames, count: 1}");
  for (std::uint8_t n = 1; n <= 3; ++n) bus.send(7, 0, 0, 1, n);
  EXPECT_EQ(bus.numbers(milliseconds(1)), (std::vector{2, 1, 3}));
  bus.script("{do: delay_frames, count: 2, by: 3 ms}");
  const Time sent = bus.clock.now();
  for (std::uint8_t n = 1; n <= 3; ++n) bus.send(7, 0, 0, 1, n);
  const auto late = bus.come(milliseconds(10));
  ASSERT_EQ(late.size(), 3u);
  EXPECT_EQ(late[0].first, 3);
  EXPECT_LT(late[0].second, sent + microseconds(100));
  EXPECT_EQ(late[1].first, 1);
  EXPECT_GE(late[1].second, sent + milliseconds(3));
  EXPECT_LT(late[2].second, sent + microseconds(3100));
}

TEST(Script, a_clock_that_drifts_gains_so_much_on_the_machines) {
  ByHand bus;
  const auto local = [&](int position) {
    const auto answer = bus.ask(1, static_cast<std::uint16_t>(-position), 0x0910, 8);
    std::int64_t t = 0;
    for (std::size_t i = 0; i < 8 && i < answer.size(); ++i) t |= std::int64_t{answer[i]} << (8 * i);
    return t;
  };
  const auto gain_in_a_second = [&](int position) {
    const std::int64_t before = local(position);
    const Time began = bus.clock.now();
    bus.pass(milliseconds(1000));
    const std::int64_t gained = local(position) - before;
    return gained - (bus.clock.now() - began).count();
  };
  const auto still = gain_in_a_second(0);
  bus.script("{do: drift, station: x, ppm: 50}");
  EXPECT_NEAR(static_cast<double>(gain_in_a_second(1) - still), 50'000, 10);
  EXPECT_NEAR(static_cast<double>(gain_in_a_second(2) - still), 0, 10);  // its neighbour
  bus.script("{do: drift, station: x, ppm: -20}");
  EXPECT_NEAR(static_cast<double>(gain_in_a_second(1) - still), -20'000, 10);
}

TEST(Script, an_emergency_stop_takes_every_drive_off_the_bus_and_leaves_the_io_station) {
  ByHand bus;
  bus.script("{do: emergency_stop}");
  EXPECT_EQ(bus.count(), 1);
  bus.pass(milliseconds(5000));
  EXPECT_EQ(bus.count(), 1);
  bus.script("{do: emergency_release}");
  EXPECT_EQ(bus.count(), 6);
}

TEST(Script, a_station_is_dark_as_long_as_it_says) {
  ByHand bus;
  ASSERT_EQ(bus.count(), 6);
  bus.script("{do: power_off, station: z}");
  EXPECT_EQ(bus.count(), 4);  // and with it the line behind
  bus.pass(milliseconds(5000));
  EXPECT_EQ(bus.count(), 4);
  bus.script("{do: power_on, station: z}");
  EXPECT_EQ(bus.count(), 6);
  bus.script("{do: power_cycle, station: z, dark: 500 ms}");
  bus.pass(milliseconds(480));
  EXPECT_EQ(bus.count(), 4);
  bus.pass(milliseconds(30));
  EXPECT_EQ(bus.count(), 6);
  bus.script("{do: power_cycle, station: z}");
  bus.pass(milliseconds(180));
  EXPECT_EQ(bus.count(), 4);
  bus.pass(milliseconds(30));
  EXPECT_EQ(bus.count(), 6);
}

TEST(Script, what_has_not_happened_is_told_with_its_line) {
  ByHand bus;
  ASSERT_TRUE(
      bus.simulated->add_script("- {do: lose_frames, count: 1}\n"
                                "- {at: cycle 90000, do: cut_link, station: z}\n"
                                "- {at: job start, after: 1 s, do: press, input: stop}\n"));
  const auto left = [&](WorldAccess::Machine machine) { return *bus.simulated->script_left(machine); };
  const std::string press = "script:3:3: press at job start", cut = "script:2:3: cut_link at cycle 90000";
  bus.pass(milliseconds(2));
  ASSERT_TRUE(bus.simulated->begin_job());
  bus.pass(milliseconds(20));
  using Lines = std::vector<std::string>;
  EXPECT_EQ(left(WorldAccess::Machine::GoesOn), Lines{press}) << "cycle 90000 may still come";
  EXPECT_EQ(left(WorldAccess::Machine::GoesOn), Lines{}) << "it was told";
  EXPECT_EQ(left(WorldAccess::Machine::Ends), Lines{cut});
  EXPECT_EQ(left(WorldAccess::Machine::Ends), Lines{});
}

TEST(Script, what_is_left_is_of_what_has_not_happened) {
  ByHand bus;
  ASSERT_TRUE(
      bus.simulated->add_script("- {do: lose_frames, count: 1}\n"
                                "- {at: job start, after: 1 s, do: press, input: stop}\n"));
  ASSERT_TRUE(bus.simulated->begin_job());
  bus.pass(milliseconds(2000));
  EXPECT_TRUE(bus.simulated->script_left(WorldAccess::Machine::Ends)->empty());
}

TEST(SimulatedMachine, a_bad_placement_or_script_is_refused_with_its_place) {
  VirtualClock clock;
  const auto placement =
      SimulatedMachine::open(machine(), clock, {.seed = 1, .placement = "dx=1", .script_file = {}, .state_dir = {}});
  ASSERT_FALSE(placement);
  EXPECT_EQ(info(placement.error().fault).exit_code, ExitCode::InvalidFile);
  const std::string path = temporary("gantry-bad-script.yaml");
  std::ofstream(path) << "- {at: cycle 5, do: nothing_known}\n";
  const auto script =
      SimulatedMachine::open(machine(), clock, {.seed = 1, .placement = {}, .script_file = path, .state_dir = {}});
  ASSERT_FALSE(script);
  EXPECT_EQ(script.error().where, path + ":1:21");
  std::filesystem::remove(path);
}

TEST(SimulatedMachine, motors_and_board_stay_where_they_are_when_the_world_is_opened_again) {
  const std::string dir = temporary("gantry-simulated-state");
  std::filesystem::remove_all(dir);
  const SimulatedMachineOptions options{.seed = 9, .placement = {}, .script_file = {}, .state_dir = dir};
  const auto squirt = [](Controller& c) {  // where the needle stands, as the world sees it
    c.set(config::Output::Valve, true);
    c.cycles(30);
    c.set(config::Output::Valve, false);
    c.cycles(30);
    return c.simulated->deposits()->back().board_mm.front();
  };
  std::string placement;
  Vec3 before;
  std::size_t deposits = 0;
  {
    Controller c(options);
    c.start();
    ASSERT_TRUE(c.simulated->load_board(recipe()));
    placement = *c.simulated->placement();
    before = squirt(c);
    deposits = c.simulated->deposits()->size();
  }
  {
    Controller c(options);
    c.start();
    EXPECT_TRUE(*c.simulated->holds_board(recipe()));
    EXPECT_EQ(*c.simulated->placement(), placement);
    EXPECT_EQ(c.simulated->deposits()->size(), deposits) << "the job goes on";
    EXPECT_EQ(squirt(c), before);
  }
  {
    // As if the motors had been moved before the lights went out: X by 7 mm, in the order of axes and their drives.
    auto log = WorldLog::open(dir);
    ASSERT_TRUE(log);
    std::vector<double> motors;
    for (const auto& r : (*log)->records())
      if (r.kind == WorldLog::Kind::Motors) {
        motors.resize(r.payload.size() / sizeof(double));
        std::memcpy(motors.data(), r.payload.data(), r.payload.size());
      }
    ASSERT_EQ(motors.size(), 12u) << "X, Y twice, Z, C, U: position and zero of each";
    motors[0] += 7;
    (*log)->append(WorldLog::Kind::Motors, std::as_bytes(std::span(motors)));
  }
  Controller c(options);
  c.start();
  const Vec3 after = squirt(c);
  EXPECT_NEAR(std::hypot(after.x - before.x, after.y - before.y), 7, 1e-9);
  c.simulated.reset();
  std::filesystem::remove_all(dir);
}

class OverTheSocket : public testing::Test {
 protected:
  OverTheSocket() : path(temporary("gantry-world-socket")), c({}) {}
  ~OverTheSocket() override { std::filesystem::remove(path); }
  std::string path;
  Controller c;
};

TEST_F(OverTheSocket, the_same_questions_have_the_same_answers) {
  c.start();
  auto server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server) << to_text(server.error());
  auto client = WorldClient::connect(path);
  ASSERT_TRUE(client) << to_text(client.error());
  WorldAccess& remote = **client;

  EXPECT_FALSE(*remote.holds_board(recipe()));
  ASSERT_TRUE(remote.load_board(recipe()));
  EXPECT_TRUE(*remote.holds_board(recipe()));
  recipes::Recipe other = recipe();
  other.board.size.x += 0.5;
  EXPECT_FALSE(*remote.holds_board(other)) << "that board is longer";
  ASSERT_TRUE(remote.begin_job());
  EXPECT_EQ(*remote.placement(), *c.simulated->placement());

  c.set(config::Output::CameraLight, true);
  c.set(config::Output::CameraTrigger, true);
  c.set(config::Output::Valve, true);
  c.cycles(40);
  c.set(config::Output::Valve, false);
  c.cycles(40);
  EXPECT_EQ(remote.camera().latest(), 1u);
  const auto near = c.simulated->camera().fetch(0, {}), far = remote.camera().fetch(0, {});
  ASSERT_TRUE(far) << to_text(far.error());
  EXPECT_EQ(far->counter, near->counter);
  EXPECT_EQ(far->image.pixels, near->image.pixels);
  const auto none = remote.camera().fetch(1, milliseconds(1));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, Fault::CameraTimeout);

  const auto here = *c.simulated->deposits(), there = *remote.deposits();
  ASSERT_EQ(there.size(), 1u);
  EXPECT_EQ(there[0].board_mm, here[0].board_mm);
  EXPECT_EQ(there[0].opened_cycle, here[0].opened_cycle);
  EXPECT_EQ(remote.collisions()->size(), c.simulated->collisions()->size());
  ASSERT_TRUE(remote.add_script("{at: cycle 900000000, do: camera_dead}"));
  EXPECT_TRUE(remote.script_left(WorldAccess::Machine::GoesOn)->empty());
  EXPECT_EQ(*remote.script_left(WorldAccess::Machine::Ends),
            (std::vector<std::string>{"script:1:1: camera_dead at cycle 900000000"}));

  const std::string csv = temporary("gantry-remote-deposits.csv");
  ASSERT_TRUE(remote.write_deposits(csv));
  EXPECT_TRUE(std::filesystem::exists(csv));
  std::filesystem::remove(csv);
  EXPECT_FALSE(remote.write_deposits("/nonexistent/deposits.csv"));

  const auto bad = remote.add_script("{do: dance}");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().where, "script:1:6");
}

TEST_F(OverTheSocket, the_socket_is_private_single_and_gone_at_the_end) {
  auto server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server);
  struct stat s {};
  ASSERT_EQ(::stat(path.c_str(), &s), 0);
  EXPECT_EQ(s.st_mode & 0777, 0600u);
  const auto second = WorldServer::listen(*c.simulated, path);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().fault, Fault::SecondOwner);
  auto client = WorldClient::connect(path);
  ASSERT_TRUE(client);
  server->reset();
  EXPECT_FALSE(std::filesystem::exists(path));
  const auto answer = (*client)->deposits();
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().fault, Fault::WorldUnreachable);
  const auto nobody = WorldClient::connect(path);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().fault, Fault::WorldUnreachable);
}

TEST_F(OverTheSocket, the_next_job_finds_a_world_that_was_started_again) {
  auto server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server);
  auto client = WorldClient::connect(path);
  ASSERT_TRUE(client);
  ASSERT_TRUE((*client)->load_board(recipe()));
  server->reset();
  EXPECT_FALSE((*client)->deposits()) << "nobody is there";
  const auto nobody = (*client)->holds_board(recipe());
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().fault, Fault::WorldUnreachable);
  EXPECT_NE(nobody.error().message.find("start `gantry sim"), std::string::npos) << nobody.error().message;

  server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server) << to_text(server.error());
  EXPECT_FALSE((*client)->deposits()) << "the job that runs has lost its world";
  EXPECT_TRUE(*(*client)->holds_board(recipe())) << "the next one looks for it again";
  EXPECT_TRUE((*client)->deposits());

  server->reset();
  server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server);
  EXPECT_TRUE(*(*client)->holds_board(recipe())) << "also where nobody had missed it";
}

TEST_F(OverTheSocket, a_dead_socket_is_replaced_and_a_file_is_not) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(fd);  // the file stays behind, as after a kill
  EXPECT_TRUE(WorldServer::listen(*c.simulated, path));
  std::ofstream(path) << "precious";
  const auto refused = WorldServer::listen(*c.simulated, path);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::FileUnwritable);
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST_F(OverTheSocket, nonsense_is_answered_and_does_not_end_the_world) {
  auto server = WorldServer::listen(*c.simulated, path);
  ASSERT_TRUE(server);
  LineSocket raw(::socket(AF_UNIX, SOCK_STREAM, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::connect(raw.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  for (const char* line : {"{", "[]", "7", "{}", "{\"do\": 3}", "{\"do\": \"fly\"}", "{\"do\": \"fetch\"}",
                           "{\"do\": \"load_board\", \"plan\": {}}", "\xff\xfe", ""}) {
    ASSERT_TRUE(raw.write(std::string(line) + "\n"));
    const auto answer = raw.read_line();
    ASSERT_TRUE(answer) << line;
    EXPECT_NE(answer->find("\"ok\":false"), std::string::npos) << line << " -> " << *answer;
  }
}

}  // namespace
}  // namespace gantry::sim
