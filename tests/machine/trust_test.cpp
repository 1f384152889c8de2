// A whole machine whose stations are not what its file says: nothing moves, and the reason is named.
#include <algorithm>

#include "tests/machine/idle.hpp"

namespace gantry {
namespace {

using test::Rig;

config::Station& station(config::Machine& machine, std::string_view name) {
  return *std::ranges::find(machine.stations, name, &config::Station::name);
}
config::ObjectRow& object(config::Machine& machine, std::string_view name, config::ObjectAddress address) {
  return *std::ranges::find(station(machine, name).profile.objects, address, &config::ObjectRow::address);
}

struct Altered {
  const char* what;
  std::function<void(config::Machine&)> wired;
  Fault fault;
  const char* names;
};

/// Everything that is asked of a machine, in turn; nothing may move.
TEST(Trust, a_machine_with_one_altered_station_is_refused_by_name_and_does_not_move) {
  const Altered all[] = {
      {"both sides of Y are foreign",
       [](auto& m) { station(m, "y1").profile.identity.vendor = station(m, "y2").profile.identity.vendor = 0x5A5A; },
       Fault::IdentityMismatch, "'y1'"},
      {"X and Z are swapped", [](auto& m) { std::swap(station(m, "x").alias, station(m, "z").alias); },
       Fault::IdentityMismatch, "'z'"},
      {"open loop",
       [](auto& m) {
         for (auto& row : station(m, "x").profile.startup)
           if (row.address.index == 0x20D9) row.value = 0;
       },
       Fault::ParameterDiffers, "20D9h"},
      {"another resolution",
       [](auto& m) {
         for (auto& row : station(m, "cu").profile.startup)
           if (row.address.index == 0x20F2) row.value = 4000;
       },
       Fault::ParameterDiffers, "20F2h"},
      {"limit functions cannot be written",
       [](auto& m) {
         object(m, "z", {0x2190, 2}).writable = false;
       },
       Fault::ParameterDiffers, "2190h:2"},
      {"another motor current",
       [](auto& m) {
         for (auto& row : station(m, "y1").profile.startup)
           if (row.address.index == 0x2000) row.value = 8000;
       },
       Fault::ParameterDiffers, "run_current"},
  };
  for (const Altered& a : all) {
    Rig rig({.wired = a.wired});
    AxisVec first{};
    bool any = false, moved = false, torque = false;
    rig.owner().on_step([&] {
      const auto& now = rig.owner().latest();
      if (!any) first = now.target, any = true;
      for (std::size_t i = 0; i < 5; ++i) moved = moved || now.target[i] != first[i];
      torque = torque || now.enabled != 0;
    });
    const auto up = rig.owner().bring_up();
    Error why;
    if (!up) {
      why = up.error();
    } else {
      const auto enabled = rig.owner().enable();
      ASSERT_FALSE(enabled) << a.what;
      why = enabled.error();
      EXPECT_FALSE(rig.owner().home()) << a.what;
      job::JogWords words;
      words.by["X"] = "1 mm";
      EXPECT_FALSE(rig.owner().jog(words)) << a.what;
      EXPECT_NE(rig.run("recipes/demo-board.yaml").exit_code, ExitCode::Done) << a.what;
    }
    EXPECT_EQ(why.fault, a.fault) << a.what << ": " << to_text(why);
    EXPECT_NE(to_text(why).find(a.names), std::string::npos) << a.what << ": " << to_text(why);
    EXPECT_FALSE(moved) << a.what;
    EXPECT_FALSE(torque) << a.what;
    rig.owner().on_step({});
  }
}

}  // namespace
}  // namespace gantry
