// Which part a job meets: by its serial, or as the one in the machine.
#include "app/desk/begun_parts.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

namespace gantry::desk {
namespace {

class KnownParts : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }
  /// What a program does whose job ends with features missing; `clamped`: the clamp is shut after it.
  static void begin(BegunParts& parts, const std::string& serial, bool clamped, bool lost = false) {
    ASSERT_TRUE(parts.keep({.serial = serial,
                            .recipe = "r",
                            .recipe_file = "r.yaml",
                            .sha256 = "0",
                            .began = "2026-01-01",
                            .left = {1},
                            .to_finish = "--only b",
                            .lost = lost}));
    parts.clamped(clamped);
  }
  static std::string met(BegunParts& parts, const std::string& serial, Clamp clamp) {
    const auto found = parts.find(serial, clamp);
    if (!found) return to_text(found.error());
    return *found ? "part '" + (**found).serial + "'" : "another";
  }
  std::string folder_ = std::filesystem::temp_directory_path() / ("gantry-known-" + std::to_string(getpid()));
};

TEST_F(KnownParts, a_serial_does_not_make_another_of_the_part_in_the_machine) {
  BegunParts parts(folder_);
  begin(parts, "", true);
  EXPECT_EQ(met(parts, "Z1", Clamp::Unseen), "part ''");
  EXPECT_EQ(met(parts, "", Clamp::Unseen), "part ''");
  EXPECT_EQ(met(parts, "Z1", Clamp::Open), "another") << "the clamp that held it has opened";
  EXPECT_EQ(met(parts, "", Clamp::Unseen), "another") << "it is forgotten";
}

TEST_F(KnownParts, two_serials_are_two_parts) {
  BegunParts parts(folder_);
  begin(parts, "S1", true);
  EXPECT_EQ(met(parts, "S2", Clamp::Unseen), "another");
  EXPECT_EQ(met(parts, "S1", Clamp::Open), "part 'S1'");
  EXPECT_EQ(met(parts, "", Clamp::Unseen), "part 'S1'");
  EXPECT_EQ(met(parts, "", Clamp::Open), "another");
  EXPECT_EQ(met(parts, "S1", Clamp::Open), "part 'S1'") << "wherever it has been";
}

TEST_F(KnownParts, what_the_clamp_holds_is_met_whatever_the_serial) {
  BegunParts parts(folder_);
  begin(parts, "S2", true);  // and taken out
  begin(parts, "S1", true);
  for (const char* serial : {"S1", "S2", "S3", ""})
    EXPECT_EQ(met(parts, serial, Clamp::Holds), "part 'S1'") << "for '" << serial << "'";
  EXPECT_EQ(met(parts, "S2", Clamp::Open), "part 'S2'");
  EXPECT_EQ(met(parts, "S3", Clamp::Open), "another");
  EXPECT_EQ(met(parts, "S3", Clamp::Unseen), "another") << "a clamp that nobody saw";
}

TEST_F(KnownParts, a_finished_one_that_the_clamp_holds_is_met_by_every_serial) {
  BegunParts parts(folder_);
  begin(parts, "S1", true);
  ASSERT_TRUE(parts.forget("S1"));
  BegunPart done;
  done.serial = "S1";
  ASSERT_TRUE(parts.keep_finished(done));
  EXPECT_EQ(met(parts, "S2", Clamp::Holds), "part 'S1'");
  EXPECT_EQ(met(parts, "S2", Clamp::Open), "another");
  EXPECT_EQ(met(parts, "S2", Clamp::Holds), "another") << "it was forgotten as the clamp was seen open";
}

TEST_F(KnownParts, a_clamp_that_opens_as_a_bus_comes_up_takes_out_nothing) {
  for (const char* serial : {"", "S5"}) {
    BegunParts before(folder_);
    begin(before, serial, true);
    BegunParts after(folder_);  // another program
    EXPECT_EQ(met(after, "", Clamp::Open), "part '" + std::string(serial) + "'");
    ASSERT_TRUE(after.forget_removed(""));
    EXPECT_EQ(met(after, "", Clamp::Open), "another");
    EXPECT_EQ(met(after, "S5", Clamp::Open), *serial == 0 ? "another" : "part 'S5'") << "taken out, it may come back";
    ASSERT_TRUE(after.forget_removed("S5"));
    EXPECT_EQ(met(after, "S5", Clamp::Open), "another");
  }
}

TEST_F(KnownParts, the_one_in_the_machine_is_another_than_that_of_a_serial) {
  BegunParts parts(folder_);
  begin(parts, "S1", true);
  begin(parts, "S2", true);
  EXPECT_EQ(*parts.another_inside("S1"), "S2");
  EXPECT_EQ(*parts.another_inside("S2"), std::nullopt);
  EXPECT_EQ(*parts.another_inside(""), std::nullopt) << "whichever it is";
  ASSERT_TRUE(parts.forget("S2"));
  EXPECT_EQ(*parts.another_inside("S1"), std::nullopt) << "S2 was finished, and may be gone";
  begin(parts, "", true);
  EXPECT_EQ(*parts.another_inside("nosuch"), "") << "it has no serial, and is begun";
}

TEST_F(KnownParts, one_whose_job_was_lost_is_met_with_the_clamp_open_too) {
  for (const char* serial : {"", "S5"}) {
    BegunParts parts(folder_);
    begin(parts, serial, true, true);
    EXPECT_EQ(met(parts, "", Clamp::Open), "part '" + std::string(serial) + "'");
  }
}

// Its owner was killed in the job: no clamp and no hand was seen since, so that it may still lie there.
TEST_F(KnownParts, one_whose_job_was_lost_is_met_by_every_serial_until_somebody_says_that_it_is_out) {
  {
    BegunParts killed(folder_);
    begin(killed, "S2", true);
    killed.clamped(false);  // a begun one that was taken out before
    begin(killed, "S1", true, true);
  }
  BegunParts parts(folder_);  // another program
  for (const Clamp clamp : {Clamp::Unseen, Clamp::Open, Clamp::Holds})
    for (const char* serial : {"S1", "S2", "S3", ""})
      EXPECT_EQ(met(parts, serial, clamp), "part 'S1'") << "for '" << serial << "'";
  ASSERT_TRUE(parts.forget_removed(""));
  EXPECT_EQ(met(parts, "S3", Clamp::Unseen), "another");
  EXPECT_EQ(met(parts, "S2", Clamp::Unseen), "part 'S2'");
  begin(parts, "S1", true, true);
  ASSERT_TRUE(parts.forget("S1")) << "it was finished";
  EXPECT_EQ(met(parts, "S3", Clamp::Unseen), "another");
}

/// In a world that is kept the board lies under the shut clamp when the next program comes, whose bus seems to open it.
TEST_F(KnownParts, in_a_kept_world_the_clamp_has_held_on_between_two_programs) {
  const std::string kept = folder_ + "/begun-sim-kept";
  for (const Clamp clamp : {Clamp::Unseen, Clamp::Open, Clamp::Holds}) {
    {
      BegunParts before(kept);
      begin(before, "K1", true);
    }
    BegunParts after(kept);
    EXPECT_EQ(met(after, "K2", clamp), "part 'K1'");
    EXPECT_EQ(met(after, "", clamp), "part 'K1'");
    after.clamped(true);
    EXPECT_EQ(met(after, "K2", Clamp::Open), "another") << "this one has held it, and let it go";
  }
}

TEST_F(KnownParts, in_a_kept_world_a_finished_one_is_met_by_the_next_program_too) {
  const std::string kept = folder_ + "/begun-sim-kept";
  {
    BegunParts before(kept);
    begin(before, "K1", true);
    ASSERT_TRUE(before.forget("K1"));
    BegunPart done;
    done.serial = "K1", done.recipe = "r";
    done.defects.push_back({"a", record::Defect::Kind::Beside, "far"});
    ASSERT_TRUE(before.keep_finished(done));
  }
  for (const char* serial : {"K1", "K2", ""}) {
    BegunParts after(kept);
    EXPECT_EQ(met(after, serial, Clamp::Unseen), "part 'K1'") << serial;
    EXPECT_EQ(after.board("K1"), record::Board::Defects);
    EXPECT_EQ(after.board(""), record::Board::Defects);
    EXPECT_EQ(after.board("K2"), record::Board::Untouched);
  }
  BegunParts last(kept);
  ASSERT_TRUE(last.forget_removed(""));
  EXPECT_EQ(met(last, "K1", Clamp::Unseen), "another");
  EXPECT_EQ(last.board("K1"), record::Board::Untouched);
}

/// A file that a hand has changed is refused with its name, or read as it is meant.
TEST_F(KnownParts, a_file_that_is_not_as_it_was_written_is_refused) {
  BegunParts parts(folder_);
  begin(parts, "", true);
  const std::string file = folder_ + "/part.json", good = [&] {
    std::ifstream in(file);
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  const auto with = [&](const std::string& old, const std::string& changed) {
    std::string text = good;
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old << " in " << good;
    std::ofstream(file) << text.replace(at, old.size(), changed);
    return met(parts, "", Clamp::Unseen);
  };
  const std::string left = good.substr(good.find("\"left\""));
  for (const auto& [old, changed] : {std::pair<std::string, std::string>{R"("format": 1)", R"("format": 1.5)"},
                                     {R"("format": 1)", R"("format": true)"},
                                     {left, R"("left": [[1.5, 1]]})"},
                                     {left, R"("left": [[-1, 1]]})"},
                                     {left, R"("left": [[1, 0]]})"},
                                     {left, R"("left": [[1, 1, 1]]})"},
                                     {left, R"("left": [[4, 2], [5, 1]]})"},
                                     {R"("recipe": "r")", R"("recipe": ")" + std::string(5000, 'r') + "\""}}) {
    const std::string said = with(old, changed);
    EXPECT_NE(said.find("cannot be read"), std::string::npos) << changed << ": " << said.substr(0, 200);
    EXPECT_LT(said.size(), 500U);
  }
  EXPECT_EQ(with(R"("recipe": "r")", R"("recipe": "s")"), "part ''");
}

}  // namespace
}  // namespace gantry::desk
