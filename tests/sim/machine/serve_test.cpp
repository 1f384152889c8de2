// `gantry sim` as another process would meet it: frames over a veth pair, the world over its socket. Needs the right to
// make a veth pair; where that is missing the test says so and is skipped. Waits for things to come about and never for
// a time to pass.
#include "sim/machine/serve.hpp"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <thread>
#include <unistd.h>

#include "core/clock.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/machine/world_client.hpp"

namespace gantry::sim {
namespace {

class VethPair {
 public:
  VethPair() : near("gt" + std::to_string(::getpid() % 100000) + "a"), far(near.substr(0, near.size() - 1) + "b") {
    made_ = run("ip link add " + near + " type veth peer name " + far) && run("ip link set " + near + " up") &&
            run("ip link set " + far + " up");
  }
  ~VethPair() { run("ip link del " + near); }
  [[nodiscard]] bool made() const { return made_; }
  std::string near, far;

 private:
  static bool run(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()) == 0; }
  bool made_ = false;
};

/// Ends a thread that looks at `stop`, wherever a test leaves.
struct Ending {
  std::atomic<bool>& stop;
  std::thread& thread;
  ~Ending() {
    stop = true;
    if (thread.joinable()) thread.join();
  }
};

/// `gantry sim` in a thread of its own, until it is ended. The machine outlives it.
class Serving {
 public:
  Serving(const config::Machine& machine, ServeOptions options)
      : thread_([this, &machine, options = std::move(options)] { served_ = serve(machine, options, stop_); }) {}
  ~Serving() { static_cast<void>(end()); }
  Result<void> end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return served_;
  }

 private:
  std::atomic<bool> stop_{false};
  Result<void> served_;
  std::thread thread_;
};

TEST(Serve, a_master_on_the_other_end_of_the_cable_brings_the_bus_up_and_takes_a_picture) {
  const VethPair cable;
  if (!cable.made() && ::geteuid() != 0) GTEST_SKIP() << "no right to make a veth pair";
  ASSERT_TRUE(cable.made());
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const std::string socket = (std::filesystem::temp_directory_path() / (cable.near + ".world")).string();
  ServeOptions options;
  options.interface = cable.far;
  options.world_socket = socket;
  Serving serving(*machine, options);

  MonotonicClock clock;
  const Time give_up = clock.now() + std::chrono::seconds(60);
  auto client = WorldClient::connect(socket);
  for (; !client && clock.now() < give_up; client = WorldClient::connect(socket))
    clock.sleep_until(clock.now() + milliseconds(5));
  ASSERT_TRUE(client) << to_text(client.error());

  auto port = devices::RawSocketPort::open(cable.near);
  ASSERT_TRUE(port) << to_text(port.error());
  devices::EthercatMaster master(*machine, **port, clock);
  const auto up = master.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_EQ(master.stations().size(), 6u);

  const auto channel = [&](config::Output o) { return *machine->outputs[static_cast<std::size_t>(o)]; };
  const auto light = channel(config::Output::CameraLight), trigger = channel(config::Output::CameraTrigger);
  // The loop, in a thread of its own as in the program; it pulses the trigger all the time.
  std::atomic<bool> stop_loop{false};
  std::atomic<std::uint16_t> states{0};
  std::thread loop([&] {
    Time next = master.first_cycle(clock.now() + milliseconds(5));
    for (unsigned k = 0; !stop_loop; ++k) {
      clock.sleep_until(next);
      const auto got = master.exchange(next + microseconds(900));
      if (got.inputs_fresh) states = got.ethercat.al_states;
      do next += milliseconds(1);
      while (next < clock.now());  // the phase is kept when the host stalls
      master.outputs(light.station)[0] = static_cast<std::byte>(1u << light.bit | (k / 20 % 2) << trigger.bit);
    }
  });
  const Ending loop_ending{stop_loop, loop};
  Result<void> operational = fail(Fault::Internal, "not asked");
  while (!(operational = master.request_operation()) && clock.now() < give_up)
    clock.sleep_until(clock.now() + milliseconds(5));
  ASSERT_TRUE(operational) << to_text(operational.error());
  while ((*client)->camera().latest() == 0 && clock.now() < give_up) clock.sleep_until(clock.now() + milliseconds(5));
  EXPECT_GT((*client)->camera().latest(), 0u) << "AL states " << states;
  const auto frame = (*client)->camera().fetch(0, milliseconds(100));
  ASSERT_TRUE(frame) << to_text(frame.error());
  EXPECT_EQ(frame->image.width, machine->camera.width_px);
  stop_loop = true;
  loop.join();
  master.shut_down();
  EXPECT_TRUE(serving.end());
  EXPECT_FALSE(std::filesystem::exists(socket));
}

TEST(Serve, frames_of_another_master_reach_the_other_end_as_in_one_process) {
  const VethPair cable;
  if (!cable.made() && ::geteuid() != 0) GTEST_SKIP() << "no right to make a veth pair";
  ASSERT_TRUE(cable.made());
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const std::string script = (std::filesystem::temp_directory_path() / (cable.near + ".yaml")).string();
  std::ofstream(script) << "- {do: foreign_frames, count: 5}\n";
  ServeOptions options;
  options.interface = cable.far;
  options.world.script_file = script;
  const Serving serving(*machine, options);

  MonotonicClock clock;
  const Time give_up = clock.now() + std::chrono::seconds(60);
  auto port = devices::RawSocketPort::open(cable.near);
  ASSERT_TRUE(port) << to_text(port.error());
  devices::Link link(**port, clock);
  while (link.counts().foreign < 5 && clock.now() < give_up) {  // the simulated machine may not listen yet
    std::array<std::byte, 2> states{};
    static_cast<void>(link.transact(devices::wire::Command::Brd, 0x0130'0000, states, 1));
  }
  EXPECT_EQ(link.counts().foreign, 5u);
  ASSERT_TRUE(link.other_master());
  EXPECT_EQ(link.other_master()->address, (devices::MacAddress{std::byte{0x02}, std::byte{0x1B}, std::byte{0x21},
                                                               std::byte{0x0A}, std::byte{0x0B}, std::byte{0x0C}}));
  std::filesystem::remove(script);
}

TEST(Serve, an_interface_that_does_not_exist_is_refused) {
  std::atomic<bool> stop{true};
  ServeOptions options;
  options.interface = "nowhere0";
  const auto served = serve({}, options, stop);
  ASSERT_FALSE(served);
  EXPECT_EQ(served.error().fault, Fault::InterfaceUnusable);
}

}  // namespace
}  // namespace gantry::sim
