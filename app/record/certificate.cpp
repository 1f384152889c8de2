#include "app/record/certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>

#include "app/job/surroundings.hpp"
#include "app/record/json_number.hpp"
#include "app/record/motion_file.hpp"
#include "app/record/program.hpp"
#include "app/record/summary.hpp"
#include "app/record/write_file.hpp"
#include "config/yaml.hpp"
#include "core/clean_text.hpp"
#include "core/shell_words.hpp"
#include "core/units.hpp"

namespace gantry::record {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;
constexpr std::size_t kHashDigits = 64;
constexpr config::YamlBudget kBudget{1u << 20, 60000, 16};

/// Within what of its nominal placement the board may lie for what was proved.
Json range(double shift_mm, double rotation_rad, double upwards_mm) {
  return {{"shift_mm", number(shift_mm)},
          {"rotation_deg", number(units::deg(rotation_rad))},
          {"upwards_mm", number(upwards_mm)}};
}

/// As many names as a file of bounded size holds.
Json names_of(const std::vector<job::OnlyWhenPlaced>& features) {
  constexpr std::size_t kMostNamed = 100;
  Json names = Json::array();
  for (std::size_t i = 0; i < std::min(features.size(), kMostNamed); ++i) names.push_back(features[i].feature);
  return {{"count", features.size()}, {"first", names}};
}

Json scope(const JobResult& r, const ProvedJob& proved) {
  const job::Belief before = job::unmeasured(proved.recipe);
  const Json anywhere = range(before.shift_mm, before.rotation_rad, before.upwards_mm);
  const Json from = proved.selection.from.empty() ? Json(nullptr) : Json(proved.selection.from);
  Json nominal{{"motions_certified", proved.proof.motions},
               {"minimum_clearance", to_json(proved.proof.nearest)},
               {"to_marks", nullptr},
               {"to_touches", nullptr},
               {"features", anywhere},
               {"only_when_placed", names_of(proved.proof.only_when_placed)}};
  if (!proved.recipe.marks.empty()) nominal["to_marks"] = anywhere;
  if (!proved.recipe.touches.empty()) nominal["to_touches"] = range(0, 0, before.upwards_mm);
  return {{"selection", {{"from", from}, {"only", proved.selection.only}}},
          {"nominal", nominal},
          {"placed",
           {{"dx_mm", number(r.offset.shift.x)},
            {"dy_mm", number(r.offset.shift.y)},
            {"rot_deg", number(units::deg(r.offset.rotation))},
            {"z0_mm", number(r.surface.z0)},
            {"slope", Json::array({number(r.surface.slope.x), number(r.surface.slope.y)})}}}};
}

/// Whose opinion was asked besides the proof, at how many poses. There was no other, or the job was not done.
Json second_opinion(const JobResult& r, const ProvedJob& proved) {
  if (r.opinion_poses == 0) return nullptr;
  return {{"by", "FCL"},
          {"step_mm", motion::kOpinionStep_mm},
          {"poses", r.opinion_poses},
          {"nominal_poses", proved.proof.poses}};
}

/// Where the motions stand one by one. Not where the disk was full.
Json motions(const JobResult& r) {
  if (!r.motions_listed) return nullptr;
  return {{"file", kMotionFile}, {"count", r.motions_listed->count}, {"sha256", r.motions_listed->sha256}};
}

/// Takes what is demanded from a certificate, and passes over the rest.
class Reader {
 public:
  explicit Reader(const std::string& path) : mistakes_(path) { out_.file = path; }

  Checked<Certificate> read(std::string_view text) {
    const auto root = config::read_yaml(text, mistakes_, kBudget);
    if (root) take(*root);
    if (!mistakes_.none()) return tl::unexpected(mistakes_.errors());
    return std::move(out_);
  }

 private:
  using Node = config::Node;

  void take(const Node& root) {
    if (root.kind != Node::Kind::Map || root.find("format") == nullptr)
      return mistakes_.add(Fault::BadValue, "this is no certificate; give the certificate.json of a dry run",
                           root.location);
    const Node* format = wanted(root, "format", Is::Number);
    if (format == nullptr) return;
    if (format->text != std::to_string(kFormat))
      return mistakes_.add(
          Fault::BadValue,
          fmt::format("this program reads certificates of format {}; do the dry run again with it", kFormat),
          format->location);
    if (const Node* result = wanted(root, "result", Is::Text); result && result->text != "done")
      mistakes_.add(Fault::BadValue, "the dry run of a certificate was done; do it again", result->location);
    if (const Node* hashes = wanted(root, "hashes", Is::Members))
      for (const job::ProofInput& input : job::kProofInputs) take(*hashes, input);
    if (const Node* scope = wanted(root, "scope", Is::Members))
      if (const Node* selection = wanted(*scope, "selection", Is::Members)) take_selection(*selection);
  }

  /// A value's type in JSON, where texts and only texts are quoted.
  enum class Is : std::uint8_t { Number, Text, List, Members };

  static bool is(const Node& node, Is type) {
    switch (type) {
      case Is::Number: return node.kind == Node::Kind::Scalar && !node.quoted;
      case Is::Text: return node.kind == Node::Kind::Scalar && node.quoted;
      case Is::List: return node.kind == Node::Kind::Sequence;
      case Is::Members: return node.kind == Node::Kind::Map;
    }
    return false;
  }

  void is_not(const Node& node, const char* key, Is type) {
    constexpr std::array<const char*, 4> kWords{"a number", "a text in quotes", "a list", "an object"};
    if (node.kind != Node::Kind::Refused)  // which has its mistake
      mistakes_.add(
          Fault::BadValue,
          fmt::format("'{}' has to be {}; do the dry run again", key, kWords.at(static_cast<std::size_t>(type))),
          node.location);
  }

  const Node* wanted(const Node& map, const char* key, Is type) {
    const Node* found = map.find(key);
    if (found == nullptr)
      mistakes_.add(Fault::MissingKey, fmt::format("the key '{}' is missing; do the dry run again", key), map.location);
    else if (is(*found, type))
      return found;
    else
      is_not(*found, key, type);
    return nullptr;
  }

  void take(const Node& hashes, const job::ProofInput& input) {
    const Node* found = wanted(hashes, input.name, Is::Text);
    if (found == nullptr) return;
    const bool hex =
        found->text.size() == kHashDigits && found->text.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!hex)
      return mistakes_.add(Fault::BadValue,
                           fmt::format("'{}' is a hash of 64 hex digits; do the dry run again", input.name),
                           found->location);
    out_.inputs.*input.hash = found->text;
  }

  void take_selection(const Node& selection) {
    if (const Node* from = selection.find("from"); from != nullptr && from->kind != Node::Kind::Empty)
      is(*from, Is::Text) ? void(out_.selection.from = from->text) : is_not(*from, "from", Is::Text);
    const Node* only = wanted(selection, "only", Is::List);
    if (only == nullptr) return;
    for (const Node& name : only->items)
      is(name, Is::Text) ? out_.selection.only.push_back(name.text) : is_not(name, "only: a name", Is::Text);
  }

  config::Mistakes mistakes_;
  Certificate out_;
};

std::string dry_run_again(const recipes::Recipe& recipe) {
  return fmt::format("take back what has changed, or do `gantry dry-run {}` again and give its certificate",
                     shell_word(recipe.file));
}

}  // namespace

Json certificate_json(const JobResult& r, const ProvedJob& proved) {
  const job::ProofInputs inputs = job::proof_inputs(proved.machine, proved.recipe);
  Json hashes;
  for (const job::ProofInput& input : job::kProofInputs) hashes[input.name] = inputs.*input.hash;
  const auto& others = r.minimum_clearance.others;
  return {{"format", kFormat},
          {"job", r.job},
          {"result", result_word(r)},
          {"recipe", r.recipe_name},
          {"recipe_file", r.recipe_file},
          {"machine", r.machine_name},
          {"machine_file", proved.machine.file},
          {"program", {{"version", program_version()}, {"commit", program_commit()}}},
          {"made", r.started},
          {"hashes", hashes},
          {"motions_certified", r.motions_certified},
          {"motions", motions(r)},
          {"minimum_clearance_mm", others ? number(others->distance_mm) : Json(nullptr)},
          {"minimum_clearance", to_json(r.minimum_clearance)},
          {"second_opinion", second_opinion(r, proved)},
          {"scope", scope(r, proved)}};
}

Result<void> write_certificate(const std::string& folder, const JobResult& result, const ProvedJob& proved) {
  if (!result.dry_run || result.exit_code != ExitCode::Done) return {};
  return write_file(
      folder + "/" + kCertificateFile,
      escape_steering(certificate_json(result, proved).dump(2, ' ', false, Json::error_handler_t::replace)) + "\n");
}

Checked<Certificate> read_certificate(const std::string& path) {
  const auto text = config::read_text_file(path, kBudget.bytes);
  if (!text) return tl::unexpected(std::vector{text.error()});
  return Reader(path).read(*text);
}

Result<void> demand(const Certificate& certificate, const config::Machine& machine, const recipes::Recipe& recipe,
                    const std::vector<std::size_t>& chosen) {
  const job::ProofInputs now = job::proof_inputs(machine, recipe);
  std::vector<std::string> differ;
  for (const job::ProofInput& input : job::kProofInputs) {
    constexpr std::size_t kShown = 12;
    const std::string &then_hash = certificate.inputs.*input.hash, &now_hash = now.*input.hash;
    if (then_hash != now_hash)
      differ.push_back(fmt::format("{} (certified {}, loaded {})", input.name, then_hash.substr(0, kShown),
                                   now_hash.substr(0, kShown)));
  }
  if (!differ.empty())
    return fail(Fault::Refused,
                fmt::format("the certificate is about something else than this run loads: {} {}; {}",
                            fmt::join(differ, ", "), differ.size() == 1 ? "differs" : "differ", dry_run_again(recipe)),
                certificate.file);
  const auto certified = recipes::choose(recipe, certificate.selection);
  if (!certified) return fail(Fault::Refused, certified.error().message, certificate.file);
  for (const std::size_t f : chosen)
    if (!std::binary_search(certified->begin(), certified->end(), f))
      return fail(Fault::Refused,
                  fmt::format("the certificate is of a dry run with {}, without '{}'; do the dry run without that",
                              recipes::to_text(certificate.selection), id_of(recipe.features[f])),
                  certificate.file);
  return {};
}

}  // namespace gantry::record
