// Emergency messages of stations: told by the owner, in idle and in a job, and at no extra frame.
#include "app/stations/station_news.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"
#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Idle;
using test::Rig;
using test::Said;

TEST(Emergencies, an_idle_owner_tells_them_with_station_code_and_text) {
  Said said;
  Idle idle("[{at: cycle 20000, do: drive_fault, axis: X, code: 0x0E}]");
  const auto heard = [&] { return said.count({"station 1 'x'", "000Eh", "above 60 V", "[G128]"}) == 1; };
  EXPECT_TRUE(idle.until(heard, 200)) << said.all();
  EXPECT_LT(idle.now().cycle, 20'030);
}

TEST(Emergencies, in_a_job_they_stand_among_its_events) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 2, after: 300 ms, do: drive_fault, axis: Y, code: 0x3210}"});
  const auto result = rig.run("recipes/demo-board.yaml");
  EXPECT_EQ(result.exit_code, ExitCode::Device);
  EXPECT_EQ(result.errors.front().fault, Fault::DriveFault) << "the drive's own fault is the cause";
  bool told = false;
  for (const std::string& e : result.events) told |= e.find("[G128]") != std::string::npos;
  EXPECT_TRUE(told);
}

TEST(Emergencies, are_fetched_without_an_extra_frame) {
  devices::BusBench b;
  b.operate();
  stations::StationNews news(*b.master, b.machine);
  b.cycles(20);
  while (news.mail()) {  // what the bring-up may have left
    b.master->step_by([&] { b.cycle(); });
    news.fetch();
    b.master->step_by({});
    b.cycles(20);
  }
  b.segment.drive_fault(config::find_axis(b.machine, "Y")->id, 1, 0x3210);
  int waited = 0;
  while (!news.mail() && waited < 100) b.cycle(), ++waited;
  EXPECT_LT(waited, 20);
  const auto frames = b.master->counters().sent, cycles = b.master->cycles();
  b.master->step_by([&] { b.cycle(); });
  const auto items = news.fetch();
  b.master->step_by({});
  EXPECT_EQ(b.master->counters().sent - frames, b.master->cycles() - cycles) << "one frame a cycle as ever";
  ASSERT_EQ(items.size(), 1u);
  EXPECT_EQ(items[0].detail, 0x3210);
  EXPECT_EQ(items[0].words.where, "station 3 'y2'");
  b.cycles(20);
  EXPECT_FALSE(news.mail());
}

TEST(Emergencies, codes_that_no_drive_lists_have_the_text_of_their_class) {
  EXPECT_EQ(stations::emergency_class(0x2310), "current, output side");
  EXPECT_EQ(stations::emergency_class(0x2F00), "current");
  EXPECT_EQ(stations::emergency_class(0x8130), "communication");
  EXPECT_EQ(stations::emergency_class(0xA001), "refused SAFE_OP to OP");
  EXPECT_EQ(stations::emergency_class(0xFF19), "device specific");
  EXPECT_EQ(stations::emergency_class(0xB000), "of a class that no standard names");
}

}  // namespace
}  // namespace gantry
