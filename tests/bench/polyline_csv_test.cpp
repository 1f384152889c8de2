// A polyline that is read otherwise than it was meant is judged for nothing.
#include "bench/path_cases/polyline_csv.hpp"

#include <gtest/gtest.h>
#include <sstream>

namespace gantry::bench {
namespace {

Polyline read(const std::string& text) {
  std::istringstream in(text);
  return read_polyline(in);
}

TEST(PolylineCsv, reads_what_follows_the_header) {
  const Polyline two = read("x,y\n1,2\n3.5,-4e-1\n"), three = read("x,y,z\r\n1,2,3\r\n\r\n4,5,6");
  EXPECT_EQ(two.error, "");
  EXPECT_EQ(two.axes, 2u);
  ASSERT_EQ(two.points.size(), 2u);
  EXPECT_EQ(two.points[1][1], -0.4);
  EXPECT_EQ(three.error, "");
  EXPECT_EQ(three.axes, 3u);
  ASSERT_EQ(three.points.size(), 2u);
  EXPECT_EQ(three.points[1][2], 6);
}

TEST(PolylineCsv, columns_the_other_way_round_are_refused) {
  EXPECT_NE(read("y,x\n0,0\n1,1\n").error.find("names y first"), std::string::npos);
  EXPECT_NE(read(" Y_mm,X_mm\n0,0\n1,1\n").error.find("names y first"), std::string::npos);
  EXPECT_EQ(read("x_mm,y_mm\n0,0\n1,1\n").error, "");
}

TEST(PolylineCsv, a_point_where_the_header_belongs_is_not_lost) {
  for (const char* text : {"0,0\n1,1\n", "0 , 0\n1,1\n", "-1.5e3,0,0\r\n1,1,1\r\n",
                           "\xEF\xBB\xBF"
                           "0,0\n1,1\n"})
    EXPECT_NE(read(text).error.find("line 1 is a point, not a header"), std::string::npos) << text;
  EXPECT_NE(read("").error, "");
  EXPECT_NE(read("x,y\n").error, "");
}

TEST(PolylineCsv, a_line_without_an_end_is_not_read_to_its_end) {
  EXPECT_NE(read(std::string(100'000, '\0')).error.find("line 1 has more"), std::string::npos);
  EXPECT_NE(read("x,y\n0,0\n" + std::string(100'000, '1')).error.find("line 3 has more"), std::string::npos);
}

}  // namespace
}  // namespace gantry::bench
