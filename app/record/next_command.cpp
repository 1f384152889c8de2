#include "app/record/next_command.hpp"

#include "core/shell_words.hpp"

namespace gantry::record {
namespace {

std::string of_part(const JobResult& r) {
  return (r.origin.serial.empty() ? "" : " --serial " + shell_word(r.origin.serial)) + r.origin.same_machine.all;
}

}  // namespace

std::string finish_command(const JobResult& r) {
  if (r.to_finish.empty()) return "";
  return "gantry run " + shell_word(r.recipe_file) + " " + r.to_finish + of_part(r) + r.origin.same_machine.run;
}

std::string part_removed_command(const JobResult& r) { return "gantry part-removed" + of_part(r); }

}  // namespace gantry::record
