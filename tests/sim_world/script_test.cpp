#include "sim/script/script.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace gantry::sim {
namespace {

config::Machine machine() {
  config::Machine m = sample::machine();
  m.stations.resize(2);
  m.stations[0].id = StationId{0}, m.stations[0].name = "x";
  m.stations[1].id = StationId{1}, m.stations[1].name = "y1";
  return m;
}

TEST(Script, reads_instants_and_actions) {
  const auto s = parse_script(R"(
- {at: feature dot 7, do: drive_fault, axis: Y, code: 0x7500}
- {at: cycle 12000, do: cut_link, station: y1}
- {at: mark M2, do: stain, name: M2, by: [0.5 mm, 0 mm], diameter: 1 mm}
- {at: "feature dots[0][3]", after: 15 ms, do: press, input: stop, hold: 100 ms}
- {do: add_obstacle, name: brick, centre: [10 mm, 20 mm, 30 mm], size: [1 mm, 2 mm, 3 mm]}
- {at: job start, do: set_input, input: door_closed, on: false}
)",
                              "crash.yaml", machine());
  ASSERT_TRUE(s) << joined(s.error()).message;
  ASSERT_EQ(s->size(), 6u);
  EXPECT_EQ((*s)[0].trigger.kind, Trigger::Kind::NthDot);
  EXPECT_EQ((*s)[0].trigger.count, 7u);
  EXPECT_EQ((*s)[0].action.kind, ActionKind::DriveFault);
  EXPECT_EQ((*s)[0].action.axis, AxisId{1});
  EXPECT_EQ((*s)[0].action.code, 0x7500u);
  EXPECT_EQ((*s)[0].where, "crash.yaml:2:3");
  EXPECT_EQ((*s)[1].trigger.kind, Trigger::Kind::Cycle);
  EXPECT_EQ((*s)[1].trigger.count, 12000u);
  EXPECT_EQ((*s)[1].action.station, StationId{1});
  EXPECT_EQ((*s)[2].trigger.name, "M2");
  EXPECT_EQ((*s)[2].action.at, (Vec3{0.5, 0, 0}));
  EXPECT_EQ((*s)[3].trigger.kind, Trigger::Kind::FeatureId);
  EXPECT_EQ((*s)[3].trigger.name, "dots[0][3]");
  EXPECT_EQ((*s)[3].trigger.after, milliseconds(15));
  EXPECT_EQ((*s)[3].action.hold, milliseconds(100));
  EXPECT_EQ((*s)[3].action.input, config::Input::Stop);
  EXPECT_EQ((*s)[4].trigger.kind, Trigger::Kind::Now);
  EXPECT_EQ((*s)[4].action.size, (Vec3{1, 2, 3}));
  EXPECT_EQ((*s)[5].trigger.kind, Trigger::Kind::JobStart);
}

TEST(Script, reads_what_the_bus_may_suffer) {
  const auto s = parse_script(R"(
- {do: delay_frames, count: 3, by: 2 ms}
- {do: noise, loss: 0.01, reorder: 0.002, seed: 9}
- {do: drift, station: y1, ppm: -80}
- {do: jitter, station: y1, by: 0.2 us}
- {do: ignore_writes, station: x, object: 0x6098}
- {do: set_object, station: x, object: 0x6010:1, value: -1234}
- {do: count_errors, station: y1, port: 1, count: 7}
- {do: stick_statusword, axis: Y}
)",
                              "bus.yaml", machine());
  ASSERT_TRUE(s) << joined(s.error()).message;
  for (const auto& entry : *s) EXPECT_TRUE(of_the_bus(entry.action.kind)) << entry.where;
  EXPECT_EQ((*s)[0].action.hold, milliseconds(2));
  EXPECT_EQ((*s)[0].action.count, 3u);
  EXPECT_EQ((*s)[1].action.noise.loss, 0.01);
  EXPECT_EQ((*s)[1].action.noise.seed, 9u);
  EXPECT_EQ((*s)[2].action.amount, -80);
  EXPECT_EQ((*s)[3].action.hold, nanoseconds(200));
  EXPECT_EQ((*s)[4].action.object, (config::ObjectAddress{0x6098, 0}));
  EXPECT_EQ((*s)[5].action.amount, -1234);
  EXPECT_EQ((*s)[6].action.code, 1u);
  EXPECT_FALSE(parse_script("{do: noise, loss: 1.5}", "bus.yaml", machine()));
  EXPECT_FALSE(parse_script("{do: drive_fault, axis: Y, code: 30000000}", "bus.yaml", machine()))
      << "603Fh has 16 bits";
}

TEST(Script, one_line_is_one_entry) {
  const auto s = parse_script("{do: lose_frames, count: 5}", "stdin", machine());
  ASSERT_TRUE(s);
  ASSERT_EQ(s->size(), 1u);
  EXPECT_EQ((*s)[0].action.count, 5u);
  EXPECT_TRUE(parse_script("[]", "stdin", machine())->empty());
}

TEST(Script, names_every_mistake_with_its_place) {
  const auto s = parse_script(R"(- {at: feature dot 7, do: drive_falt, axis: Y}
- {at: teatime, do: remove_mark, name: M1}
- {do: cut_link, station: y2}
- {do: press}
- {do: stain, by: [1, 2 mm], diameter: 1 mm}
- {do: lose_frames, count: 5, sped: 3}
- 7
)",
                              "bad.yaml", machine());
  ASSERT_FALSE(s);
  std::vector<std::string> where;
  for (const Error& e : s.error()) where.push_back(e.where);
  EXPECT_EQ(where, (std::vector<std::string>{"bad.yaml:1:27", "bad.yaml:2:8", "bad.yaml:3:27", "bad.yaml:4:3",
                                             "bad.yaml:5:20", "bad.yaml:6:31", "bad.yaml:7:3"}));
  EXPECT_NE(s.error()[0].message.find("drive_fault"), std::string::npos) << s.error()[0].message;
  EXPECT_NE(s.error()[2].message.find("y1"), std::string::npos) << s.error()[2].message;
  EXPECT_NE(joined(s.error()).message.find("bad.yaml:7:3"), std::string::npos);
}

}  // namespace
}  // namespace gantry::sim
