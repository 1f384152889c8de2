// A JSON file of the machine's state folder that keeps a row by name, one file for each kind of bus: what the virtual
// drives are says nothing of those of steel.
//   constexpr KeptFile kFile{.stem = "accepted", .rows = "stations", .unreadable = "...", .remedy = "..."};
//   kFile.path(state, "ethercat:enp3s0");   kFile.read(file, [&](const Json& rows) {...});   kFile.write(file, rows);
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace gantry::stations {

struct KeptFile {
  using Json = nlohmann::ordered_json;

  std::string_view stem;        ///< of the file's name
  std::string_view rows;        ///< key under which they stand
  std::string_view unreadable;  ///< what cannot be read, for the error
  std::string_view remedy;

  [[nodiscard]] std::string path(const std::string& state, const std::string& bus) const;
  /// `take` gets the rows, and may throw what nlohmann's at() and get() throw. A file that is not there has none, and
  /// `take` is not called. Fault::FileUnreadable, BadValue with the remedy.
  [[nodiscard]] Result<void> read(const std::string& file, const std::function<void(const Json&)>& take) const;
  /// Fault::FileUnwritable.
  [[nodiscard]] Result<void> write(const std::string& file, const Json& all) const;
};

}  // namespace gantry::stations
