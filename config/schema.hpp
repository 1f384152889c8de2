// Formats told to others: JSON Schema for editors, tables of keys for the docs. Both are made of the tables of fields
// that read the files, so they cannot say anything else.
#pragma once
#include <string>

#include "config/fields.hpp"

namespace gantry::config {

/// JSON Schema (draft 7) of a file, indented, with a line end.
std::string json_schema(const std::string& title, const std::vector<FieldShape>& format);

/// A Markdown table: key, what stands there, range, what it is for. Keys within keys as `board.size`.
std::string key_table(const std::vector<FieldShape>& format);

}  // namespace gantry::config
