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

/// When a machine file counts as the owner's: where something is to move by it, when its bytes are the same; else also
/// when it lies where the owner read it and was changed since.
enum class MachineFile { SameBytes, SamePath };

/// Compares what `given` names (options of the command line, "--bus"). Fault::Usage naming option and both values.
Result<void> same(const nlohmann::ordered_json& owner, const nlohmann::ordered_json& wanted,
                  const std::vector<std::string>& given, MachineFile machine_file = MachineFile::SameBytes);

}  // namespace gantry::desk
