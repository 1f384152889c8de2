// The part that one job is done on: whether it may be begun, and what is remembered of it until it is finished.
//   PartOfJob part(parts, prepared, serial);
//   part.may_begin(clamp);   part.begin();   owner.run(..., {.before = part.before()});   part.end(result,
//   clamp_holds);
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/desk/begun_parts.hpp"
#include "app/desk/prepare.hpp"
#include "app/record/job_result.hpp"
#include "core/error.hpp"
#include "recipes/recipe.hpp"

namespace gantry::desk {

/// What is to be dispensed, `--finish` filled in from what is remembered of the part that this job would be done on.
/// Fault::Refused: none was begun, nobody knows what it lacks, it lacks nothing, or it is another one.
Result<recipes::Selection> filled_in(recipes::Selection selection, BegunParts* parts, const std::string& serial,
                                     Clamp clamp);

class PartOfJob {
 public:
  /// `parts` null: none is remembered, and every part may be begun. All outlive it.
  PartOfJob(BegunParts* parts, const Prepared& prepared, std::string serial);

  /// Fault::Refused where the part was begun and not finished, unless --finish, --from or --only says what it lacks and
  /// the recipe is the one that it was begun with; always where the clamp holds a part with another serial.
  Result<void> may_begin(Clamp clamp);
  /// From here on it counts as begun, whatever happens to this program.
  Result<void> begin();
  /// As it was asked for; else as it was begun with. A part that was begun without one is of that serial from here on.
  [[nodiscard]] const std::string& serial() const { return serial_.empty() && found_ ? found_->serial : serial_; }
  /// Whatever an earlier job left in a simulated machine was taken out.
  [[nodiscard]] bool comes_new() const;
  /// What lies on it already.
  [[nodiscard]] record::OnBoard before() const;
  /// What it is asked to dispense though it lies there, by id.
  [[nodiscard]] std::vector<std::string> once_more() const;
  /// After the job, also after one that was refused: what is left is remembered, or the part is finished; then it is
  /// remembered as long as the clamp holds it.
  void end(record::JobResult& result, bool clamp_holds);

 private:
  [[nodiscard]] Error refusal() const;
  /// The part of this job, as jobs before it have left it.
  [[nodiscard]] BegunPart part(std::vector<std::size_t> left, bool lost) const;
  /// What was not whole on it before.
  [[nodiscard]] std::vector<std::size_t> left_before() const;
  [[nodiscard]] Result<void> keep(BegunPart part, record::JobResult* result);

  BegunParts* parts_;
  const recipes::Recipe& recipe_;
  bool all_;  ///< the whole recipe is asked for, without a word about what lies there
  std::string serial_, sha256_;
  std::string began_;  ///< UTC; of the first job on it
  std::vector<std::size_t> chosen_;
  std::optional<BegunPart> found_;
  bool begun_ = false;
};

}  // namespace gantry::desk
