#include "app/cli/usage.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <string_view>
#include <utility>

#include "core/near_word.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> verbs_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

/// "--sim-bord" of "--sim-bord=dx=1 mm"; "" of what is no option: a word, or a number below 0.
std::string option_in(const std::string& word) {
  if (word.size() < 2 || word.front() != '-') return "";
  if (word[1] != '-' && std::isalpha(static_cast<unsigned char>(word[1])) == 0) return "";
  return word.substr(0, word.find('='));
}

/// Of the verb, and of those above it.
std::vector<std::string> options_of(const CLI::App* verb) {
  std::vector<std::string> names;
  for (const CLI::App* at = verb; at != nullptr; at = at->get_parent())
    for (std::string& name : long_options(*at)) names.push_back(std::move(name));
  return names;
}

std::optional<double> number(const std::string& word) {
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A word that an option did not take for its number.
std::string no_such_number(const std::string& word) {
  const bool whole = number(word) && word.find_first_not_of("-0123456789") == std::string::npos;
  if (whole) return fmt::format("is '{}', which is too {}", word, word.front() == '-' ? "small" : "large");
  return fmt::format("is '{}', and has to be a {}number", word, number(word) ? "whole " : "");
}

/// What stands before and behind these words.
std::optional<std::pair<std::string, std::string>> around(const std::string& said, std::string_view words) {
  const std::size_t at = said.find(words);
  if (at == std::string::npos) return std::nullopt;
  return std::pair{said.substr(0, at), said.substr(at + words.size())};
}

/// CLI11 counts what it has of an option that takes one, and speaks of its own ways. `verb`: all its words.
std::string in_our_words(const CLI::ParseError& error, const std::string& verb, const std::vector<std::string>& verbs) {
  const std::string said = error.what();
  for (const char* words : {"The following argument was not expected: ", "The following arguments were not expected: "})
    if (const auto words_left = around(said, words))
      return fmt::format("'{}' is not expected here; `{} --help` shows what is", words_left->second, verb);
  if (said == "A subcommand is required") {
    constexpr std::size_t kListed = 12;
    return verbs.size() > kListed ? fmt::format("write what it is to do; `{} --help` lists it", verb)
                                  : fmt::format("write what it is to do; known: {}", fmt::join(verbs, ", "));
  }
  if (const auto options = around(said, " excludes "))
    return fmt::format("'{}' and '{}' are not given together; leave one out", options->first, options->second);
  if (const auto options = around(said, " requires "))
    return fmt::format("'{0}' goes with '{1}' alone; add that, or leave '{0}' out", options->first, options->second);
  if (const auto option = around(said, ": 1 required "); option && option->second.ends_with(" missing"))
    return fmt::format("'{}' lacks its value; write it behind, or leave the option out", option->first);
  if (const std::size_t at = said.find(": At Most 1 required"); at != std::string::npos)
    return fmt::format("'{}' is given twice; give it once", said.substr(0, at));
  if (const std::size_t at = said.find(" was given a disallowed flag override"); at != std::string::npos)
    return fmt::format("'--{}' takes no value; write it alone", said.substr(0, at));
  constexpr std::string_view kNotRead = "Could not convert: ", kIs = " = ";
  if (const std::size_t at = said.find(kIs); said.starts_with(kNotRead) && at != std::string::npos)
    return said.substr(kNotRead.size(), at - kNotRead.size()) + ": " + no_such_number(said.substr(at + kIs.size()));
  return said;
}

}  // namespace

std::vector<std::string> long_options(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string zero_or_more(const std::string& word) {
  const auto value = number(word);
  return value && *value >= 0 ? "" : fmt::format("is '{}', and has to be a number of 0 or more", word);
}

std::string above_zero(const std::string& word) {
  const auto value = number(word);
  return value && *value > 0 ? "" : fmt::format("is '{}', and has to be a number above 0", word);
}

std::string whole_from_zero(const std::string& word) {
  std::uint64_t value = 0;
  const char* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  return read.ec == std::errc{} && read.ptr == end
             ? ""
             : fmt::format("is '{}', and has to be a whole number from 0 to 2^64 - 1", word);
}

std::string override_percent(const std::string& word) {
  const auto value = number(word);
  return value && (*value == 0 || (*value / 100 >= motion::kLeastOverride && *value / 100 <= motion::kMostOverride))
             ? ""
             : fmt::format(
                   "'{}' is no override: write 0, which holds, or 1 to 200, 100 for the recipe's speed (above "
                   "100 as far as `override_max` of the machine or the material allows)",
                   word);
}

std::string folder_to_be(const std::string& path) {
  std::error_code ignored;
  return !fs::exists(path, ignored) || fs::is_directory(path, ignored)
             ? ""
             : fmt::format("'{}' is there and is no folder; name another one", path);
}

std::string file_to_be(const std::string& path) {
  std::error_code ignored;
  const fs::path folder = fs::absolute(path, ignored).parent_path();
  if (fs::is_directory(path, ignored)) return fmt::format("'{}' is a folder; name a file", path);
  return fs::is_directory(folder, ignored)
             ? ""
             : fmt::format("'{}' cannot be made: there is no folder '{}'", path, folder.string());
}

void refuse_slips(CLI::App& app) {
  for (CLI::Option* flag : app.get_options([](const CLI::Option* o) { return o->get_items_expected_max() == 0; }))
    flag->disable_flag_override();
  for (CLI::Option* option : app.get_options([](const CLI::Option* o) { return o->get_items_expected_max() > 0; }))
    option->transform(CLI::Validator(  // before what else looks at it; it changes nothing
        [](const std::string& word) {
          return word.find_first_not_of(" \t") == std::string::npos
                     ? std::string("is empty; write its value, or leave it out")
                     : "";
        },
        ""));
  for (CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) refuse_slips(*verb);
}

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
  // Options behind a word that is no verb are those of the verb that is meant.
  const auto mine = verbs.empty() ? rest.end() : word;
  for (auto each = rest.begin(); each != mine; ++each)
    if (const std::string option = option_in(*each); !option.empty()) {
      const std::vector<std::string> known = options_of(at);
      return {
          Fault::Usage,
          fmt::format("there is no option '{}'; {}", option,
                      did_you_mean(option, {known.begin(), known.end()}, fmt::format("`{} --help` lists them", said))),
          said};
    }
  if (verbs.empty() || word == rest.end()) return {Fault::Usage, in_our_words(error, said, verbs), said};
  if (*word == "help") return {Fault::Usage, fmt::format("there is no '{0} help'; write `{0} --help`", said), ""};
  return {Fault::Usage,
          fmt::format("there is no '{} {}'; {}", said, *word, did_you_mean(*word, {verbs.begin(), verbs.end()})), ""};
}

}  // namespace gantry::cli
