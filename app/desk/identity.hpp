// Which machine an owner owns, and how: what `status` says of it, and what a client may have asked for otherwise.
//   identity_of(machine_file, options)   ->   the owner's `status`   ->   Result<void> same(owner, wanted, {"--bus"})
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/owner.hpp"
#include "core/error.hpp"

namespace gantry::desk {

/// "machine", "machine_hash", "bus", "world", "board", "seed", "script", "sim_state", and those of DDS and of the
/// loop's CPU: each a text, paths absolute; the hash is the start of the file's SHA-256, "" when it cannot be read.
nlohmann::ordered_json identity_of(const std::string& machine_file, const run::OwnerOptions& options);

/// Compares what `given` names (options of the command line, "--bus"); a machine file is the same when its bytes are.
/// Fault::Usage naming option and both values.
Result<void> same(const nlohmann::ordered_json& owner, const nlohmann::ordered_json& wanted,
                  const std::vector<std::string>& given);

}  // namespace gantry::desk
