// What a terminal is told of a job, in the process that did it and at a client of an owner.
#include "app/desk/figures.hpp"

#include <gtest/gtest.h>

#include "app/record/next_command.hpp"

namespace gantry::desk {
namespace {

TEST(Figures, name_the_files_that_were_not_kept) {
  record::JobResult result;
  for (const std::uint64_t cycles : {0u, 1000u}) {  // before it began, and of a job
    result.cycles.cycles = cycles;
    result.not_kept = {{"setpoints.bin", "No space left on device"}, {"report.html", "Permission denied"}};
    const std::string text = figures(result);
    EXPECT_NE(text.find("  not kept       setpoints.bin: No space left on device\n"), std::string::npos) << text;
    EXPECT_NE(text.find("                 report.html: Permission denied"), std::string::npos) << text;
    result.not_kept.clear();
    EXPECT_EQ(figures(result).find("not kept"), std::string::npos);
  }
}

TEST(Figures, say_what_is_none_where_no_bus_was_opened) {
  record::JobResult result;
  result.exit_code = ExitCode::NotFeasible;
  EXPECT_EQ(figures(result), "no bus was opened: the job failed before it began; the board is untouched");
  result.bus = "ethercat:eth0";
  EXPECT_EQ(figures(result), "ethercat:eth0: the job failed before it began; the board is untouched");
}

TEST(Figures, say_how_a_board_is_finished_on_the_same_machine_in_words_that_a_shell_takes) {
  record::JobResult result;
  result.recipe_file = "my board.yaml";
  result.to_finish = "--only 'a[1]'";
  result.origin.serial = "S 1";
  result.origin.same_machine = {" --machine cell.yaml", " --bus ethercat:eth0"};
  const std::string text = figures(result);
  EXPECT_NE(text.find("  to finish it   gantry run 'my board.yaml' --only 'a[1]' --serial 'S 1' --machine cell.yaml "
                      "--bus ethercat:eth0"),
            std::string::npos)
      << text;
  // No verb but `run` takes a bus.
  EXPECT_EQ(record::part_removed_command(result), "gantry part-removed --serial 'S 1' --machine cell.yaml");
}

}  // namespace
}  // namespace gantry::desk
