// What a function off the RT side returns when it can fail: a numbered fault of the catalogue, a text that names the
// thing and the remedy, and the place.
//   return fail(Fault::UnknownKey, "unknown key 'sped'; did you mean 'speed'?", "recipes/board.yaml:14:7");
#pragma once
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "core/fault.hpp"

namespace gantry {

struct Meeting;

struct Error {
  Fault fault = Fault::Internal;
  std::string message;  ///< one sentence: what is wrong, and what to do
  std::string where;    ///< "file:line:col", "station 3 'y1'", "axis Z"; empty where there is no place
  std::shared_ptr<const Meeting>
      meeting{};  ///< of a collision that was foreseen (core/meeting.hpp); null: nothing to show
};

template <class T>
using Result = tl::expected<T, Error>;

/// All mistakes of a file at once (`check` shows every one).
template <class T>
using Checked = tl::expected<T, std::vector<Error>>;

[[nodiscard]] inline tl::unexpected<Error> fail(Fault fault, std::string message, std::string where = {}) {
  return tl::unexpected<Error>(Error{fault, std::move(message), std::move(where)});
}

/// "recipes/board.yaml:14:7: unknown key ... [G402]", the one form in which errors are shown to people.
std::string to_text(const Error& error);

}  // namespace gantry
