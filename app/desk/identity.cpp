#include "app/desk/identity.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>

#include "core/absolute_path.hpp"
#include "core/sha256.hpp"
#include "sim/world/board.hpp"

namespace gantry::desk {
namespace {

using Json = nlohmann::ordered_json;

struct Row {
  std::string_view option;
  const char* key;       ///< what is compared
  const char* shown_as;  ///< what is named when it differs
};
constexpr std::array kRows{Row{"--machine", "machine_hash", "machine"},
                           Row{"--bus", "bus", "bus"},
                           Row{"--world", "world", "world"},
                           Row{"--sim-board", "board_meant", "board"},
                           Row{"--sim-seed", "seed", "seed"},
                           Row{"--sim-script", "script", "script"},
                           Row{"--sim-state", "sim_state", "sim_state"},
                           Row{"--domain", "domain", "domain"},
                           Row{"--interface", "interface", "interface"},
                           Row{"--peer", "peers", "peers"},
                           Row{"--name", "name", "name"},
                           Row{"--loop-cpu", "loop_cpu", "loop_cpu"}};

std::string absolute(const std::string& path) {
  return std::filesystem::path(absolute_path(path).value_or(path)).lexically_normal().string();
}

/// However it is spelt.
std::string board_meant(const std::string& words) {
  const auto read = sim::parse_placement(words);
  return read && !words.empty() ? sim::to_text(*read) : words;
}

std::string text(const Json& of, const char* key) {
  const auto found = of.find(key);
  return found != of.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

Json identity_of(const std::string& machine_file, const run::OwnerOptions& options) {
  return {{"machine", absolute(machine_file)},
          {"machine_hash", sha256_of_file(machine_file).substr(0, 16)},
          {"bus", options.bus},
          {"world", absolute(options.world_socket)},
          {"board", options.sim.placement},
          {"board_meant", board_meant(options.sim.placement)},
          {"seed", std::to_string(options.sim.seed)},
          {"script", absolute(options.sim.script_file)},
          {"sim_state", absolute(options.sim.state_dir)},
          {"domain", std::to_string(options.network.domain)},
          {"interface", options.network.interface},
          {"peers", fmt::format("{}", fmt::join(options.network.peers, ", "))},
          {"name", options.name},
          {"loop_cpu", options.loop_cpu ? std::to_string(*options.loop_cpu) : "the last one"}};
}

Result<void> same(const Json& owner, const Json& wanted, const std::vector<std::string>& given,
                  MachineFile machine_file) {
  for (const Row& row : kRows) {
    if (std::find(given.begin(), given.end(), row.option) == given.end()) continue;
    if (text(owner, row.key) == text(wanted, row.key)) continue;
    const std::string theirs = text(owner, row.shown_as), ours = text(wanted, row.shown_as);
    if (theirs == ours && machine_file == MachineFile::SamePath) continue;
    if (theirs == ours)  // a machine file that has changed since
      return fail(Fault::Usage,
                  fmt::format("'{}' is not what it was when the owner read it; end the owner (`gantry down`) and start "
                              "it again",
                              ours),
                  std::string(row.option));
    return fail(Fault::Usage,
                fmt::format("the owner that is up has '{}', and '{}' was asked for; leave the option out, or start an "
                            "owner with it",
                            theirs, ours),
                std::string(row.option));
  }
  return {};
}

}  // namespace gantry::desk
