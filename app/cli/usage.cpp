#include "app/cli/usage.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/near_word.hpp"

namespace gantry::cli {
namespace {

std::vector<std::string> verbs_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

}  // namespace

Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* at = &app;  // the verb that was understood, as far as it was
  std::string said = app.get_name();
  while (!at->get_subcommands().empty()) {
    at = at->get_subcommands().front();
    said += " " + at->get_name();
  }
  const std::vector<std::string> verbs = verbs_of(*at);
  const std::vector<std::string> rest = app.remaining(true);
  const auto word = std::find_if(rest.begin(), rest.end(), [](const std::string& w) { return !w.starts_with('-'); });
  if (verbs.empty() || word == rest.end()) return {Fault::Usage, error.what(), said};
  return {Fault::Usage,
          fmt::format("there is no '{} {}'; {}", said, *word, did_you_mean(*word, {verbs.begin(), verbs.end()})), ""};
}

}  // namespace gantry::cli
