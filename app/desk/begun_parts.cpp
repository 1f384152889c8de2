#include "app/desk/begun_parts.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <span>

#include "app/record/defects.hpp"
#include "app/record/summary.hpp"
#include "config/yaml.hpp"
#include "core/log.hpp"
#include "core/new_file.hpp"
#include "core/sha256.hpp"
#include "core/shell_words.hpp"

namespace gantry::desk {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kFormat = 1;
constexpr std::size_t kMostDefects = 1000;  // that are kept by name
constexpr std::size_t kLargestFile = 8u << 20;
constexpr std::size_t kLongestText = 4096;
constexpr std::string_view kFolders = "begun-";

/// Runs of indices as [first, how many]: an array's dots are thousands.
Json runs_of(const std::vector<std::size_t>& indices) {
  Json runs = Json::array();
  for (std::size_t i = 0; i < indices.size();) {
    std::size_t end = i + 1;
    while (end < indices.size() && indices[end] == indices[end - 1] + 1) ++end;
    runs.push_back({indices[i], end - i});
    i = end;
  }
  return runs;
}

std::size_t whole(const Json& number) {
  if (!number.is_number_unsigned()) throw std::runtime_error("a number that is not whole, or below 0");
  return number.get<std::size_t>();
}

std::string text_in(const Json& all, const char* key) {
  auto text = all.at(key).get<std::string>();
  if (text.size() > kLongestText) throw std::runtime_error(fmt::format("'{}' is too long", key));
  return text;
}

std::vector<std::size_t> indices_of(const Json& runs) {
  constexpr std::size_t kMost = 100000;  // features of a recipe
  std::vector<std::size_t> indices;
  for (const Json& run : runs) {
    const std::size_t first = whole(run.at(0)), count = whole(run.at(1));
    if (run.size() != 2 || count == 0) throw std::runtime_error("a run of features that is none");
    if (first >= kMost || count > kMost - first) throw std::runtime_error("more features than a recipe holds");
    if (!indices.empty() && first <= indices.back()) throw std::runtime_error("features out of order");
    for (std::size_t i = 0; i < count; ++i) indices.push_back(first + i);
  }
  return indices;
}

std::vector<record::Defect> defects_of(const Json& rows) {
  std::vector<record::Defect> defects;
  if (rows.is_boolean()) {  // as it was kept before they had names
    if (rows.get<bool>()) defects.push_back({"", record::Defect::Kind::Extra, "not all that lies there is good"});
    return defects;
  }
  for (const Json& row : rows) {
    const auto kind = record::kind_named(text_in(row, "kind"));
    if (!kind) throw std::runtime_error("a kind of defect that is none");
    defects.push_back({text_in(row, "feature"), *kind, text_in(row, "message")});
  }
  return defects;
}

BegunPart part_of(const Json& all) {
  return {.serial = text_in(all, "serial"),
          .recipe = text_in(all, "recipe"),
          .recipe_file = text_in(all, "recipe_file"),
          .sha256 = text_in(all, "sha256"),
          .began = text_in(all, "began"),
          .left = indices_of(all.at("left")),
          .to_finish = text_in(all, "to_finish"),
          .lost = all.at("lost").get<bool>(),
          .defects = defects_of(all.at("defects"))};
}

Json json_of(const BegunPart& part) {
  return {{"format", kFormat},
          {"serial", part.serial},
          {"recipe", part.recipe},
          {"recipe_file", part.recipe_file},
          {"sha256", part.sha256},
          {"began", part.began},
          {"to_finish", part.to_finish},
          {"lost", part.lost},
          {"defects", record::to_json(std::span(part.defects).first(std::min(part.defects.size(), kMostDefects)))},
          {"left", runs_of(part.left)}};
}

/// Without the library's own words.
std::string why(const std::exception& error) {
  return dynamic_cast<const Json::exception*>(&error) != nullptr
             ? "it is not JSON, or not what this program has written there"
             : error.what();
}

/// What `take` makes of the document; nothing where there is no file.
template <class Take>
Result<std::optional<std::invoke_result_t<Take, const Json&>>> document(const std::string& file, Take&& take) {
  std::error_code ignored;
  if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) return std::nullopt;
  constexpr const char* kWayOut =
      "what is known of a part that was begun cannot be read ({}); look at the board, and remove what stands there; "
      "`gantry part-removed` then says that the part is out";
  const auto text = config::read_text_file(file, kLargestFile);
  if (!text) return fail(text.error().fault, fmt::format(kWayOut, text.error().message), file);
  try {
    const Json all = Json::parse(*text);
    if (whole(all.at("format")) != kFormat) throw std::runtime_error("another format");
    return take(all);
  } catch (const std::exception& error) {
    return fail(Fault::BadValue, fmt::format(kWayOut, config::shortened(why(error), 200)), file);
  }
}

std::string text_of(const Json& all) { return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Result<void> removed(const std::string& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error) return fail(Fault::FileUnwritable, fmt::format("cannot be removed: {}", error.message()), file);
  return {};
}

}  // namespace

record::Board board_of(const BegunPart& part) {
  return !part.left.empty()      ? record::Board::Begun
         : !part.defects.empty() ? record::Board::Defects
                                 : record::Board::Whole;
}

std::string removal_in_words(const std::optional<BegunPart>& forgotten, const std::string& serial, bool comes_back) {
  const auto quoted = [](const std::string& text) { return "'" + config::shortened(text, 100) + "'"; };
  if (!forgotten)
    return serial.empty() ? "no part was begun and not finished"
                          : fmt::format("no part with serial {} was begun and not finished", quoted(serial));
  const std::string which =
      fmt::format("the part {}that recipe '{}' began at {} and {}",
                  forgotten->serial.empty() ? "" : quoted(forgotten->serial) + " ", forgotten->recipe, forgotten->began,
                  !forgotten->left.empty()     ? "did not finish"
                  : forgotten->defects.empty() ? "finished"
                                               : "finished with defects");
  if (serial == forgotten->serial || forgotten->left.empty() || !comes_back)
    return which + " is not waited for any more";
  return fmt::format(
      "{} is out of the machine, and still known by its serial: a run with --serial {} and {} finishes it, `gantry "
      "part-removed --serial {}` forgets it",
      which, shell_word(forgotten->serial), forgotten->to_finish, shell_word(forgotten->serial));
}

std::optional<std::string> BegunParts::folder(const std::string& state, const run::OwnerOptions& options,
                                              bool lives_long) {
  const bool simulated = options.bus == "sim", kept = !options.sim.state_dir.empty();
  if (simulated && !kept && !lives_long) return std::nullopt;
  const std::string kind = simulated && kept ? std::string(kKeptWorld) : options.bus.substr(0, options.bus.find(':'));
  return fmt::format("{}/{}{}", state, kFolders, kind);
}

std::vector<BegunParts> BegunParts::all(const std::string& state) {
  std::vector<BegunParts> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(state, error))
    if (std::error_code ignored; entry.path().filename().string().starts_with(kFolders) && entry.is_directory(ignored))
      found.emplace_back(entry.path().string());
  return found;
}

std::string BegunParts::file_of(const std::string& serial) const {
  return serial.empty() ? folder_ + "/part.json" : fmt::format("{}/part-{}.json", folder_, sha256_hex(serial));
}

Result<std::optional<std::string>> BegunParts::in_machine() const {
  return document(in_machine_file(), [](const Json& all) { return text_in(all, "serial"); });
}

Result<std::optional<BegunPart>> BegunParts::read(const std::string& serial) const {
  return document(file_of(serial), [&](const Json& all) {
    BegunPart part = part_of(all);
    if (part.left.empty()) throw std::runtime_error("nothing is left of it");
    part.serial = serial;
    return part;
  });
}

/// One that another program has finished counts in a world that is kept.
Result<std::optional<BegunPart>> BegunParts::finished() const {
  if (finished_ || !kept_) return finished_;
  return document(finished_file(), [](const Json& all) {
    BegunPart part = part_of(all);
    if (!part.left.empty()) throw std::runtime_error("something is left of it");
    return part;
  });
}

Result<void> BegunParts::forget_finished() {
  finished_.reset();
  return kept_ ? removed(finished_file()) : Result<void>{};
}

record::Board BegunParts::board(const std::string& serial) const {
  const auto part = meant(serial);
  if (!part) return record::Board::Begun;  // something is, and nobody can read what
  return *part ? board_of(**part) : record::Board::Untouched;
}

Result<std::optional<BegunPart>> BegunParts::meant(const std::string& serial) const {
  if (auto done = finished();
      !done || (*done && (serial.empty() || (**done).serial.empty() || (**done).serial == serial)))
    return done;
  if (!serial.empty())
    if (auto own = read(serial); !own || *own) return own;
  const auto inside = in_machine();
  if (!inside) return tl::unexpected(inside.error());
  return !*inside || (!serial.empty() && !(**inside).empty()) ? std::nullopt : read(**inside);
}

Result<std::optional<BegunPart>> BegunParts::another(const std::string& serial) const {
  if (serial.empty()) return std::nullopt;
  const auto done = finished();
  if (!done) return tl::unexpected(done.error());
  if (*done) return (**done).serial.empty() || (**done).serial == serial ? std::nullopt : *done;
  const auto inside = another_inside(serial);
  if (!inside) return tl::unexpected(inside.error());
  return !*inside || (**inside).empty() ? std::nullopt : read(**inside);
}

Result<std::optional<BegunPart>> BegunParts::find(const std::string& serial, Clamp clamp) {
  if (lets_go(clamp))
    if (auto gone = forget_finished(); !gone) return tl::unexpected(gone.error());
  // Whatever the serial says, the job would be done on what the clamp holds; and who has lost a job has seen no hand
  // that took its part out.
  if (auto inside = another(serial); !inside || (*inside && (holds(clamp) || (**inside).lost))) return inside;
  if (!serial.empty())
    if (auto own = read(serial); !own || *own) return own;
  if (auto done = finished();
      !done || (*done && (serial.empty() || (**done).serial.empty() || serial == (**done).serial)))
    return done;
  const auto inside = in_machine();
  if (!inside) return tl::unexpected(inside.error());
  const bool not_this_one = *inside && !serial.empty() && !(**inside).empty();
  if (!*inside || not_this_one) return std::nullopt;
  auto part = read(**inside);
  if (!part || !*part) return part;
  // A power cut opens clamps, too: that is no hand which takes the part out.
  if (clamp != Clamp::Open || !clamped_ || (**part).lost) return part;
  if ((**part).serial.empty()) {
    log::warn(
        "the part that was begun at {} by recipe '{}' was not finished; the clamp has opened since, so that this "
        "one is taken for another",
        (**part).began, (**part).recipe);
    if (auto done = forget(""); !done) return tl::unexpected(done.error());
  }
  if (auto done = removed(in_machine_file()); !done) return tl::unexpected(done.error());
  return std::nullopt;
}

Result<void> BegunParts::keep(const BegunPart& part) {
  if (auto gone = forget_finished(); !gone) return gone;
  if (auto made = make_folder(folder_); !made) return made;  // in the state folder, which is this user's alone
  if (auto done = write_durable_file(file_of(part.serial), text_of(json_of(part))); !done) return done;
  return write_durable_file(in_machine_file(), text_of({{"format", kFormat}, {"serial", part.serial}}));
}

Result<void> BegunParts::forget(const std::string& serial) { return removed(file_of(serial)); }

Result<void> BegunParts::keep_finished(BegunPart part) {
  finished_ = std::move(part);
  if (!kept_) return {};
  if (auto made = make_folder(folder_); !made) return made;
  return write_durable_file(finished_file(), text_of(json_of(*finished_)));
}

Result<std::optional<BegunPart>> BegunParts::forget_removed(const std::string& serial) {
  const auto last = finished();
  if (!last) return last;
  const auto inside = in_machine();
  if (!inside) return tl::unexpected(inside.error());
  const std::string which = serial.empty() && *inside ? **inside : serial;
  auto part = read(which);  // what cannot be read stays as it is, whole
  if (!part) return part;
  if (*last && (serial.empty() || (**last).serial == serial)) {
    if (auto gone = forget_finished(); !gone) return tl::unexpected(gone.error());
    if (!*part) part = last;
  }
  // Whoever says no serial takes it out, and may bring it back; a simulated board that is taken out is gone.
  if (*part && (serial == which || kept_))
    if (auto done = forget(which); !done) return tl::unexpected(done.error());
  if (serial.empty())
    if (auto done = removed(in_machine_file()); !done) return tl::unexpected(done.error());
  return part;
}

Result<std::optional<std::string>> BegunParts::another_inside(const std::string& serial) const {
  if (const auto done = finished(); !done)
    return tl::unexpected(done.error());
  else if (*done && !serial.empty() && !(**done).serial.empty() && (**done).serial != serial)
    return (**done).serial;
  const auto inside = in_machine();
  if (!inside) return tl::unexpected(inside.error());
  if (!*inside || serial.empty() || **inside == serial) return std::nullopt;
  const auto begun = read(**inside);
  if (!begun) return tl::unexpected(begun.error());
  return *begun ? *inside : std::nullopt;
}

void BegunParts::forget_all() {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (name == "in-machine.json" || name == "finished.json" || (name.starts_with("part") && name.ends_with(".json")))
      if (auto done = removed(entry.path().string()); !done) log::report(done.error());
  }
}

}  // namespace gantry::desk
