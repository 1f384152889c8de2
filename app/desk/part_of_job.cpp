#include "app/desk/part_of_job.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <numeric>
#include <set>
#include <string_view>

#include "app/record/defects.hpp"
#include "app/record/outcome.hpp"
#include "config/yaml.hpp"
#include "core/log.hpp"
#include "core/sha256.hpp"
#include "core/shell_words.hpp"
#include "core/utc_stamp.hpp"
#include "recipes/selection.hpp"

namespace gantry::desk {
namespace {

std::string sha256_of(const recipes::Recipe& recipe) {
  std::string all;
  for (const recipes::Source& s : recipe.sources) all += s.sha256 + "\n";
  return sha256_hex(all);
}

std::vector<std::size_t> all_of(const recipes::Recipe& recipe) {
  std::vector<std::size_t> all(recipe.features.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

constexpr const char* kFinish = "--finish";
constexpr std::size_t kLongestWords = 300;  // of a command that a person would type again; beyond it: --finish

constexpr const char* kNamed = "--from FEATURE or --only FEATURES";

std::string quoted(const std::string& serial) { return "'" + config::shortened(serial, 100) + "'"; }

/// Of a part whose job was lost: of all that this job was to do, or of what the jobs behind it have left.
std::string nobody_saw(const BegunPart& part) {
  if (part.to_finish == kNamed)
    return fmt::format("nobody saw how far it came; look at the board and dispense what is missing with {}", kNamed);
  return fmt::format(
      "a job on it was lost, and nobody saw what of `{}` lies there; look at the board and dispense of it what is "
      "missing",
      part.to_finish);
}

/// The order that forgets it. `serial` is that of the job which meets it.
std::string take_out(const BegunPart& part, const std::string& serial) {
  return part.serial.empty() || serial.empty() ? "`gantry part-removed`"
                                               : "`gantry part-removed --serial " + shell_word(serial) + "`";
}

std::string named(const BegunPart& part) {
  return part.serial.empty() ? "the part in the machine" : "the part with serial " + quoted(part.serial);
}

bool is_of_another(const BegunPart& part, const std::string& serial) {
  return !serial.empty() && !part.serial.empty() && part.serial != serial;
}

/// Of a job with another serial than the part that is in the machine, or may be.
std::string refusal_over(const BegunPart& held, const std::string& serial) {
  const std::string which = fmt::format("{}, which recipe '{}' began at {}{}", named(held), held.recipe, held.began,
                                        held.left.empty() || held.lost ? "" : " and did not finish");
  if (held.lost)
    return fmt::format(
        "{}, may still be in the machine, and this job is for {}: nobody saw how far it came; say `gantry "
        "part-removed` "
        "when it is taken out, or look at it and dispense what is missing with {} and --serial {}",
        which, quoted(serial), kNamed, shell_word(held.serial));
  return fmt::format(
      "the clamp still holds {}, and this job is for {}; say `gantry part-removed` to open the clamp, and put the "
      "other "
      "part in{}",
      which, quoted(serial),
      held.left.empty()
          ? ""
          : fmt::format(", or finish the one inside with {} --serial {}", held.to_finish, shell_word(held.serial)));
}

std::string has_all(const BegunPart& part, const std::string& serial) {
  return fmt::format(
      "{}, begun at {}, has all its features, and the clamp still holds it, because its job did not end 'done'; say {} "
      "to open the clamp, or dispense something of '{}' once more with --only",
      named(part), part.began, take_out(part, serial), part.recipe);
}

}  // namespace

Result<recipes::Selection> filled_in(recipes::Selection selection, BegunParts* parts, const std::string& serial,
                                     Clamp clamp) {
  if (!selection.finish) return selection;
  const auto refused = [](const std::string& why) { return fail(Fault::Refused, why, kFinish); };
  if (parts == nullptr)
    return refused("no part is remembered here, as each run makes a new simulated board; leave '--finish' out");
  const auto found = parts->find(serial, clamp);
  if (!found) return tl::unexpected(found.error());
  if (!*found)
    return refused(fmt::format("no part{} was begun and not finished; leave '--finish' out",
                               serial.empty() ? "" : " with serial " + quoted(serial)));
  const BegunPart& part = **found;
  if (is_of_another(part, serial)) return refused(refusal_over(part, serial));
  if (part.left.empty()) return refused(has_all(part, serial));
  if (part.lost)
    return refused(fmt::format("of {}, begun at {}, {}, or say {} when it is taken out", named(part), part.began,
                               nobody_saw(part), take_out(part, serial)));
  selection.lacking = part.left;
  return selection;
}

PartOfJob::PartOfJob(BegunParts* parts, const Prepared& prepared, std::string serial)
    : parts_(parts),
      recipe_(prepared.recipe),
      all_(prepared.selection.all()),
      serial_(std::move(serial)),
      sha256_(sha256_of(prepared.recipe)),
      chosen_(recipes::dispensed_by(prepared.job)) {
  std::sort(chosen_.begin(), chosen_.end());
}

Result<void> PartOfJob::may_begin(Clamp clamp) {
  if (parts_ == nullptr) return {};
  auto found = parts_->find(serial_, clamp);
  if (!found) return tl::unexpected(found.error());
  if (*found && is_of_another(**found, serial_))
    return fail(Fault::Refused, refusal_over(**found, serial_), recipe_.file);
  found_ = std::move(*found);
  if (!found_) return {};
  const bool same =
      found_->sha256 == sha256_ && (found_->left.empty() || found_->left.back() < recipe_.features.size());
  if (!same || all_) return tl::unexpected(refusal());
  for (const std::string& id : once_more()) log::warn("'{}' lies on this board already and is dispensed once more", id);
  return {};
}

std::vector<std::string> PartOfJob::once_more() const {
  std::vector<std::string> out;
  if (!found_) return out;
  for (const std::size_t f : chosen_)
    if (!std::binary_search(found_->left.begin(), found_->left.end(), f)) out.push_back(id_of(recipe_.features[f]));
  return out;
}

Error PartOfJob::refusal() const {
  if (found_->left.empty()) return {Fault::Refused, has_all(*found_, serial_), recipe_.file};
  if (found_->sha256 != sha256_)
    return {
        Fault::Refused,
        fmt::format("{} was begun at {} with {} ('{}', {}) and not finished, and other features do not finish it; "
                    "run that one with {}, or say {} when it is taken out",
                    named(*found_), found_->began,
                    found_->recipe == recipe_.name ? "this recipe as it was before it was changed" : "another recipe",
                    found_->recipe, found_->recipe_file, found_->to_finish, take_out(*found_, serial_)),
        recipe_.file};
  const std::string how_far =
      found_->lost ? nobody_saw(*found_)
                   : fmt::format("{} of its {} features {} not whole; finish it with {}", found_->left.size(),
                                 recipe_.features.size(), found_->left.size() == 1 ? "is" : "are", found_->to_finish);
  return {Fault::Refused,
          fmt::format("{} was begun at {} and not finished: {}, or say {} when it is taken out", named(*found_),
                      found_->began, how_far, take_out(*found_, serial_)),
          recipe_.file};
}

BegunPart PartOfJob::part(std::vector<std::size_t> left, bool lost) const {
  return {.serial = serial(),
          .recipe = recipe_.name,
          .recipe_file = recipe_.file,
          .sha256 = sha256_,
          .began = began_,
          .left = std::move(left),
          .to_finish = "",
          .lost = lost,
          .defects = found_ ? found_->defects : std::vector<record::Defect>{}};
}

std::vector<std::size_t> PartOfJob::left_before() const { return found_ ? found_->left : all_of(recipe_); }

Result<void> PartOfJob::keep(BegunPart part, record::JobResult* result) {
  // Of one whose job was lost nobody knows what is missing: no command finishes it that a program could give. Behind
  // another job on it that is what this one has left.
  part.to_finish =
      part.lost && result == nullptr ? kNamed : recipes::to_text(recipes::selection_of(recipe_, part.left));
  if (part.to_finish.size() > kLongestWords) part.to_finish = part.lost ? kNamed : kFinish;
  if (result != nullptr) (part.lost ? result->unseen : result->to_finish) = part.to_finish;
  if (auto kept = parts_->keep(part); !kept) return kept;
  return found_ && found_->serial != part.serial ? parts_->forget(found_->serial) : Result<void>{};
}

Result<void> PartOfJob::begin() {
  if (parts_ == nullptr) return {};
  begun_ = true;
  began_ = found_ ? found_->began : utc_stamp();
  const std::vector<std::size_t> before = left_before();
  std::vector<std::size_t> open;
  std::set_union(before.begin(), before.end(), chosen_.begin(), chosen_.end(), std::back_inserter(open));
  return keep(part(std::move(open), true), nullptr);
}

bool PartOfJob::comes_new() const { return parts_ != nullptr && !found_ && parts_->is_taken_out(); }

record::OnBoard PartOfJob::before() const {
  if (!found_) return {};
  record::OnBoard before{std::vector<bool>(recipe_.features.size(), true), found_->defects};
  for (const std::size_t f : found_->left) before.whole[f] = false;
  return before;
}

void PartOfJob::end(record::JobResult& result, bool clamp_holds) {
  if (parts_ == nullptr) return;
  const bool nothing_new = result.board == record::Board::Untouched;
  if (nothing_new && found_) result.board = board_of(*found_);
  if (!begun_) {
    if (nothing_new && !found_) result.board = parts_->board(serial_);
    if (found_ && !found_->lost && found_->sha256 == sha256_) result.to_finish = found_->to_finish;
    return;
  }
  BegunPart now = part({}, found_ && found_->lost);
  const std::vector<std::size_t> before = left_before();
  if (nothing_new) {
    if (found_) now.left = before;
  } else {
    std::set<std::string_view> lacking;
    now.defects.clear();  // this job's have those of the jobs before among them
    for (const record::Defect& d : result.defects)
      if (record::is_lacking(d))
        lacking.insert(d.feature);
      else
        now.defects.push_back(d);
    std::vector<std::size_t> again;  // of this job's
    std::copy_if(chosen_.begin(), chosen_.end(), std::back_inserter(again),
                 [&](std::size_t f) { return lacking.count(id_of(recipe_.features[f])) != 0; });
    std::vector<std::size_t> untried;
    std::set_difference(before.begin(), before.end(), chosen_.begin(), chosen_.end(), std::back_inserter(untried));
    std::set_union(untried.begin(), untried.end(), again.begin(), again.end(), std::back_inserter(now.left));
  }
  const bool finished = now.left.empty();
  const bool lies_there = finished && clamp_holds && !(nothing_new && !found_);
  const auto done = finished ? parts_->forget(now.serial) : keep(now, &result);
  if (!done) record::add_error(result, done.error());
  if (!lies_there) return;
  if (auto kept = parts_->keep_finished(std::move(now)); !kept) record::add_error(result, kept.error());
}

}  // namespace gantry::desk
