// Pages that are made from tables in the code. scripts/docs writes them, tests compare them.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "tests/architecture/source_tree.hpp"

namespace gantry::architecture {

/// docs/faults.md, whole.
std::string faults_page();

/// docs/states.md, whole.
std::string states_page();

/// How far the sources have come with a threat, by rising degree.
enum class Handled { NotYet, Named, InProgram, Tested };

struct ThreatState {
  Handled handled = Handled::NotYet;      ///< the best of it
  std::map<Handled, std::string> faults;  ///< of the catalogue that name it, each as far as it has come: "G101, G102"
};

/// What a search of the tree shows for each row of the threats page, by its number "R01".
std::map<std::string, ThreatState> threat_states(const std::vector<SourceFile>& tree, const std::string& page);

/// The cell under "today": "tested: G101; named: G102".
std::string cell(const ThreatState& state);

/// The page with its last column written anew.
std::string with_states(const std::string& page, const std::map<std::string, ThreatState>& states);

/// Cells of a table row: "| R01 | a | b |" -> "R01", "a", "b"; empty for other lines.
std::vector<std::string> cells(const std::string& line);

}  // namespace gantry::architecture
