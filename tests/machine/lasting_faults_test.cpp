// What lasts is told when it comes, and not again in every cycle: while the axes home, in a job, on hold and while the
// machine stands, alone and with another thing behind it.
#include <algorithm>
#include <map>

#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Rig;
using test::Said;

using test::kShort;
constexpr int kLasts_cycles = 3000;
constexpr std::ptrdiff_t kMost =
    8;  // of one line, but for its count: at once, after 1 s and 2 s, for each time it came

std::string input_off(const std::string& input) { return "do: set_input, input: " + input + ", on: false"; }

const std::vector<std::string> kInputs{"air_ok", "door_closed", "stop", "safety_ok", "mode", "clamp_closed"};

/// Without what a line counts.
std::string without_numbers(std::string line) {
  std::erase_if(line, [](unsigned char c) { return std::isdigit(c) != 0; });
  return line;
}

/// How often the line that comes most often came.
std::pair<std::string, std::ptrdiff_t> most_often(const Said& said) {
  std::map<std::string, std::ptrdiff_t> lines;
  for (const std::string& line : said.lines()) ++lines[without_numbers(line)];
  std::pair<std::string, std::ptrdiff_t> most;
  for (const auto& [line, times] : lines)
    if (times > most.second) most = {line, times};
  return most;
}

void expect_calm(const std::string& script, const std::string& what) {
  const Said said;
  Rig rig({.placement = "dx=0.5 mm", .script = script, .outlives_stops = true});
  int stands = 0;
  rig.on_step = [&](run::Owner& owner) {  // a job that a stop has left on hold is resumed by nobody
    if (owner.held() && ++stands == kLasts_cycles) static_cast<void>(owner.order({.kind = run::OrderKind::Abort}));
  };
  static_cast<void>(rig.run(kShort));
  for (int i = 0; i < kLasts_cycles && rig.owner().idle(); ++i) {
  }
  const auto [line, times] = most_often(said);
  EXPECT_LE(times, kMost) << what << ": " << line;
  EXPECT_GT(said.lines().size(), 0u) << what << ": nothing was told";
}

std::string two(const std::string& at, const std::string& first, const std::string& then) {
  const std::string second = at.find("after") == std::string::npos ? at + ", after: 1 s" : "at: job start, after: 2 s";
  return "- {" + at + ", " + first + "}\n- {" + second + ", " + then + "}\n";
}

/// Air off while the axes home, and then the door, told 1000 lines a second without end.
TEST(LastingFaults, of_two_inputs_in_homing_none_is_told_each_cycle) {
  for (const std::string& first : kInputs)
    for (const std::string& then : kInputs)
      if (first != then)
        expect_calm(two("at: job start, after: 1 s", input_off(first), input_off(then)), first + ", then " + then);
}

TEST(LastingFaults, of_two_inputs_in_a_bead_none_is_told_each_cycle) {
  for (const std::string& first : kInputs)
    for (const std::string& then : kInputs)
      if (first != then) expect_calm(two("at: feature a", input_off(first), input_off(then)), first + ", then " + then);
}

TEST(LastingFaults, of_drives_and_the_bus_none_is_told_each_cycle) {
  const std::vector<std::string> others{"do: drive_fault, axis: X, code: 0x0E",
                                        "do: stall, axis: X",
                                        "do: cut_link, station: z",
                                        "do: power_off, station: z",
                                        "do: stick_statusword, axis: X",
                                        "do: slip_brake, axis: Z, speed: 2 mm/s",
                                        "do: drift, station: z, ppm: 400",
                                        "do: noise, loss: 0.05",
                                        "do: emergency_stop"};
  for (const std::string at : {"at: job start, after: 1 s", "at: feature a"})
    for (const std::string& other : others) {
      expect_calm("- {" + at + ", " + other + "}\n", at + ", " + other);
      expect_calm(two(at, other, input_off("door_closed")), at + ", " + other + ", then the door");
      expect_calm(two(at, input_off("air_ok"), other), at + ", air off, then " + other);
    }
}

}  // namespace
}  // namespace gantry
