// What is wrong with a command line, in the house's words.
//   catch (const CLI::ParseError& error) { return show(usage_error(app, error), json); }
#pragma once
#include <CLI/CLI.hpp>

#include "core/error.hpp"

namespace gantry::cli {

/// Fault::Usage. A verb that does not exist is named, with the nearest one, or all there are where none is near.
Error usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace gantry::cli
