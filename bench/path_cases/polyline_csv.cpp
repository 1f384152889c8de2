#include "bench/path_cases/polyline_csv.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

namespace gantry::bench {
namespace {

constexpr std::size_t kLongestLine = 4096;  ///< bytes; three numbers take less than 100

/// False at the end. A line that is too long is given as its first bytes, one more than allowed.
bool next_line(std::istream& in, std::string& line) {
  line.clear();
  for (char c = 0; line.size() <= kLongestLine && in.get(c);) {
    if (c == '\n') return true;
    line.push_back(c);
  }
  return !line.empty();
}

bool begins_with_a_number(const std::string& line) {
  const char* at = line.c_str();
  if (line.starts_with("\xEF\xBB\xBF")) at += 3;
  char* end = nullptr;
  std::strtod(at, &end);
  while (*end == ' ' || *end == '\t') ++end;
  return end != at && (*end == ',' || *end == '\r' || *end == '\0');
}

/// "y,x": whoever wrote that would get another path.
bool names_y_first(const std::string& header) {
  const auto first = std::find_if(header.begin(), header.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  return first != header.end() && (*first == 'y' || *first == 'Y');
}

std::string too_long(std::size_t number) {
  return "line " + std::to_string(number) + " has more than " + std::to_string(kLongestLine) +
         " bytes: expected lines of x,y or x,y,z";
}

}  // namespace

Polyline read_polyline(std::istream& in) {
  Polyline out;
  std::string line;
  if (!next_line(in, line)) out.error = "no header: the first line names the columns, x,y or x,y,z";
  if (begins_with_a_number(line))
    out.error =
        "line 1 is a point, not a header: put a line x,y or x,y,z before it, else the first point would be lost";
  if (names_y_first(line)) out.error = "line 1 names y first: expected the columns x,y or x,y,z";
  if (line.size() > kLongestLine) out.error = too_long(1);
  if (!out.error.empty()) return out;
  for (std::size_t number = 2; next_line(in, line); ++number) {
    if (line.size() > kLongestLine) {
      out.error = too_long(number);
      return out;
    }
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
