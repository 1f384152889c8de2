// Orders to an owner that runs elsewhere (`gantry up`).
//   if (ask_owner(context, {.verb = &verb, .state = state, ...})) return;      // a client of a running owner
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/cli/verbs.hpp"
#include "app/run/owner.hpp"
#include "core/error.hpp"

namespace gantry::desk {
class OrderClient;
}

namespace gantry::cli {

/// The state folder that --state, the environment or the machine's name tell; the machine file is read only where its
/// name is needed. Shows what is wrong and sets context.exit_code.
std::optional<std::string> state_of(Context& context, const std::string& option);

inline constexpr const char* kStateHelp =
    "Folder of the machine's state; default: $GANTRY_STATE, else $XDG_STATE_HOME/gantry/MACHINE, else "
    "~/.local/state/gantry/MACHINE";

/// What a verb asks of an owner that is up besides its order.
struct Asked {
  run::Order order;
  std::string state;                       ///< folder
  std::string state_option{};              ///< --state as the user wrote it; "": they did not
  const run::OwnerOptions* own = nullptr;  ///< the verb's own options of this kind; null: it has none
  std::vector<std::string> given{};        ///< which of them the user wrote: they must be the owner's
  bool changed_since = false;              ///< the owner's machine file is meant though it was changed since
  /// Waited for when the owner has said yes, before its answer is shown; null: nothing.
  std::function<Result<void>(const desk::OrderClient& owner, const std::string& socket)> afterwards{};
  std::string shown_folder{};  ///< of a job, as the user wrote it; empty: what the owner answers
};

/// Which of the options that an owner is told apart by were written.
std::vector<std::string> given_options(const CLI::App& verb);

/// Those of `names` that were written, as they would be written again: " --machine cell.yaml --bus ethercat:eth0".
std::string same_machine(const CLI::App& verb, const std::vector<std::string>& names);

/// Sends the order, shows progress and takes keys while it lasts, shows its answer; sets context.exit_code. False when
/// no owner is up, in the state folder or, where none was named, as the service, and nothing was shown. Ctrl-C ends
/// what this client has ordered, or the client alone (owner_elsewhere.hpp); an owner that says nothing for 5 s is told
/// as such. A jog is kept alive.
bool ask_owner(Context& context, const Asked& asked);

}  // namespace gantry::cli
