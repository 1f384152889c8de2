// Tables of mistakes: what is written wrong, where the one message about it points, what it says and its exit code.
//   == a speed without its unit                 a mistake's name
//   recipe speed: 15 mm/s => speed: 15          the recipe with this in place of that, where that stands first
//   machine FROM => TO                          the same of the machine file; \n is a line's end
//   at 15                                       where it is told: here, at or behind the first change; ^15: last before
//   it says write for example                      a part of the message; may stand several times exit 3
#pragma once
#include <string>
#include <vector>

namespace gantry::wrong {

struct Change {
  std::string from, to;
};
struct Mistake {
  std::string name;
  std::vector<Change> in_recipe, in_machine;
  std::string at;
  std::vector<std::string> says;
  int exit_code = 0;
  int line = 0;  ///< of the table
};

/// Throws std::runtime_error at what is no table.
std::vector<Mistake> read_table(const std::string& file);

/// `text` with the changes made; throws std::runtime_error where one finds nothing to change. `at`: line and column,
/// from 1, in characters, of the mark as the table describes it, behind the first change.
struct Changed {
  std::string text;
  std::string at;  ///< "14:7"
};
Changed changed(std::string text, const std::vector<Change>& changes, const std::string& at);

}  // namespace gantry::wrong
