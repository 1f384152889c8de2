#include "recipes/selection.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <unordered_map>

#include "core/near_word.hpp"
#include "core/shell_words.hpp"
#include "core/trimmed.hpp"

namespace gantry::recipes {
namespace {

constexpr const char* kFrom = "--from";
constexpr const char* kOnly = "--only";
constexpr const char* kFinish = "--finish";

/// The name that the recipe gives: of "dots[3][5]" that of the array.
std::string_view name_of(std::string_view id) { return id.substr(0, id.find('[')); }

/// Elements of one array stand next to each other in the recipe, whatever the order in which they are dispensed.
struct Run {
  std::size_t first = 0, end = 0;
  [[nodiscard]] bool holds(std::size_t feature) const { return feature >= first && feature < end; }
};

class Names {
 public:
  explicit Names(const Recipe& recipe) : recipe_(recipe) {
    for (std::size_t i = 0; i < recipe.features.size(); ++i) {
      const std::string_view id = id_of(recipe.features[i]), name = name_of(id);
      runs_.try_emplace(name, Run{i, i}).first->second.end = i + 1;
      runs_.try_emplace(id, Run{i, i + 1});
    }
  }
  [[nodiscard]] Run run(std::string_view name) const { return runs_.at(name); }
  Result<Run> find(std::string_view written, const char* option) const {
    const std::string_view word = trimmed(written);
    if (word.empty()) return fail(Fault::Usage, "a feature's name is missing here", option);
    if (const auto found = runs_.find(word); found != runs_.end()) return found->second;
    const std::size_t bracket = word.find('[');
    const bool element = bracket != std::string_view::npos;
    if (const auto whole = runs_.find(word.substr(0, bracket)); element && whole != runs_.end()) {
      constexpr std::size_t kListed = 20;
      const auto [first, end] = whole->second;
      if (id_of(recipe_.features[first]) == whole->first)
        return fail(Fault::Usage, fmt::format("'{0}' is one feature, without elements; write '{0}'", whole->first),
                    option);
      std::vector<std::string_view> elements;
      for (std::size_t i = first; i < std::min(end, first + kListed); ++i)
        elements.push_back(id_of(recipe_.features[i]));
      return fail(Fault::Usage,
                  fmt::format("there is no '{}'; the {} elements of '{}' are {}{}", word.substr(0, 100), end - first,
                              whole->first, fmt::join(elements, ", "), end - first > kListed ? ", ..." : ""),
                  option);
    }
    std::vector<std::string_view> known;
    for (const Feature& feature : recipe_.features) {
      const std::string_view shown = element ? id_of(feature) : name_of(id_of(feature));
      if (known.empty() || known.back() != shown) known.push_back(shown);
    }
    return fail(Fault::Usage,
                fmt::format("{} has no feature '{}'; {}", recipe_.file, word.substr(0, 100), did_you_mean(word, known)),
                option);
  }

 private:
  const Recipe& recipe_;
  std::unordered_map<std::string_view, Run> runs_;
};

}  // namespace

std::vector<std::size_t> dispensed_by(const Job& job) {
  std::vector<std::size_t> all;
  for (const Block& block : job.blocks)
    if (const auto* dispense = std::get_if<Dispense>(&block.what))
      all.insert(all.end(), dispense->features.begin(), dispense->features.end());
  return all;
}

Result<std::vector<std::size_t>> choose(const Recipe& recipe, const Selection& selection) {
  if (!selection.from.empty() && !selection.only.empty())
    return fail(Fault::Usage, "'--from' and '--only' are not given together; name each feature with '--only'", kOnly);
  if (selection.finish && !(selection.from.empty() && selection.only.empty()))
    return fail(Fault::Usage, "'--finish' dispenses what the part lacks; leave '--from' and '--only' out", kFinish);
  if (selection.finish) {
    if (selection.lacking.empty() || selection.lacking.back() < recipe.features.size()) return selection.lacking;
    return fail(Fault::Refused,
                "the part was begun with another recipe, or with this one before it was changed: that one has more "
                "features; give --finish with it, or say `gantry part-removed` when the part is taken out",
                recipe.file);
  }
  const Names names(recipe);
  std::vector<bool> taken(recipe.features.size(), selection.all());
  if (!selection.from.empty()) {
    const auto run = names.find(selection.from, kFrom);
    if (!run) return tl::unexpected(run.error());
    const std::vector<std::size_t> sequence = sequence_of(recipe);
    const auto first = std::find_if(sequence.begin(), sequence.end(), [&](std::size_t f) { return run->holds(f); });
    std::for_each(first, sequence.end(), [&](std::size_t f) { taken[f] = true; });
  }
  for (const std::string& word : selection.only) {
    const auto run = names.find(word, kOnly);
    if (!run) return tl::unexpected(run.error());
    for (std::size_t f = run->first; f < run->end; ++f) taken[f] = true;
  }
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < taken.size(); ++i)
    if (taken[i]) chosen.push_back(i);
  return chosen;
}

Job only(Job job, const std::vector<std::size_t>& chosen) {
  for (Block& block : job.blocks)
    if (auto* dispense = std::get_if<Dispense>(&block.what))
      std::erase_if(dispense->features,
                    [&](std::size_t f) { return !std::binary_search(chosen.begin(), chosen.end(), f); });
  return job;
}

Selection selection_of(const Recipe& recipe, const std::vector<std::size_t>& chosen) {
  const Names names(recipe);
  const auto name_at = [&](std::size_t i) { return name_of(id_of(recipe.features[i])); };
  std::vector<std::string> words;
  for (std::size_t k = 0; k < chosen.size();) {
    const Run run = names.run(name_at(chosen[k]));
    const std::size_t last = k + (run.end - run.first) - 1;
    const bool whole = chosen[k] == run.first && last < chosen.size() && chosen[last] == run.end - 1;
    words.emplace_back(whole ? name_at(chosen[k]) : id_of(recipe.features[chosen[k]]));
    k = whole ? last + 1 : k + 1;
  }
  if (words.size() < 2) return {.only = std::move(words)};
  const std::vector<std::size_t> sequence = sequence_of(recipe);
  std::vector<std::size_t> last(sequence.end() - static_cast<std::ptrdiff_t>(chosen.size()), sequence.end());
  const std::size_t first = last.front();
  std::sort(last.begin(), last.end());
  if (last != chosen) return {.only = std::move(words)};
  const Run run = names.run(name_at(first));
  const bool begins_run = std::find_if(sequence.begin(), sequence.end(), [&](std::size_t f) { return run.holds(f); }) ==
                          sequence.end() - static_cast<std::ptrdiff_t>(chosen.size());
  return {.from = std::string(begins_run ? name_at(first) : id_of(recipe.features[first]))};
}

std::string to_text(const Selection& selection) {
  if (selection.finish) return kFinish;
  if (!selection.from.empty()) return "--from " + shell_word(selection.from);
  if (selection.only.empty()) return "";
  return "--only " + shell_word(fmt::format("{}", fmt::join(selection.only, ",")));
}

}  // namespace gantry::recipes
