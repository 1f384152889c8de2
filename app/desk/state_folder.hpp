// Where a machine's state lives: the owner's socket and lock, what was accepted of its stations, parts
// that were begun. One place for every
// verb, whatever folder one stands in.
//   auto path = state_folder(option, machine.name, environment);   open_state_folder(*path);   owner_socket(*path);
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <sys/stat.h>

#include "core/error.hpp"

namespace gantry::desk {

/// "" where a variable is not set.
using Environment = std::function<std::string(const char*)>;

/// Of this process.
std::string environment(const char* name);

/// `option` (--state), else $GANTRY_STATE, else $XDG_STATE_HOME/gantry/<machine name>, else
/// ~/.local/state/gantry/<machine name>; absolute. Fault::Usage when none of these can be told.
Result<std::string> state_folder(const std::string& option, const std::string& machine_name, const Environment& env);

/// Makes it, with what is missing above it, for this user alone (mode 0700). Fault::Refused when it is a link, belongs
/// to another user, or others may write to it; FileUnwritable.
Result<void> open_state_folder(const std::string& path);

/// What is there under this name is a folder, or nothing is. Fault::Refused.
Result<void> look_at_state_folder(const std::string& path);

/// Why a folder that is there may not hold a machine's state, and what to do.
struct UnfitFolder {
  std::string what, remedy;
};
/// By `found`, what lstat() or fstat() tells of it: a link, or of somebody else, or open to others.
std::optional<UnfitFolder> unfit_for_state(const std::string& path, const struct stat& found);

/// Where the owner takes its orders.
inline std::string owner_socket(const std::string& state) { return state + "/owner.sock"; }

/// Where a client that was told no state folder looks for an owner, when none is up in its own: that of the service.
inline constexpr const char* kSharedSocket = "/run/gantry/owner.sock";
/// $GANTRY_SOCKET, else that; "" where `option` (--state) or $GANTRY_STATE name the only folder that is meant.
std::string shared_socket(const std::string& option, const Environment& env);

}  // namespace gantry::desk
