// Answers to orders, one JSON object a line: what every answer has, and errors in both directions.
//   door.reply(client, failure({error}).dump());          for (const Error& e : errors_of(answer)) ...
#pragma once
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace gantry::desk {

using Json = nlohmann::ordered_json;

/// No answer is longer than this, the newline counted.
inline constexpr std::size_t kLongestAnswer = 64 * 1024;

/// {"ok": false, "exit_code": of the first error, "errors": [...]}. `errors` is not empty.
Json failure(const std::vector<Error>& errors);

/// "code", "name", "message", "where", "remedy" of each, as many as fit into half an answer, the first ones first.
Json errors_to_json(const std::vector<Error>& errors);
/// The same read back. What has no code of ours becomes Fault::Internal.
std::vector<Error> errors_of(const Json& answer);

/// One line without its newline. Text that is no UTF-8 is repaired.
std::string to_line(const Json& answer);

}  // namespace gantry::desk
