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

/// For CLI::Option::check(): what is wrong with a word, in one line; "" where nothing is.
std::string zero_or_more(const std::string& word);
std::string above_zero(const std::string& word);
std::string whole_from_zero(const std::string& word);  ///< 0 .. 2^64 - 1
/// 0, which holds, or 1 to 200.
std::string override_percent(const std::string& word);
/// What is there is a folder; what is not may become one.
std::string folder_to_be(const std::string& path);
/// Its folder is there, so that it can be made.
std::string file_to_be(const std::string& path);

/// Whichever verb it belongs to, an option or a word that is given and empty is a mistake, and so is a value of an
/// option that takes none (`--json=5`). After all verbs are added.
void refuse_slips(CLI::App& app);

}  // namespace gantry::cli
