// The catalogue, the threats page and the faults page agree.
#include "tests/architecture/pages.hpp"

#include <gtest/gtest.h>

#include "core/fault.hpp"

namespace gantry::architecture {
namespace {

std::string committed(const char* name) { return read(std::filesystem::path(GANTRY_SOURCE_DIR) / "docs" / name); }

TEST(Pages, states_page_is_what_the_table_says) {
  EXPECT_EQ(committed("states.md"), states_page()) << "run scripts/docs";
}

TEST(Pages, faults_page_is_what_the_catalogue_says) {
  EXPECT_EQ(committed("faults.md"), faults_page()) << "run scripts/docs";
}

TEST(Pages, every_fault_answers_a_threat_that_exists) {
  const auto states = threat_states({}, committed("threats.md"));
  ASSERT_GT(states.size(), 80u);
  for (const FaultInfo& row : catalogue())
    if (!row.threat.empty()) {
      EXPECT_TRUE(states.contains(std::string(row.threat))) << row.name << " answers " << row.threat;
    }
}

TEST(Pages, threats_page_says_what_the_sources_show) {
  const std::string page = committed("threats.md");
  EXPECT_EQ(page, with_states(page, threat_states(source_tree(), page))) << "run scripts/docs";
}

TEST(Pages, state_of_a_threat_follows_the_sources) {
  const std::string page = "| R30 | a | b | c | |\n| R46 | a | b | c | |\n";
  const auto handled = [&](std::vector<SourceFile> tree, const char* row) {
    return threat_states(tree, page).at(row).handled;
  };
  EXPECT_EQ(handled({}, "R30"), Handled::Named);
  EXPECT_EQ(handled({}, "R46"), Handled::NotYet);
  EXPECT_EQ(handled({{"core/fault.cpp", "Fault::DriveFault"}}, "R30"), Handled::Named)
      << "the catalogue raises nothing";
  EXPECT_EQ(handled({{"devices/rt/drive.cpp", "Fault::DriveFaultNoCode"}}, "R30"), Handled::Named) << "another fault";
  const SourceFile raises{"devices/rt/drive.cpp", "return Fault::DriveFault;"};
  EXPECT_EQ(handled({raises}, "R30"), Handled::InProgram);
  EXPECT_EQ(handled({raises, {"tests/devices/rt/drive_test.cpp", "Fault::DriveFault)"}}, "R30"), Handled::Tested);
  EXPECT_EQ(handled({{"tests/devices/rt/drive_test.cpp", "Fault::DriveFault)"}}, "R30"), Handled::Named);
  EXPECT_EQ(handled({{"devices/rt/scale.cpp", "// unwraps (R46)"}}, "R46"), Handled::InProgram);
  const std::vector<SourceFile> one_of_two{{"app/a.cpp", "Fault::CameraTimeout"},
                                           {"tests/a_test.cpp", "Fault::CameraTimeout (R65)"}};
  EXPECT_EQ(cell(threat_states(one_of_two, "| R65 | a | b | c | |\n").at("R65")), "tested: G604; named: G611")
      << "what one fault of the row has is not the other's";
  EXPECT_EQ(with_states("| R46 | a | b | c | tested |\n", threat_states({}, page)), "| R46 | a | b | c | not yet |\n");
}

}  // namespace
}  // namespace gantry::architecture
