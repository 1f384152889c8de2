// A polyline from CSV: a header, then x,y[,z] in mm a line; the first row is the start.
#pragma once
#include <array>
#include <istream>
#include <string>
#include <vector>

namespace gantry::bench {

struct Polyline {
  std::vector<std::array<double, 3>> points;
  std::size_t axes = 0;  ///< 2 or 3
  std::string error;     ///< not empty: what is wrong, with the line
};

Polyline read_polyline(std::istream& in);

}  // namespace gantry::bench
