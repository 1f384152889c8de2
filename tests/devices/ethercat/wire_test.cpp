// What became of frames has its number, outside the cycles, too: lost, late, twice, another master's; working counters;
// what mailboxes were asked for once more.
#include "devices/ethercat/survey.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

struct WireBench : SurveyBench {
  /// What has come by a check with so many frames, beside what there was before.
  CyclicCounts checked(int frames) {
    const auto before = survey.check_wire(1);
    const auto after = check(frames);
    EXPECT_TRUE(before) << to_text(before.error());
    return before ? after.frames - before->frames : CyclicCounts{};
  }
  WireCheck check(int frames) {
    auto now = survey.check_wire(frames);
    EXPECT_TRUE(now) << to_text(now.error());
    return now ? std::move(*now) : WireCheck{};
  }
};

constexpr std::uint64_t kBesides = 6;  // AL status of each station

TEST(Wire, a_sound_line_loses_nothing) {
  WireBench b;
  EXPECT_EQ(b.checked(50), (CyclicCounts{.sent = 50 + kBesides}));
}

TEST(Wire, lost_late_and_doubled_frames_are_told_apart) {
  WireBench b;
  ASSERT_TRUE(b.survey.scan());
  b.segment.lose_frames(3);
  EXPECT_EQ(b.check(50).frames.lost, 3u);
  b.segment.faults().duplicate(4);
  EXPECT_EQ(b.checked(50).duplicate, 0u);  // before the first figure was taken
  b.segment.faults().duplicate(4);
  const CyclicCounts whole = b.check(50).frames;
  EXPECT_EQ(whole.duplicate, 8u);
  b.segment.faults().delay(2, microseconds(20'200));  // longer than is waited for
  const CyclicCounts delayed = b.check(50).frames, late = delayed - whole;
  EXPECT_EQ(late.lost, 2u);
  EXPECT_EQ(late.late, 2u);
  EXPECT_EQ(late.duplicate, 0u);
  // A header that was changed where nobody looks is no harm; each other one is a lost frame, and one that is no answer.
  b.segment.faults().corrupt_headers(20);
  const CyclicCounts changed = b.check(50).frames - delayed;
  EXPECT_GT(changed.lost, 5u);
  EXPECT_EQ(changed.late + changed.duplicate + changed.malformed + changed.foreign, changed.lost);
}

TEST(Wire, another_master_is_named) {
  WireBench b;
  ASSERT_TRUE(b.survey.scan());
  EXPECT_FALSE(b.check(10).other_master);
  b.segment.faults().add_foreign(7);
  const WireCheck check = b.check(10);
  EXPECT_EQ(check.frames.foreign, 7u);
  EXPECT_EQ(check.frames.lost, 0u);
  ASSERT_TRUE(check.other_master);
  EXPECT_EQ(check.other_master->address[5], std::byte{0x0C});
  EXPECT_EQ(check.other_master->frames, 7u);
}

TEST(Wire, a_master_that_comes_up_beside_another_one_knows_its_name) {
  BusBench b;
  b.segment.faults().add_foreign(20);
  const auto up = b.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_EQ(b.master->blocking_counters().foreign, 20u);
  EXPECT_EQ(b.master->counters().foreign, 0u);
  ASSERT_TRUE(b.master->other_master());
  EXPECT_EQ(b.master->other_master()->address[5], std::byte{0x0C});
  EXPECT_EQ(b.master->other_master()->frames, 0u) << "in the cycles";
}

TEST(Wire, stations_that_do_not_answer_show_in_the_working_counter) {
  WireBench b;
  ASSERT_TRUE(b.survey.scan());
  b.segment.cut_link(4);
  const auto check = b.survey.check_wire(20);
  ASSERT_TRUE(check) << to_text(check.error());
  EXPECT_EQ(check->frames.wkc_low, 20u);
  EXPECT_EQ(check->frames.wkc_zero, 0u);
  EXPECT_EQ(check->frames.lost, 0u);
}

TEST(Wire, what_a_mailbox_is_asked_for_once_more_is_counted) {
  BusBench b;
  b.operate();
  const StationId x = b.machine.stations[1].id;
  EXPECT_EQ(b.master->mailbox_repeats(), 0u);
  // A frame is lost somewhere in each read: where it was the reply, it has to be repeated.
  b.segment.faults().set_noise({.loss = 0.2, .seed = 3});
  int read = 0;
  for (int i = 0; i < 50; ++i) read += b.master->read_object(x, {0x1018, 1}).has_value();
  b.segment.faults().set_noise({});
  EXPECT_GT(read, 40);
  EXPECT_GT(b.master->mailbox_repeats(), 0u);
  EXPECT_EQ(b.master->stations()[2].mailbox_repeats, 0u);
}

}  // namespace
}  // namespace gantry::devices
