// Parts that a job has begun and not finished, kept in the machine's state folder: a job that would dispense all of its
// recipe over one of them is refused.
//   BegunParts parts(BegunParts::folder(state, options, true));
//   auto part = parts.find(serial, Clamp::Holds);   parts.keep(part);   parts.forget(serial);
// A part is known by its serial. Without serials it is the one in the machine, until the clamp that held it has opened.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/owner.hpp"
#include "core/error.hpp"

namespace gantry::desk {

struct BegunPart {
  std::string serial;               ///< "": it has none
  std::string recipe, recipe_file;  ///< its name and its path
  std::string sha256;               ///< of the recipe with all the files that it is made of
  std::string began;                ///< UTC
  std::vector<std::size_t> left;    ///< not whole on it: indices in Recipe::features, in its order; none: finished
  std::string to_finish;            ///< the same as words of the command line
  bool lost = false;  ///< its job never told its end (a power cut): of what is left, some may be dispensed
  std::vector<record::Defect> defects{};  ///< of what lies on it; what is missing is in `left`
};

/// What lies on it.
record::Board board_of(const BegunPart& part);

/// What `part-removed` came to, for people: that it is forgotten, or that there was none of this serial.
/// `comes_back`: a part with a serial may be brought back.
std::string removal_in_words(const std::optional<BegunPart>& forgotten, const std::string& serial, bool comes_back);

/// What is known of the clamp as a job is asked for.
enum class Clamp {
  Unseen,  ///< the bus is still to come up, or no output of the program's moves it
  Open,
  Holds,
};

class BegunParts {
 public:
  /// Parts of steel and of each kind of simulation do not know of each other. Nothing where each owner makes a board
  /// of its own and `lives_long` is false: there none outlives its job.
  static std::optional<std::string> folder(const std::string& state, const run::OwnerOptions& options, bool lives_long);
  /// All that there are in a state folder.
  static std::vector<BegunParts> all(const std::string& state);

  /// In a world that is kept, a board outlives the program, and the clamp over it stays shut meanwhile.
  explicit BegunParts(std::string folder) : folder_(std::move(folder)), kept_(folder_.ends_with(kKeptWorld)) {}

  [[nodiscard]] bool outlives_programs() const { return kept_; }
  /// What lay in the machine was taken out: by order, or nobody of this program has held it.
  [[nodiscard]] bool is_taken_out() const { return taken_out_ || (kept_ && !clamped_); }
  /// By order.
  void take_out() { taken_out_ = true; }

  /// The begun part that a job of this serial would be done on: what the clamp holds; else that of the serial, else the
  /// one in the machine, which is another one only if both have serials, or if the clamp is open and has held it
  /// (clamped()). Then one without serial is forgotten, unless its job was lost. One in the machine whose job was lost
  /// is found for every serial. A finished part that the clamp still holds is found, too: nothing is left of it.
  /// Fault::BadValue, FileUnreadable.
  Result<std::optional<BegunPart>> find(const std::string& serial, Clamp clamp);
  /// It is in the machine. On the disk when this returns. Fault::FileUnwritable.
  Result<void> keep(const BegunPart& part);
  /// Whether the clamp holds it, as seen after a job. What was open already when the bus came up is no removal.
  void clamped(bool held) { clamped_ = held, taken_out_ = false; }
  Result<void> forget(const std::string& serial);
  /// It is finished and lies in the machine, because its job has not opened the clamp. The clamp opens with its bus, so
  /// that only the owner that holds it remembers that, but for a world that is kept.
  Result<void> keep_finished(BegunPart part);
  /// Of the part with this serial, "": of the one in the machine, as far as anything is known of it.
  [[nodiscard]] record::Board board(const std::string& serial) const;
  /// The part with this serial, which is forgotten; "": the one in the machine, which is out of it, and forgotten if it
  /// has no serial. Nothing where there is none.
  Result<std::optional<BegunPart>> forget_removed(const std::string& serial);
  /// The serial ("" has none) of the part in the machine, where that is another one than this serial's.
  [[nodiscard]] Result<std::optional<std::string>> another_inside(const std::string& serial) const;
  /// All of them: the world that they were in is gone.
  void forget_all();

 private:
  static constexpr std::string_view kKeptWorld = "sim-kept";
  /// A hand may have taken out what lay there.
  [[nodiscard]] bool lets_go(Clamp clamp) const { return clamp == Clamp::Open && (clamped_ || !kept_); }
  [[nodiscard]] bool holds(Clamp clamp) const { return kept_ ? !lets_go(clamp) : clamp == Clamp::Holds && clamped_; }
  [[nodiscard]] std::string finished_file() const { return folder_ + "/finished.json"; }
  [[nodiscard]] Result<std::optional<BegunPart>> finished() const;
  Result<void> forget_finished();
  [[nodiscard]] std::string file_of(const std::string& serial) const;
  [[nodiscard]] std::string in_machine_file() const { return folder_ + "/in-machine.json"; }
  [[nodiscard]] Result<std::optional<std::string>> in_machine() const;
  [[nodiscard]] Result<std::optional<BegunPart>> read(const std::string& serial) const;
  /// The part that a job of this serial would be done on, as far as it is known without the clamp.
  [[nodiscard]] Result<std::optional<BegunPart>> meant(const std::string& serial) const;
  /// The begun or finished part with another serial than this one, if it is in the machine.
  [[nodiscard]] Result<std::optional<BegunPart>> another(const std::string& serial) const;

  std::string folder_;
  bool kept_;
  bool clamped_ = false;
  bool taken_out_ = false;
  std::optional<BegunPart> finished_;  ///< and held, as far as this program has seen
};

}  // namespace gantry::desk
