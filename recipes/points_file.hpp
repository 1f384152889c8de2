// Points of a bead from a CSV file that lies beside its recipe:
//   x_mm,y_mm,z_mm
//   10.5,20,0
// A header (x_mm,y_mm or x_mm,y_mm,z_mm; x,y,z are read as well), then a point a line: millimetres, decimal points,
// commas between. A byte-order mark, CRLF, blanks around numbers and empty lines are read; nothing else is.
//   auto text = read_beside("recipes/board.yaml", "paths/outline.csv");     // Result<std::string>
//   read_points(*text, mistakes)                                            // mistakes(name of the file)
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.hpp"

namespace gantry::recipes {

/// Where a point may be, in the board's frame: across, and over its top face; mm.
inline constexpr config::Range kOnBoard{-2000, 2000}, kHeight{0, 200};
inline constexpr std::size_t kMostPoints = 100000;  ///< of all beads of a recipe
inline constexpr std::size_t kMostBytesOfPoints = 8u << 20;

/// The points with their locations in the file; fewer than stand there when there are mistakes.
std::vector<config::At<Vec3>> read_points(std::string_view csv, config::Mistakes& mistakes);

/// Text of a file that a recipe names: within the recipe's folder or below it. Names with "..", absolute ones, and
/// links that lead out of the folder are refused. Fault::BadValue, FileUnreadable, FileTooLarge.
Result<std::string> read_beside(const std::string& recipe_file, const std::string& name);
/// The name under which messages know it: "recipes/paths/outline.csv".
std::string shown_beside(std::string_view recipe_file, const std::string& name);

}  // namespace gantry::recipes
