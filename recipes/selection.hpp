// Which features of a recipe a job dispenses, by the names that people give them: that of a dot or bead, of an array or
// a fill (all of it), or of one element of them ("dots[3][5]").
//   auto chosen = choose(recipe, {.from = "dam"});   Job job = only(compiled, *chosen);
// Marks, touches and the purge stay in the job: features need what they measure.
#pragma once
#include <string>
#include <vector>

#include "core/error.hpp"
#include "recipes/job.hpp"

namespace gantry::recipes {

struct Selection {
  std::string from{};  ///< this feature and all that are dispensed behind it; of an array, from its first element on
  std::vector<std::string> only{};     ///< these, in the order in which they are dispensed
  bool finish = false;                 ///< what a begun part lacks: `lacking`, as who remembers it fills it in
  std::vector<std::size_t> lacking{};  ///< indices in Recipe::features, ascending
  [[nodiscard]] bool all() const { return from.empty() && only.empty() && !finish; }
};

/// Indices in Recipe::features, ascending, each once. Fault::Usage: a name that the recipe does not have, nothing
/// named, or more than one kind at once. Fault::Refused: the recipe has fewer features than when the part was begun.
Result<std::vector<std::size_t>> choose(const Recipe& recipe, const Selection& selection);

/// The job without the features that are not chosen.
Job only(Job job, const std::vector<std::size_t>& chosen);

/// The shortest selection that chooses just these; all of them: from the first.
Selection selection_of(const Recipe& recipe, const std::vector<std::size_t>& chosen);
/// As options of the command line: "--from dam", "--only 'dots[3][5],dam'".
std::string to_text(const Selection& selection);

}  // namespace gantry::recipes
