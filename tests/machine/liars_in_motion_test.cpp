// Drives under load whose mode comes or shows late: the machine works as well, or it is refused by name (mutated.hpp),
// and no axis sinks meanwhile.
#include <cstdlib>
#include <fmt/format.h>
#include <span>

#include "tests/altered.hpp"
#include "tests/machine/mutated.hpp"

namespace gantry::test {
namespace {

using sim::StationHabits;

struct Row {
  const char* what;
  const char* station;
  StationHabits habits;
  std::function<void(config::Machine&)> wired{};
  std::vector<const char*> refused{};  ///< what the reason names; empty: it works as well
};

constexpr double kSunk_mm = 0.02;  // that an axis under load may stand elsewhere: a few times the load

/// Modes, switches and error codes of all drives are in no PDO.
void modes_by_sdo(config::Machine& m) {
  for (const char* name : {"x", "y1", "y2", "z", "cu"})
    for (const int index : {0x6060, 0x6061, 0x60FD, 0x603F})
      object(m, name, {static_cast<std::uint16_t>(index), 0}).mappable = false;
}

TEST(LiarsInMotion, modes_and_loads) {
  const Row rows[] = {
      {"a load, mode at once", "z", {.lies = {.load = 3}}},
      {"a load, and a mode that comes 90 ms late", "z", {.lies = {.load = 3, .mode_delay = 90}}},
      {"a load, and a mode that shows 90 ms late", "z", {.lies = {.load = 3, .mode_shown_after = 90}}},
      {"a load, and a mode that comes 300 ms late",
       "z",
       {.lies = {.load = 3, .mode_delay = 300}},
       {},
       {"station 4 'z'"}},
      {"a load, and modes by SDO", "z", {.lies = {.load = 3}}, modes_by_sdo},
      {"a load, and modes by SDO that come 300 ms late", "z", {.lies = {.load = 3, .mode_delay = 300}}, modes_by_sdo},
      {"a load, modes by SDO that show 300 ms late", "z", {.lies = {.load = 3, .mode_shown_after = 300}}, modes_by_sdo},
      {"one side of the beam with a load, by SDO",
       "y2",
       {.mailbox_delay = milliseconds(30), .lies = {.load = 3}},
       modes_by_sdo},
      {"a load the other way", "z", {.lies = {.load = -3, .mode_shown_after = 90}}},
  };
  const double z_mm = drive([](config::Machine&) {}).z_mm;
  for (const Row& row : rows) {
    SCOPED_TRACE(fmt::format("{}: {}", row.station, row.what));
    const Outcome out = drive(row.wired ? row.wired : [](config::Machine&) {}, {{row.station, row.habits}});
    EXPECT_EQ(out.wrong, "");
    if (out.works) {
      EXPECT_NEAR(out.z_mm, z_mm, kSunk_mm);
    }
    EXPECT_EQ(out.works, row.refused.empty()) << to_text(out.why);
    for (const char* word : row.refused) EXPECT_NE(to_text(out.why).find(word), std::string::npos) << to_text(out.why);
    if (std::getenv("GANTRY_SHOW") != nullptr)
      std::printf("%-3s %-50s %s %.3f mm\n", row.station, row.what, out.works ? "works" : to_text(out.why).c_str(),
                  out.z_mm - z_mm);
  }
}

}  // namespace
}  // namespace gantry::test
