#include "tests/machine/mutated.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/altered.hpp"
#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry::test {
namespace {

/// Named: the reason says which station, axis or object it is about.
bool names_something(const Error& why) { return why.fault != Fault::None && !why.where.empty(); }

}  // namespace

Outcome drive(const std::function<void(config::Machine&)>& wired, const Habits& habits, const std::string& script) {
  const Said said;
  Rig rig({.placement = "dx=0 mm", .script = script, .wired = wired, .habits = habits});
  Outcome out;
  const auto tell = [&] {
    out.said = said.all();
    if (const auto world = rig.owner().world()->axes())
      for (const config::Axis& axis : rig.machine().axes)
        if (axis.name == "Z") out.z_mm = (*world)[axis.id.value];
    return out;
  };
  const auto refused = [&](const Error& why) {
    out.why = why;
    if (!names_something(why)) out.wrong = "refused without a name: " + to_text(why);
    return tell();
  };
  if (const auto up = rig.owner().bring_up(); !up) return refused(up.error());
  const auto home = rig.owner().home();
  const auto off = [&](const config::Axis& axis, double by) {
    const auto world = rig.owner().world()->axes();
    return world ? (*world)[axis.id.value] - rig.owner().latest().actual[axis.id.value] - by : 1e9;
  };
  constexpr double kOff = 0.02;  // mm or rad: two counts and what a motor still creeps
  for (int i = 0; i < 100; ++i) static_cast<void>(rig.owner().idle());
  for (const config::Axis& axis : rig.machine().axes) {
    if (axis.kind != config::AxisKind::Streamed) continue;
    const bool referenced = (rig.owner().latest().referenced >> axis.id.value & 1u) != 0;
    if (referenced && std::abs(off(axis, 0)) > kOff)
      out.wrong = fmt::format("{} is called referenced and stands {:.3f} elsewhere", axis.name, off(axis, 0));
  }
  if (!home) return refused(home.error());
  for (const auto& [name, by] : {std::pair{"X", "7 mm"}, {"Y", "7 mm"}, {"C", "5 deg"}, {"Z", "-3 mm"}}) {
    job::JogWords words;
    words.by[name] = by;
    if (const auto jogged = rig.owner().jog(words); !jogged) return refused(jogged.error());
  }
  for (int i = 0; i < 100; ++i) static_cast<void>(rig.owner().idle());
  for (const config::Axis& axis : rig.machine().axes)
    if (axis.kind == config::AxisKind::Streamed && std::abs(off(axis, 0)) > kOff)
      out.wrong = fmt::format("{} has gone {:.3f} elsewhere", axis.name, off(axis, 0));
  out.works = true;
  return tell();
}

Outcome expect_as_well_or_refused(const Lie& lie) {
  SCOPED_TRACE(fmt::format("{}: {}", lie.station, lie.what));
  const Outcome out = drive(
      lie.wired ? lie.wired : [](config::Machine&) {}, {{lie.station, lie.habits}}, lie.script);
  EXPECT_EQ(out.wrong, "");
  EXPECT_EQ(out.works, lie.refused.empty()) << to_text(out.why);
  for (const char* word : lie.refused) EXPECT_NE(to_text(out.why).find(word), std::string::npos) << to_text(out.why);
  if (std::getenv("GANTRY_SHOW") != nullptr)
    std::printf("%-3s %-50s %s\n", lie.station, lie.what, out.works ? "works" : to_text(out.why).c_str());
  return out;
}

void by_sdo(config::Machine& machine) {
  for (const char* name : {"x", "y1", "y2", "z", "cu"})
    for (const int index : {0x6060, 0x6061, 0x60FD, 0x603F})
      object(machine, name, {static_cast<std::uint16_t>(index), 0}).mappable = false;
}

}  // namespace gantry::test
