#include "table.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>

namespace gantry::wrong {
namespace {

std::string with_line_ends(std::string text) {
  for (auto at = text.find("\\n"); at != std::string::npos; at = text.find("\\n", at)) text.replace(at, 2, "\n");
  return text;
}

Change change_of(const std::string& words) {
  constexpr std::string_view kBecomes = " => ";
  const auto between = words.find(kBecomes);
  if (between == std::string::npos) throw std::runtime_error("no ' => ' in: " + words);
  return {with_line_ends(words.substr(0, between)), with_line_ends(words.substr(between + kBecomes.size()))};
}

}  // namespace

std::vector<Mistake> read_table(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<Mistake> all;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line.starts_with("#")) continue;
    if (line.starts_with("== ")) {
      Mistake& next = all.emplace_back();
      next.name = line.substr(3), next.line = number;
      continue;
    }
    const auto blank = line.find(' ');
    const std::string key = line.substr(0, blank), words = blank == std::string::npos ? "" : line.substr(blank + 1);
    if (all.empty()) throw std::runtime_error(fmt::format("{}:{}: stands before the first '=='", file, number));
    Mistake& m = all.back();
    if (key == "recipe")
      m.in_recipe.push_back(change_of(words));
    else if (key == "machine")
      m.in_machine.push_back(change_of(words));
    else if (key == "at")
      m.at = with_line_ends(words);
    else if (key == "says")
      m.says.push_back(words);
    else if (key == "exit")
      m.exit_code = std::stoi(words);
    else
      throw std::runtime_error(fmt::format("{}:{}: no such key: {}", file, number, key));
  }
  return all;
}

Changed changed(std::string text, const std::vector<Change>& changes, const std::string& at) {
  std::size_t first = std::string::npos;
  for (const Change& change : changes) {
    const auto found = text.find(change.from);
    if (found == std::string::npos) throw std::runtime_error("not in the file: " + change.from);
    text.replace(found, change.from.size(), change.to);
    if (first == std::string::npos) first = found;
  }
  const auto from_here = first == std::string::npos ? 0 : first;
  const bool before = at.starts_with('^');
  const auto place = before ? text.rfind(at.substr(1), from_here) : text.find(at, from_here);
  if (place == std::string::npos) throw std::runtime_error("not in the changed file: " + at);
  const auto begin = text.begin(), here = begin + static_cast<std::ptrdiff_t>(place);
  const auto line_start = place == 0 ? std::string::npos : text.rfind('\n', place - 1);
  const auto from = begin + static_cast<std::ptrdiff_t>(line_start == std::string::npos ? 0 : line_start + 1);
  const auto column =
      1 + std::count_if(from, here, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return {text, fmt::format("{}:{}", 1 + std::count(begin, here, '\n'), column)};
}

}  // namespace gantry::wrong
