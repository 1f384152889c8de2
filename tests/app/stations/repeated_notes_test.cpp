#include "app/stations/repeated_notes.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::stations {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000, kStep = 10'000'000;

TEST(RepeatedNotes, a_note_that_comes_once_is_told_at_once_and_once) {
  RepeatedNotes<std::string> notes;
  const auto told = notes.tell({Fault::LateCycle}, 5 * kSecond, "late");
  ASSERT_TRUE(told);
  EXPECT_EQ(told->note, "late");
  EXPECT_EQ(told->count, 1);
  for (int s = 5; s < 100; ++s) EXPECT_TRUE(notes.due(s * kSecond).empty());
}

TEST(RepeatedNotes, a_burst_is_two_notes_of_which_the_second_counts_the_rest) {
  RepeatedNotes<std::string> notes;
  int at_once = 0;
  for (int i = 0; i < 33; ++i) at_once += notes.tell({Fault::LateCycle}, i * kStep, std::to_string(i)) ? 1 : 0;
  EXPECT_EQ(at_once, 1);
  EXPECT_TRUE(notes.due(kSecond - 1).empty());
  const auto due = notes.due(kSecond);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].count, 32);
  EXPECT_EQ(due[0].note, "32") << "the newest";
  EXPECT_TRUE(notes.due(100 * kSecond).empty());
}

TEST(RepeatedNotes, one_that_goes_on_for_a_minute_is_told_seven_times) {
  RepeatedNotes<int> notes;
  int told = 0, counted = 0;
  for (std::int64_t now = 0; now <= 61 * kSecond; now += kStep) {
    if (const auto t = notes.tell({Fault::LateCycle}, now, 0)) ++told, counted += t->count;
    for (const auto& t : notes.due(now)) ++told, counted += t.count;
  }
  EXPECT_EQ(told, 7) << "at 0, 1, 3, 7, 15, 31, 61 s";
  EXPECT_EQ(counted, 6101);
}

TEST(RepeatedNotes, stations_do_not_hold_each_other_back) {
  RepeatedNotes<int> notes;
  EXPECT_TRUE(notes.tell({Fault::EmergencyMessage, 1}, 0, 0));
  EXPECT_TRUE(notes.tell({Fault::EmergencyMessage, 2}, 0, 0));
  EXPECT_FALSE(notes.tell({Fault::EmergencyMessage, 1}, 0, 0));
}

TEST(RepeatedNotes, after_a_minute_of_quiet_the_next_one_is_told_at_once) {
  RepeatedNotes<int> notes;
  for (int i = 0; i < 5; ++i) notes.tell({Fault::LateCycle}, i, 0);
  EXPECT_EQ(notes.due(2 * kSecond).size(), 1u);
  EXPECT_TRUE(notes.tell({Fault::LateCycle}, 62 * kSecond, 0));
  EXPECT_FALSE(notes.tell({Fault::LateCycle}, 63 * kSecond - 1, 0)) << "and the first pause is a second again";
  EXPECT_EQ(notes.due(63 * kSecond).size(), 1u);
}

TEST(RepeatedNotes, what_is_held_back_is_told_at_the_end_of_a_job_and_the_next_one_begins_anew) {
  RepeatedNotes<std::string> notes;
  EXPECT_TRUE(notes.tell({Fault::LateCycle}, 0, "first"));
  EXPECT_FALSE(notes.tell({Fault::LateCycle}, 10, "second"));
  EXPECT_FALSE(notes.tell({Fault::LateCycle}, 20, "third"));
  const auto held = notes.flush(kSecond / 2);
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(held[0].note, "third");
  EXPECT_EQ(held[0].count, 2);
  EXPECT_EQ(held[0].age_ns, kSecond / 2 - 20);
  EXPECT_TRUE(notes.flush(kSecond).empty());
  EXPECT_TRUE(notes.tell({Fault::LateCycle}, kSecond / 2 + 1, "of the next job"));
}

TEST(RepeatedNotes, what_is_told_late_says_how_late) {
  EXPECT_EQ(again(1), "");
  EXPECT_EQ(again(1, kSecond / 4), "");
  EXPECT_EQ(again(1, 13'449'000'000), ", 13.4 s ago");
  EXPECT_EQ(again(3, kSecond), ", 1.0 s ago (2 more times since it was last told)");
}

TEST(RepeatedNotes, whatever_comes_when_the_counts_make_up_all_of_it) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    RepeatedNotes<int> notes;
    int came = 0, counted = 0;
    std::int64_t now = 0;
    for (int i = 0; i < 400; ++i) {
      now += std::uniform_int_distribution<std::int64_t>(0, seed % 3 == 0 ? 40 * kSecond : kSecond / 4)(random);
      const int of = static_cast<int>(random() % 3);
      if (random() % 4 == 0) {
        for (const auto& t : notes.due(now)) counted += t.count;
      } else {
        ++came;
        if (const auto t = notes.tell({Fault::LateCycle, of}, now, 0)) counted += t->count;
      }
      EXPECT_LE(counted, came);
    }
    for (const auto& t : notes.due(now + 60 * kSecond)) counted += t.count;
    EXPECT_EQ(counted, came);
  }
}

}  // namespace
}  // namespace gantry::stations
