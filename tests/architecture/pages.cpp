#include "tests/architecture/pages.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <regex>

#include "app/cycle/machine_state.hpp"
#include "core/fault.hpp"

namespace gantry::architecture {
namespace {

constexpr std::array kReactions{"note", "path stop", "axis-wise stop", "quick stop", "off"};
constexpr std::array kClears{"-",           "reset",  "reset, resume", "reset, enable", "reset, enable, home",
                             "power cycle", "restart"};

struct Chapter {
  int hundred;
  const char* title;
};
constexpr Chapter kChapters[] = {{1, "Bus and timing of the controller"},
                                 {2, "Drives"},
                                 {3, "Axes and motion"},
                                 {4, "Files"},
                                 {5, "Feasibility"},
                                 {6, "Vision and probe"},
                                 {7, "Refusals and the operator"},
                                 {9, "The program itself"}};

/// "R07" at a word's edge.
bool mentions(const std::string& text, const std::string& word) {
  const auto part_of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const bool starts = at == 0 || !part_of_word(text[at - 1]);
    const bool ends = at + word.size() >= text.size() || !part_of_word(text[at + word.size()]);
    if (starts && ends) return true;
  }
  return false;
}

bool is_catalogue(const SourceFile& file) {
  return file.path.starts_with("core/fault") || file.path == "tests/core/fault_test.cpp" ||
         within(file.path, "tests/architecture");
}

bool is_threat_row(const std::vector<std::string>& row) {
  return row.size() == 5 && std::regex_match(row[0], std::regex("R[0-9]{2}"));
}

}  // namespace

std::string faults_page() {
  std::string page =
      "# Faults\n\n"
      "Written by `scripts/docs` from `core/fault_table.def`. `gantry explain CODE` tells the same.\n\n"
      "*Reaction* is what the machine does, *clear* how the latch is lifted (never by itself, and lifting it starts no "
      "motion),\n*exit* the program's exit code when a job ends by it, *row* the cause in [threats.md](threats.md).\n";
  for (const Chapter& chapter : kChapters) {
    page += fmt::format(
        "\n## {}\n\n| code | what happened | what to do | reaction | clear | exit | row |\n"
        "|---|---|---|---|---|---|---|\n",
        chapter.title);
    for (const FaultInfo& row : catalogue())
      if (static_cast<int>(row.fault) / 100 == chapter.hundred)
        page += fmt::format("| {} {} | {} | {} | {} | {} | {} | {} |\n", std::string_view(code(row.fault)), row.name,
                            row.text, row.remedy, kReactions[static_cast<std::size_t>(row.reaction)],
                            kClears[static_cast<std::size_t>(row.clear)], static_cast<int>(row.exit_code), row.threat);
  }
  return page;
}

/// Codes of the faults that stop a motion and wait for no reset.
std::string ends_a_block_alone() {
  std::string codes;
  for (const FaultInfo& f : catalogue())
    if (f.reaction != Reaction::Note && !latches(f))
      codes += fmt::format("{}{}", codes.empty() ? "" : ", ", std::string_view(code(f.fault)));
  return codes;
}

std::string states_page() {
  using cycle::Cause;
  using cycle::State;
  constexpr std::array kLights{"red", "yellow", "green"};
  std::string page =
      "# States of the machine\n\n"
      "Written by `scripts/docs` from the table of `app/cycle/machine_state.cpp`, which the 1 ms loop carries out.\n\n"
      "## Orders\n\n"
      "What an order of the owner's leads to in the loop. A dash: the loop refuses it there. What a person orders is "
      "composed of\nthese: `home`, `jog`, `park` and `run` enable first where drives have no torque, and a hold or a "
      "resume that comes before the\nfirst motion is kept for it; what a refusal says goes by what is under way "
      "([owner's socket](owner-socket.md)). An abort is\nnever refused; a reset changes no state by itself: when every "
      "cause has gone and the axes stand, a stopped machine becomes\nready, or disabled where drives have lost their "
      "torque.\n\nIn a state that commands no motion an axis may still settle, and one without torque run out. The "
      "light is that "
      "of the stack light;\nred while a fault is latched, and yellow in setup, whatever the state; yellow, too, while "
      "a job waits between two\n"
      "blocks for somebody to resume it.\n\n"
      "| state | motion is commanded | light |";
  const auto causes = [](bool orders) {
    std::vector<Cause> list;
    for (std::size_t c = 0; c < cycle::kCauses; ++c)
      if (cycle::is_order(static_cast<Cause>(c)) == orders) list.push_back(static_cast<Cause>(c));
    return list;
  };
  for (const Cause c : causes(true)) page += fmt::format(" {} |", cycle::name(c));
  page += " left by |\n|---|---|---|";
  for (std::size_t i = 0; i < causes(true).size(); ++i) page += "---|";
  page += "---|\n";
  for (std::size_t s = 0; s < cycle::kStates; ++s) {
    const auto state = static_cast<State>(s);
    page += fmt::format("| {} | {} | {} |", cycle::name(state), cycle::row(state).moves ? "yes" : "no",
                        kLights[static_cast<std::size_t>(cycle::row(state).lamp)]);
    for (const Cause c : causes(true)) {
      const auto to = cycle::next(state, c);
      page += fmt::format(" {} |", to ? cycle::name(*to) : "-");
    }
    page += fmt::format(" {} |\n", cycle::row(state).left_by);
  }
  page += "\n## What comes of itself, and faults\n\nA fault that does not latch (" + ends_a_block_alone() +
          ") stops the block that plays; "
          "without one it\nchanges no state.\n\n| cause |";
  for (std::size_t s = 0; s < cycle::kStates; ++s) page += fmt::format(" {} |", cycle::name(static_cast<State>(s)));
  page += "\n|---|";
  for (std::size_t s = 0; s < cycle::kStates; ++s) page += "---|";
  page += "\n";
  for (const Cause c : causes(false)) {
    page += fmt::format("| {} |", cycle::name(c));
    for (std::size_t s = 0; s < cycle::kStates; ++s) {
      const auto to = cycle::next(static_cast<State>(s), c);
      page += fmt::format(" {} |", to ? cycle::name(*to) : "");
    }
    page += "\n";
  }
  constexpr std::array kBraking{"no braking: torque goes at once", "all axes together, on the path",
                                "each axis with its own limits, off the path"};
  page +=
      "\n## Reactions\n\nThe valve closes with each of them, in the next frame. While drives are enabling or disabling "
      "each of them "
      "takes the torque.\n\n"
      "| reaction | how the axes come to rest | torque | the job |\n|---|---|---|---|\n";
  for (const Reaction r : {Reaction::PathStop, Reaction::AxisStop, Reaction::QuickStop, Reaction::Off}) {
    const cycle::ReactionRow& row = *cycle::row(r);
    std::string outlived_ones;
    for (const FaultInfo& f : catalogue())
      if (outlived(f) && f.reaction == r) outlived_ones += fmt::format(" {}", std::string_view(code(f.fault)));
    page += fmt::format(
        "| {} | {} | {} | {} |\n", kReactions[static_cast<std::size_t>(r)],
        kBraking[static_cast<std::size_t>(row.braking)],
        row.braking == cycle::Braking::None ? "off at once"
        : row.goal                          ? "off when they stand"
                                            : "stays",
        outlived_ones.empty() ? "ends" : "waits for reset and resume after" + outlived_ones + ", else ends");
  }
  return page;
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> row;
  if (!line.starts_with("|")) return row;
  std::size_t from = 1;
  for (auto to = line.find('|', from); to != std::string::npos; to = line.find('|', from)) {
    std::string text = line.substr(from, to - from);
    text.erase(0, text.find_first_not_of(' '));
    text.erase(text.find_last_not_of(' ') + 1);
    row.push_back(text);
    from = to + 1;
  }
  return row;
}

std::map<std::string, ThreatState> threat_states(const std::vector<SourceFile>& tree, const std::string& page) {
  std::map<std::string, ThreatState> states;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (const auto row = cells(line); is_threat_row(row)) states[row[0]] = {};
  const auto come = [&](const std::vector<std::string>& words, Handled otherwise) {
    bool program = false, tested = false;
    for (const SourceFile& file : tree) {
      if (!is_code(file) || is_catalogue(file)) continue;
      const bool found = std::any_of(words.begin(), words.end(), [&](const auto& w) { return mentions(file.text, w); });
      (within(file.path, "tests") ? tested : program) |= found;
    }
    return !program ? otherwise : tested ? Handled::Tested : Handled::InProgram;
  };
  for (auto& [number, state] : states) {
    state.handled = come({number}, Handled::NotYet);
    const auto of_row = [&, number = number](const FaultInfo& row) { return row.threat == number; };
    const bool alone = std::count_if(catalogue().begin(), catalogue().end(), of_row) == 1;
    for (const FaultInfo& row : catalogue()) {
      if (!of_row(row)) continue;
      // A test that names the row may mean any of its faults.
      std::vector<std::string> words{"Fault::" + std::string(row.name)};
      if (alone) words.push_back(number);
      const Handled how = come(words, Handled::Named);
      std::string& codes = state.faults[how];
      codes += (codes.empty() ? "" : ", ") + std::string(std::string_view(code(row.fault)));
      state.handled = std::max(state.handled, how);
    }
  }
  return states;
}

std::string cell(const ThreatState& state) {
  constexpr std::array kWords{"not yet", "named", "in the program", "tested"};
  const auto word = [&](Handled how) { return std::string(kWords[static_cast<std::size_t>(how)]); };
  if (state.faults.empty()) return word(state.handled);
  std::string all;
  for (auto it = state.faults.rbegin(); it != state.faults.rend(); ++it)
    all += (all.empty() ? "" : "; ") + word(it->first) + ": " + it->second;
  return all;
}

std::string with_states(const std::string& page, const std::map<std::string, ThreatState>& states) {
  std::string out;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (const auto row = cells(line); is_threat_row(row))
      line = fmt::format("| {} | {} | {} | {} | {} |", row[0], row[1], row[2], row[3], cell(states.at(row[0])));
    out += line + "\n";
  }
  return out;
}

}  // namespace gantry::architecture
