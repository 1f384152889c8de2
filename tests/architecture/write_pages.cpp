// write_pages: writes docs/faults.md, docs/states.md and the last column of docs/threats.md. scripts/docs calls it.
#include <fstream>

#include "tests/architecture/pages.hpp"

int main() {
  namespace house = gantry::architecture;
  const std::filesystem::path docs = std::filesystem::path(GANTRY_SOURCE_DIR) / "docs";
  std::ofstream(docs / "faults.md") << house::faults_page();
  std::ofstream(docs / "states.md") << house::states_page();
  const std::string page = house::read(docs / "threats.md");
  std::ofstream(docs / "threats.md") << house::with_states(page, house::threat_states(house::source_tree(), page));
}
