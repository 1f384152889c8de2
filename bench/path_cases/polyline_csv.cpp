#include "bench/path_cases/polyline_csv.hpp"

#include <cmath>
#include <cstdlib>

namespace gantry::bench {

Polyline read_polyline(std::istream& in) {
  Polyline out;
  std::string line;
  if (!std::getline(in, line)) {
    out.error = "no header: the first line names the columns, x,y or x,y,z";
    return out;
  }
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r") continue;
    std::array<double, 3> point{};
    std::size_t axis = 0;
    const char* at = line.c_str();
    for (; axis < 3; ++axis) {
      char* end = nullptr;
      point[axis] = std::strtod(at, &end);
      if (end == at || !std::isfinite(point[axis])) break;
      at = end;
      while (*at == ' ' || *at == '\t') ++at;
      if (*at != ',') {
        ++axis;
        break;
      }
      ++at;
    }
    if (out.axes == 0) out.axes = axis;
    if (axis < 2 || axis != out.axes || (*at != '\0' && *at != '\r')) {
      out.error = "line " + std::to_string(number) + ": expected " +
                  (out.axes == 3 ? "three numbers x,y,z" : "two numbers x,y (or three in every line)");
      return out;
    }
    out.points.push_back(point);
  }
  if (out.points.empty()) out.error = "no points: the lines after the header hold x,y or x,y,z in mm";
  return out;
}

}  // namespace gantry::bench
