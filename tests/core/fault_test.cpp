#include "core/fault.hpp"

#include <gtest/gtest.h>
#include <set>
#include <string>

namespace gantry {
namespace {

TEST(FaultCatalogue, numbers_and_names_are_unique_and_ascend) {
  std::set<std::string_view> names;
  const FaultInfo* last = nullptr;
  for (const FaultInfo& row : catalogue()) {
    if (last != nullptr) {
      EXPECT_LT(last->fault, row.fault) << row.name;
    }
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_LT(static_cast<int>(row.fault), 1000) << row.name << ": the code has three digits";
    last = &row;
  }
}

TEST(FaultCatalogue, each_row_says_what_happened_and_what_to_do) {
  for (const FaultInfo& row : catalogue()) {
    EXPECT_FALSE(row.text.empty()) << row.name;
    if (row.fault != Fault::None) {
      EXPECT_FALSE(row.remedy.empty()) << row.name;
    }
    for (const std::string_view sentence : {row.text, row.remedy})
      if (!sentence.empty()) {
        EXPECT_NE(sentence.back(), '.') << row.name << ": texts are put into sentences";
        EXPECT_TRUE(std::islower(static_cast<unsigned char>(sentence[0])) != 0 || sentence[0] == '`') << sentence;
      }
  }
}

TEST(FaultCatalogue, hundreds_agree_with_the_exit_code) {
  // One glance at G4xx tells "file"; scripts that read the exit code must come to the same.
  for (const FaultInfo& row : catalogue()) {
    const int hundred = static_cast<int>(row.fault) / 100;
    if (hundred == 2) {
      EXPECT_EQ(row.exit_code, ExitCode::Device) << row.name;
    }
    if (hundred == 4) {
      EXPECT_EQ(row.exit_code, ExitCode::InvalidFile) << row.name;
    }
    if (hundred == 6) {
      EXPECT_EQ(row.exit_code, ExitCode::VisionOrProbe) << row.name;
    }
    if (row.fault != Fault::None) {
      EXPECT_NE(row.exit_code, ExitCode::Done) << row.name;
    }
  }
}

TEST(FaultCatalogue, what_takes_torque_away_needs_more_than_a_reset) {
  for (const FaultInfo& row : catalogue())
    if (row.reaction >= Reaction::QuickStop) {
      EXPECT_GE(row.clear, Clear::Reenable) << row.name;
    }
}

TEST(FaultCatalogue, info_finds_each_row_and_answers_unknown_numbers_with_internal) {
  for (const FaultInfo& row : catalogue()) EXPECT_EQ(&info(row.fault), &row);
  EXPECT_EQ(info(static_cast<Fault>(999)).fault, Fault::Internal);
  EXPECT_EQ(info(static_cast<Fault>(65535)).fault, Fault::Internal);
}

TEST(FaultCatalogue, code_has_the_form_in_which_people_meet_it) {
  EXPECT_EQ(std::string_view(code(Fault::TransitionTimeout)), "G204");
  EXPECT_EQ(std::string_view(code(Fault::None)), "G000");
  EXPECT_EQ(std::string_view(code(Fault::EventsLost)), "G904");
}

}  // namespace
}  // namespace gantry
