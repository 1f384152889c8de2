// Orders to an owner that runs elsewhere (`gantry up`).
#pragma once
#include <optional>
#include <string>

#include "app/cli/verbs.hpp"
#include "app/run/order.hpp"

namespace gantry::cli {

/// Where the owner of a machine takes its orders: STATE/owner.sock.
std::string owner_socket(const std::string& state_dir);

/// Sends the order to the owner behind `state_dir` and shows its answer; sets context.exit_code. False when no owner is
/// up. Ctrl-C sends abort and waits for the answer.
bool ask_owner(Context& context, const std::string& state_dir, const run::Order& order);

}  // namespace gantry::cli
