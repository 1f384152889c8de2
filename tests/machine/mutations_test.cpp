// Stations altered on the simulated machine's side alone, by hand and at random: the machine works as well, or it is
// refused by name. The judge is the virtual world: an axis that the controller calls referenced must stand where the
// controller believes, and one that was jogged must have gone by that displacement.
//   GANTRY_ROUNDS=500 GANTRY_SEED=7 build/release/bin/machine_trust_test
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <random>
#include <set>

#include "tests/altered.hpp"
#include "tests/machine/mutated.hpp"

namespace gantry::test {
namespace {

struct Altered {
  const char* what;
  std::function<void(config::Machine&)> wired;
  const char* refused;  ///< words of the reason; null: it works as well
};

TEST(Mutations, by_hand) {
  const auto facts = [](auto& m, const char* name) -> config::DriveFacts& { return *station(m, name).profile.drive; };
  const Altered all[] = {
      {"a drive without CSP", [&](auto& m) { std::erase(facts(m, "x").modes, 8); }, "station 1 'x'"},
      {"a drive that cannot home", [&](auto& m) { std::erase(facts(m, "z").modes, 6); }, "'z'"},
      {"homing goes twice as fast", [&](auto& m) { facts(m, "y1").velocity_counts_s *= 2; }, "axis Y"},
      {"homing goes half as fast", [&](auto& m) { facts(m, "x").velocity_counts_s /= 2; }, nullptr},
      {"it holds a home offset",
       [](auto& m) {
         object(m, "x", {0x607C, 0}).initial = 5000;
       },
       nullptr},
      {"an axis that stands exactly on its reference limit",
       [](auto& m) { m.sim.axes[0].start = m.axes[0].homing->position; }, nullptr},
      {"the home switch is stuck", [](auto& m) { m.sim.axes[3].home_switch = 1e6; }, "axis C"},
      {"a limit that stays closed", [](auto& m) { m.sim.axes[0].pos_limit = -1e6; }, "axis X"},
      {"both limits swapped on one side of the beam",
       [&](auto& m) { std::swap(facts(m, "y1").input_neg_limit, facts(m, "y1").input_pos_limit); }, "axis Y"},
      {"one side of the beam turns the other way", [](auto& m) { m.axes[1].drives[1].invert ^= true; }, "axis Y"},
      {"the second axis is absent", [](auto& m) { station(m, "cu").profile.slots = 1; }, "'cu'"},
      {"an error code that stays from before",
       [](auto& m) {
         object(m, "x", {0x603F, 0}).initial = 0x7500;
       },
       nullptr},
      {"a clock of 32 bits", [](auto& m) { station(m, "y2").profile.clock_bits = 32; }, nullptr},
      {"no clock", [](auto& m) { station(m, "cu").profile.dc = false; }, nullptr},
      {"mailboxes that overlap",
       [](auto& m) {
         // Two mailboxes on top of each other: no profile or manual has it, an EEPROM may.
         for (auto& row : station(m, "z").profile.sync_managers)
           if (row.kind == config::SyncManagerKind::MailboxOut || row.kind == config::SyncManagerKind::MailboxIn)
             row.length = 512;
       },
       "'z'"},
      {"607Ah is not mappable",
       [](auto& m) {
         object(m, "y2", {0x607A, 0}).mappable = false;
       },
       "'y2'"},
      {"6041h is not mappable",
       [](auto& m) {
         object(m, "cu", {0x6041, 0}).mappable = false;
       },
       "'cu'"},
      {"the probe cannot be mapped",
       [](auto& m) {
         object(m, "z", {0x60BA, 0}).mappable = false;
       },
       "'z'"},
      {"homing speeds cannot be written",
       [](auto& m) {
         object(m, "x", {0x6099, 1}).writable = false;
       },
       "6099h:1"},
      {"the homing method cannot be written",
       [](auto& m) {
         object(m, "z", {0x6098, 0}).writable = false;
       },
       "6098h"},
      {"no 6099h", [](auto& m) { remove_object(station(m, "x").profile, 0x6099); }, "6099h"},
      {"another serial, revision", [](auto& m) { station(m, "x").profile.identity.revision += 5; }, nullptr},
      {"another product", [](auto& m) { station(m, "io").profile.identity.product += 5; }, "'io'"},
      {"the wrong alias", [](auto& m) { station(m, "y1").alias = 77; }, "'y1'"},
      {"a top speed below what the axis asks for",
       [](auto& m) {
         object(m, "x", {0x6080, 0}).initial = 100;
       },
       "max_speed"},
      {"a soft limit of the drive inside the travel",
       [](auto& m) {
         object(m, "z", {0x607D, 1}).initial = -1000;
       },
       "soft_limit_low"},
      {"a station that drops its motor current",
       [](auto& m) {
         holds(m, "x", {0x20F1, 0}, 100);
       },
       "run_current"},
  };
  for (const Altered& a : all) {
    const Outcome out = drive(a.wired);
    EXPECT_EQ(out.wrong, "") << a.what;
    if (a.refused == nullptr) {
      EXPECT_TRUE(out.works) << a.what << ": " << to_text(out.why);
      continue;
    }
    EXPECT_FALSE(out.works) << a.what;
    EXPECT_NE(to_text(out.why).find(a.refused), std::string::npos) << a.what << ": " << to_text(out.why);
  }
}

/// Drives that show what is not so. Each alone on an axis with an encoder, on one side of the beam, on the axis that
/// carries the needle, and on one without encoder.
TEST(Mutations, drives_that_lie) {
  const struct {
    const char* what;
    sim::DriveLies lies;
    bool may_work = false;  ///< without harm
  } kRows[] = {
      {"6061h shows CSP whatever the mode is", {.mode_shown = 8}},
      {"6061h shows homing whatever the mode is", {.mode_shown = 6}},
      {"6061h shows no mode", {.mode_shown = 0}},
      {"60FDh has noise in bits of the vendor", {.input_noise = 0xFFFF0000}, true},
      {"60FDh has noise in the limits", {.input_noise = 0x3}, true},
      {"60FDh has noise in the home switch", {.input_noise = 0x4}, true},
      {"target reached never shows", {.status_never = 0x0400}, true},
      {"homing attained never shows", {.status_never = 0x1000}, true},
      {"homing error always shows", {.status_always = 0x2000}, true},
      {"homing is attained before it began", {.status_always = 0x1400}, true},
      {"a fault bit that always shows", {.status_always = 0x0008}},
      {"no voltage ever shows", {.status_never = 0x0010}, true},
      {"6064h is dead", {.position_dead = true}},
      {"homing is done where it begins", {.home_at_once = true}},
      {"homing does not set 6064h", {.keeps_counter = true}},
      {"homing never begins", {.home_never = true}},
      {"targets are ignored", {.ignores_targets = true}},
  };
  for (const auto& row : kRows)
    for (const char* name : {"x", "y2", "z", "cu"}) {
      SCOPED_TRACE(fmt::format("{}: {}", name, row.what));
      const Outcome out = drive([](auto&) {}, {{name, {.lies = row.lies}}});
      EXPECT_EQ(out.wrong, "");
      const bool not_asked = row.lies.ignores_targets && std::string_view(name) == "z";  // nobody jogs Z here
      EXPECT_TRUE(row.may_work || not_asked || !out.works);
      if (std::getenv("GANTRY_SHOW") != nullptr)
        std::printf("%-3s %-42s %s\n", name, row.what, out.works ? "works" : to_text(out.why).c_str());
    }
}

/// A station that loses its supply, in homing and in a jog.
TEST(Mutations, stations_that_start_anew_in_the_middle_of_it) {
  for (const char* name : {"io", "x", "y1", "z", "cu"})
    for (const int cycle : {200, 600, 1500, 3000, 6000, 9000, 12000}) {
      SCOPED_TRACE(fmt::format("{} at cycle {}", name, cycle));
      const Outcome out = drive(
          [](auto&) {}, {}, fmt::format("- {{at: cycle {}, do: power_cycle, station: {}, dark: 50 ms}}", cycle, name));
      // It stands first on the line: without it nothing answers, and the bus is what there is to name.
      if (out.why.fault != Fault::BusDown || std::string_view(name) != "io") {
        EXPECT_EQ(out.wrong, "");
      }
      if (std::getenv("GANTRY_SHOW") != nullptr)
        std::printf("%-3s %6d %s\n", name, cycle, out.works ? "works" : to_text(out.why).c_str());
    }
}

/// One alteration of one station, and its name.
std::string alter(config::Machine& m, std::mt19937_64& random) {
  const auto any = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  constexpr const char* kNames[] = {"x", "y1", "y2", "z", "cu"};
  const char* const name = kNames[any(std::size(kNames))];
  config::StationProfile& p = station(m, name).profile;
  config::ObjectRow& row = p.objects[any(p.objects.size())];
  const std::string at = fmt::format("{} {:04X}h:{}", name, row.address.index, row.address.sub);
  switch (any(9)) {
    case 0: {
      const auto address = row.address;
      std::erase_if(p.objects, [&](const auto& o) { return o.address == address; });
      return at + " removed";
    }
    case 1: row.writable = false; return at + " read only";
    case 2: row.mappable = false; return at + " not mappable";
    case 3: {
      using T = config::ObjectType;
      constexpr T kTypes[] = {T::I8, T::U8, T::I16, T::U16, T::I32, T::U32};
      row.type = kTypes[any(std::size(kTypes))];
      return at + fmt::format(" of type {}", static_cast<int>(row.type));
    }
    case 4: {
      const auto value = static_cast<std::int64_t>(any(20000));
      row.initial = value;
      if (row.max && value > *row.max) row.initial = *row.max;
      return at + fmt::format(" begins with {}", *row.initial);
    }
    case 5: row.readable = false; return at + " cannot be read";
    case 6: {
      auto& facts = *p.drive;
      std::int8_t* const bits[] = {&facts.input_neg_limit, &facts.input_pos_limit, &facts.input_home};
      const std::size_t a = any(3), b = (a + 1 + any(2)) % 3;
      std::swap(*bits[a], *bits[b]);
      return fmt::format("{} inputs {} and {} swapped", name, a, b);
    }
    case 7: {
      auto& methods = p.drive->homing_methods;
      if (!methods.empty()) methods.erase(methods.begin() + static_cast<std::ptrdiff_t>(any(methods.size())));
      return std::string(name) + " lacks a homing method";
    }
    default: {
      for (auto& sm : p.sync_managers) sm.start = static_cast<std::uint16_t>(sm.start + 0x100);
      return std::string(name) + " SyncManagers elsewhere";
    }
  }
}

TEST(Mutations, at_random) {
  const char* more = std::getenv("GANTRY_ROUNDS");
  const char* seed = std::getenv("GANTRY_SEED");
  const int rounds = more != nullptr ? std::atoi(more) : 25;
  const std::uint64_t first = seed != nullptr ? std::strtoull(seed, nullptr, 10) : 1;
  int works = 0;
  for (int i = 0; i < rounds; ++i) {
    std::mt19937_64 random(first + static_cast<std::uint64_t>(i));
    std::string what;
    const Outcome out = drive([&](config::Machine& m) { what = alter(m, random); });
    works += out.works ? 1 : 0;
    EXPECT_EQ(out.wrong, "") << "seed " << first + static_cast<std::uint64_t>(i) << ": " << what;
    if (std::getenv("GANTRY_SHOW") != nullptr)
      std::printf("%-40s %s\n", what.c_str(), out.works ? "works" : to_text(out.why).c_str());
  }
  std::printf("%d of %d work as well, the others are refused by name\n", works, rounds);
}

}  // namespace
}  // namespace gantry::test
