// The note in the machine's state folder that a station may hold values which act at its next power-up. It is kept
// before the first of them is written, so that a program that ends in between leaves no station that acts by its old
// values, and nobody who knows. It goes again only where the station has said of every one that it has not taken it:
// one that does not answer may have stored the value.
//   RestartNote note(station, keep);
//   auto ok = note.under([&] { return survey.write_held(position, row, bytes); });   // of each row
//   auto done = note.settle();                                                       // after the last one
#pragma once
#include <functional>

#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::devices {

class RestartNote {
 public:
  /// `keep` writes what is known of all stations into the state folder.
  RestartNote(config::Station& station, std::function<Result<void>()> keep)
      : station_(station), keep_(std::move(keep)) {}

  /// Errors of `keep`, which leave nothing written, and of `write`; one that leaves open what the station has says so.
  Result<void> under(const std::function<Result<void>()>& write);
  /// Takes the note back where every write under it was refused.
  Result<void> settle();
  /// A value was written, or may have been.
  [[nodiscard]] bool needed() const { return needed_; }

 private:
  config::Station& station_;
  std::function<Result<void>()> keep_;
  bool ours_ = false, needed_ = false;
};

}  // namespace gantry::devices
