// The project's master against strange stations (strange_stations.py) on an interface:
//   interop_our_master INTERFACE KIND...
// Brings the line up, reads and writes objects, goes to OP and exchanges: what comes in must be what went out,
// inverted. Exit 0: all held; 1: it did not, with the reason.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>

#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/raw_socket_port.hpp"
#include "tests/interop/strange_kinds.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

int failed(const std::string& what) {
  std::printf("FAILED: %s\n", what.c_str());
  return 1;
}

std::string objects(EthercatMaster& master, const config::Station& s) {
  const auto product = master.read_object(s.id, {0x1018, 2});
  if (!product) return to_text(product.error());
  std::uint32_t value = 0;
  std::memcpy(&value, product->data(), std::min<std::size_t>(product->size(), 4));
  if (value != s.profile.identity.product) return "1018h:2 is another";
  const std::byte word[] = {std::byte{0x34}, std::byte{0x12}};
  if (auto ok = master.write_object(s.id, {0x2000, 0}, word); !ok) return to_text(ok.error());
  const auto back = master.read_object(s.id, {0x2000, 0});
  if (!back || !std::equal(back->begin(), back->end(), word, word + 2)) return "2000h did not keep what was written";
  const auto name = master.read_object(s.id, {0x1008, 0});
  if (s.name == "nervous") {
    if (name || name.error().fault != Fault::SdoAbort) return "the abort of 1008h was not told";
  } else if (!name || name->size() != 40) {
    return "1008h: " + (name ? "wrong length" : to_text(name.error()));
  }
  const auto unknown = master.read_object(s.id, {0x5FFF, 0});
  if (unknown) return "an unknown object was read";
  if (unknown.error().fault != Fault::SdoAbort) return "the abort of 5FFFh was not told: " + to_text(unknown.error());
  return "";
}

/// The 1 ms cycle in a thread of its own. Outputs count; inputs must be this cycle's outputs inverted, or the last
/// one's where they are read in front of the write.
class Loop {
 public:
  std::atomic<int> al_states{0}, cycles{0}, fresh{0}, echoed{0};

  Loop(const config::Machine& machine, EthercatMaster& master, Clock& clock)
      : machine_(machine), master_(master), clock_(clock), thread_([this] { run(); }) {}
  ~Loop() { end(); }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  static std::byte output(int cycle, const config::Station& s) {
    return static_cast<std::byte>(cycle * 7 + s.position);
  }
  [[nodiscard]] bool echo_of(int cycle) const {
    return std::all_of(machine_.stations.begin(), machine_.stations.end(), [&](const auto& s) {
      const auto in = master_.inputs(s.id);
      return !in.empty() && std::all_of(in.begin(), in.end(), [&](std::byte b) { return b == ~output(cycle, s); });
    });
  }
  void run() {
    Time next = master_.first_cycle(clock_.now() + milliseconds(5));
    int last = 0;  // cycle of which the outputs surely arrived
    while (!stop_) {
      clock_.sleep_until(next);
      next = std::max(next + machine_.bus.cycle, clock_.now());
      const int n = cycles + 1;
      for (const auto& s : machine_.stations)
        for (auto& b : master_.outputs(s.id)) b = output(n, s);
      const Exchange e = master_.exchange(clock_.now() + milliseconds(20));
      al_states = e.ethercat.al_states;
      if (e.inputs_fresh) ++fresh, echoed += echo_of(n) || echo_of(last);
      if (e.inputs_fresh) last = n;
      cycles = n;
    }
  }
  const config::Machine& machine_;
  EthercatMaster& master_;
  Clock& clock_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  config::Machine machine;
  for (int i = 2; i < argc; ++i) machine.stations.push_back(interop::strange_station(i - 2, argv[i]));
  MonotonicClock clock;
  auto port = RawSocketPort::open(argv[1]);
  if (!port) return failed(to_text(port.error()));
  EthercatMaster master(machine, **port, clock);
  const Time begin = clock.now();
  if (auto up = master.bring_up(); !up) return failed("bring-up: " + to_text(up.error()));
  std::printf("ok: brought up in %lld ms\n", static_cast<long long>((clock.now() - begin).count() / 1'000'000));
  for (const auto& note : master.notes()) std::printf("note: %s\n", note.c_str());
  for (const auto& s : machine.stations)
    if (interop::kinds().at(s.name).mailbox)
      if (const auto wrong = objects(master, s); !wrong.empty()) return failed(s.name + ": " + wrong);
  std::printf("ok: objects\n");

  Loop loop(machine, master, clock);
  if (auto asked = master.request_operation(); !asked) return failed(to_text(asked.error()));
  for (int i = 0; i < 500 && loop.al_states != 8; ++i) clock.sleep_until(clock.now() + milliseconds(10));
  if (loop.al_states != 8) {
    const auto why = master.check_operation();
    return failed("not in OP: " + (why ? std::string("nobody says why") : to_text(why.error())));
  }
  std::printf("ok: OP\n");
  constexpr int kCycles = 1000;
  const int fresh_before = loop.fresh, cycles_before = loop.cycles, echoed_before = loop.echoed;
  while (loop.cycles < cycles_before + kCycles) clock.sleep_until(clock.now() + milliseconds(10));
  // Objects while the cycle runs.
  for (const auto& s : machine.stations)
    if (interop::kinds().at(s.name).mailbox)
      if (const auto wrong = objects(master, s); !wrong.empty()) return failed("in OP, " + s.name + ": " + wrong);
  loop.end();
  const int fresh = loop.fresh - fresh_before, cycles = loop.cycles - cycles_before,
            echoed = loop.echoed - echoed_before;
  std::printf("%d of %d cycles with inputs, %d of them the echo\n", fresh, cycles, echoed);
  master.shut_down();
  return fresh >= cycles * 9 / 10 && echoed == fresh ? 0 : failed("the echo");
}
