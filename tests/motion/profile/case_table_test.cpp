// What bench/profile_cases takes as CSV, and what it says to what it does not take.
#include "bench/profile/case_table.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <sstream>

namespace gantry::bench {
namespace {

const std::string kHeader = "id,p0,v0,a0,pf,vf,af,vmax,vmin,amax,amin,jmax\n";

/// The cases of a text; what is wrong with it in `error`.
std::vector<Case> read(const std::string& text, std::string& error) {
  std::istringstream in(text);
  std::vector<Case> cases;
  error.clear();
  auto table = CaseTable::open(in, error);
  if (!table) return cases;
  while (const auto c = table->next(error)) {
    if (!error.empty()) break;
    cases.push_back(*c);
  }
  return cases;
}

TEST(CaseTable, takes_ids_in_quotes_line_ends_of_any_kind_and_columns_it_does_not_know) {
  std::string error;
  const auto cases = read(
      "\xef\xbb\xbfnote,id,p0,v0,a0,pf,vf,af,vmax,vmin,amax,amin,jmax\r\n"
      "\"x, y\",\"a, \"\"b\"\"\",1,0,0,2,0,0,3,-4,5,-6,7\r\n\r\nz,c d,1,0,0,2,0,0,3,-4,5,-6,7",
      error);
  ASSERT_EQ(error, "");
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].id, "a, \"b\"");
  EXPECT_EQ(quoted(cases[0].id), "\"a, \"\"b\"\"\"");
  EXPECT_EQ(quoted(cases[1].id), "c d");
  EXPECT_EQ(cases[0].axes[0].bounds.v_min, -4);
  EXPECT_EQ(cases[0].axes[0].bounds.j_min, -7);
}

TEST(CaseTable, names_the_line_and_the_column_that_it_cannot_read) {
  std::string error;
  read(kHeader + "a,0,0,0,1,0,0,1,-1,1,-1,1\nb,0,0,0,1,0,x,1,-1,1,-1,1\n", error);
  EXPECT_EQ(error, "line 3, column 'af': 'x' is no number");
  read(kHeader + "a,0,0\n", error);
  EXPECT_EQ(error, "line 2, column 'a0': '' is no number");
  read("id,p0,v0,a0,pf,vf,af,amax\n", error);
  EXPECT_NE(error, "");
  read("p0,v0\n", error);
  EXPECT_EQ(error, "column 'id' is missing");
  read("", error);
  EXPECT_EQ(error, "no header: the first line names the columns, id,p0,v0,...");
}

TEST(CaseTable, knows_several_axes_and_the_velocity_interface_by_their_columns) {
  std::istringstream several(
      "id,p0_0,v0_0,a0_0,pf_0,vf_0,af_0,vmax_0,vmin_0,amax_0,amin_0,jmax_0,p0_1,v0_1,a0_1,pf_1,"
      "vf_1,af_1,vmax_1,vmin_1,amax_1,amin_1,jmax_1,min_duration\n"
      "a,0,0,0,1,0,0,1,-1,1,-1,1,0,0,0,2,0,0,1,-1,1,-1,1,nan\n");
  std::string error;
  auto table = CaseTable::open(several, error);
  ASSERT_TRUE(table) << error;
  EXPECT_EQ(table->kind(), Kind::Position);
  EXPECT_EQ(table->axes(), 2u);
  EXPECT_EQ(table->next(error)->min_duration_s, 0);
  std::istringstream velocity("id,p0,v0,a0,vf,af,amax,amin,jmax\na,0,1,0,2,0,1,-1,1\n");
  table = CaseTable::open(velocity, error);
  ASSERT_TRUE(table) << error;
  EXPECT_EQ(table->kind(), Kind::Velocity);
}

}  // namespace
}  // namespace gantry::bench
