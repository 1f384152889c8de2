// What is wrong with a command line, in the house's words.
//   catch (const CLI::ParseError& error) { return show(usage_error(app, error), json); }
#pragma once
#include <CLI/CLI.hpp>

#include "core/error.hpp"

namespace gantry::cli {

/// Fault::Usage. A verb that does not exist is named, with the nearest one, or all there are where none is near; so is
/// an option.
Error usage_error(const CLI::App& app, const CLI::ParseError& error);

/// "--machine" ...: the long names of a verb's own options.
std::vector<std::string> long_options(const CLI::App& verb);

/// For CLI::Option::check(): what is wrong with a number, in one line; "" where nothing is.
std::string zero_or_more(const std::string& word);
std::string above_zero(const std::string& word);

}  // namespace gantry::cli
