#include "sim/script/script.hpp"

#include <charconv>
#include <fmt/format.h>

#include "core/near_word.hpp"
#include "sim/script/actions.hpp"

namespace gantry::sim {

namespace {

using config::Dimension;
using config::Fields;
using config::kOptional;
using config::kRequired;
using config::Mistakes;
using config::Node;

/// What every entry may have.
const Fields<Entry>& common() {
  static const Fields<Entry> table{
      config::text("at", &Entry::at, kOptional, "now, job start, cycle N, feature dot N, mark NAME, touch N ..."),
      config::text("do", &Entry::act, kRequired, "what happens"),
      config::number("after", &Entry::after_s, Dimension::Time, {0, 86400}, kOptional, "and then this much later")};
  return table;
}

constexpr std::string_view kTriggers =
    "now, job start, cycle N, feature dot N, feature bead N, feature ID, mark NAME or touch N";

bool number_after(std::string_view text, std::string_view word, std::uint64_t& n) {
  if (!text.starts_with(word) || text.size() == word.size()) return false;
  text.remove_prefix(word.size());
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), n);
  return problem == std::errc{} && end == text.data() + text.size();
}

std::optional<Trigger> trigger_of(std::string_view text) {
  using Kind = Trigger::Kind;
  Trigger t;
  if (text == "now") return t;
  if (text == "job start") return t.kind = Kind::JobStart, t;
  if (number_after(text, "cycle ", t.count)) return t.kind = Kind::Cycle, t;
  if (number_after(text, "feature dot ", t.count) && t.count > 0) return t.kind = Kind::NthDot, t;
  if (number_after(text, "feature bead ", t.count) && t.count > 0) return t.kind = Kind::NthBead, t;
  if (number_after(text, "touch ", t.count) && t.count > 0) return t.kind = Kind::NthTouch, t;
  t.count = 0;
  for (const auto& [word, kind] : {std::pair{std::string_view("mark "), Kind::MarkExposed},
                                   std::pair{std::string_view("feature "), Kind::FeatureId}})
    if (text.starts_with(word) && text.size() > word.size()) {
      t.kind = kind;
      t.name = text.substr(word.size());
      return t;
    }
  return std::nullopt;
}

const ActionRow* row_of(const Node& node, Mistakes& mistakes) {
  if (!config::expect_map(node, "an entry such as {at: cycle 100, do: lose_frames, count: 3}", mistakes))
    return nullptr;
  const Node* act = node.find("do");
  if (act == nullptr) {
    mistakes.add(Fault::MissingKey, "an entry needs 'do', for example do: remove_mark", node.location);
    return nullptr;
  }
  std::vector<std::string_view> names;
  for (const ActionRow& row : actions()) {
    if (act->text == row.name) return &row;
    names.push_back(row.name);
  }
  mistakes.add(Fault::BadValue,
               fmt::format("nothing is known that does '{}'; {}", act->text, did_you_mean(act->text, names)),
               act->location);
  return nullptr;
}

void read_entry(const Node& node, const config::Machine& machine, Mistakes& mistakes, std::vector<ScriptEntry>& to) {
  if (node.kind == Node::Kind::Refused) return;
  const ActionRow* row = row_of(node, mistakes);
  if (row == nullptr) return;
  Fields<Entry> keys = row->keys;
  keys.insert(keys.end(), common().begin(), common().end());
  Entry e;
  config::read_object(node, keys, e, node.location, mistakes);
  ScriptEntry entry;
  entry.where = fmt::format("{}:{}:{}", mistakes.file(), node.location.line, node.location.column);
  entry.text = fmt::format("{} at {}", row->name, e.at.given() ? e.at.value : "once");
  Names names(machine, mistakes);
  entry.action = row->make(e, names);
  if (e.at.given()) {
    if (const auto t = trigger_of(e.at.value))
      entry.trigger = *t;
    else
      mistakes.add(Fault::BadValue,
                   fmt::format("'{}' is no instant that the world knows; write {}", e.at.value, kTriggers),
                   e.at.location);
  }
  entry.trigger.after = time_of(e.after_s);
  to.push_back(std::move(entry));
}

}  // namespace

Checked<std::vector<ScriptEntry>> parse_script(std::string_view yaml, std::string_view file,
                                               const config::Machine& machine) {
  Mistakes mistakes{std::string(file)};
  const auto root = config::read_yaml(yaml, mistakes);
  std::vector<ScriptEntry> out;
  if (root && root->kind == Node::Kind::Map)
    read_entry(*root, machine, mistakes, out);
  else if (root && root->kind != Node::Kind::Empty && config::expect_list(*root, {0, 100000}, mistakes))
    for (const Node& item : root->items) read_entry(item, machine, mistakes, out);
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());
  return out;
}

Checked<std::vector<ScriptEntry>> load_script(const std::string& path, const config::Machine& machine) {
  const auto text = config::read_text_file(path);
  if (!text) return tl::unexpected(std::vector<Error>{text.error()});
  return parse_script(*text, path, machine);
}

Error joined(const std::vector<Error>& errors) {
  Error out = errors.front();
  for (std::size_t i = 1; i < errors.size(); ++i) out.message += "\n" + to_text(errors[i]);
  return out;
}

}  // namespace gantry::sim
