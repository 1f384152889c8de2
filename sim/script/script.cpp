#include "sim/script/script.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "config/fields.hpp"
#include "core/near_word.hpp"

namespace gantry::sim {

namespace {

using config::At;
using config::Dimension;
using config::Field;
using config::Fields;
using config::kAny;
using config::kOptional;
using config::kRequired;
using config::Mistakes;
using config::Node;

/// An entry as it is written.
struct Entry {
  At<std::string> at, act, axis, station, name, input;
  double after_s = 0, hold_s = 0.2, diameter = 0, grey = 30;
  std::uint32_t code = 0, count = 0;
  bool on = false;
  std::uint32_t port = 0;
  double ppm = 0, value = 0, by_s = 0;
  config::ObjectAddress object;
  LineNoise noise;
  std::uint64_t seed = 1;
  double loss = 0, corrupt = 0, header = 0, duplicate = 0, delay = 0, reorder = 0;
  Vec3 at_mm, size;
  Vec2 by;
};

Time time_of(double seconds_) { return Time(static_cast<std::int64_t>(std::llround(seconds_ * 1e9))); }

struct ActionRow {
  std::string_view name;
  ActionKind kind;
  Fields<Entry> fields;
};

const std::vector<ActionRow>& actions() {
  using E = Entry;
  const auto axis = config::text("axis", &E::axis, kRequired, "axis of the machine file");
  const auto station = config::text("station", &E::station, kRequired, "station of the machine file");
  const auto name = config::text("name", &E::name, kRequired, "of the mark or obstacle");
  const auto input = config::text("input", &E::input, kRequired, "input of the machine file: start, door_closed ...");
  const auto count = config::integer("count", &E::count, {1, 1e6}, kRequired, "how many of the next frames");
  const auto side = config::integer("drive", &E::count, {0, 1}, kOptional, "which side of a gantry axis");
  const auto chance = [](const char* key, double E::*to, const char* what) {
    return config::number(key, to, Dimension::None, {0, 1}, kOptional, what);
  };
  static const std::vector<ActionRow> table{
      {"cut_link", ActionKind::CutLink, {station}},
      {"heal_link", ActionKind::HealLink, {station}},
      {"lose_frames", ActionKind::LoseFrames, {count}},
      {"corrupt_frames", ActionKind::CorruptFrames, {count}},
      {"corrupt_headers", ActionKind::CorruptHeaders, {count}},
      {"duplicate_frames", ActionKind::DuplicateFrames, {count}},
      {"reorder_frames", ActionKind::ReorderFrames, {count}},
      {"delay_frames",
       ActionKind::DelayFrames,
       {count, config::number("by", &E::by_s, Dimension::Time, {1e-9, 10}, kRequired, "how much later they come")}},
      {"noise",
       ActionKind::Noise,
       {chance("loss", &E::loss, "share of frames that are lost"), chance("corrupt", &E::corrupt, "that are hit"),
        chance("header", &E::header, "with a wrong header"), chance("duplicate", &E::duplicate, "that come twice"),
        chance("delay", &E::delay, "that come up to 2 ms late"), chance("reorder", &E::reorder, "out of order"),
        config::integer("seed", &E::seed, {0, 4e9}, kOptional, "of the chance")}},
      {"drift",
       ActionKind::Drift,
       {station, config::number("ppm", &E::ppm, Dimension::None, {-1000, 1000}, kRequired, "its clock gains")}},
      {"jitter",
       ActionKind::Jitter,
       {station, config::number("by", &E::by_s, Dimension::Time, {0, 1e-3}, kRequired, "at most, to either side")}},
      {"count_errors",
       ActionKind::CountErrors,
       {station, config::integer("port", &E::port, {0, 3}, kRequired, "0 towards the master"),
        config::integer("count", &E::count, {1, 255}, kRequired, "frames with a wrong FCS")}},
      {"stick_statusword", ActionKind::StickStatusword, {axis, side}},
      {"free_statusword", ActionKind::FreeStatusword, {axis, side}},
      {"ignore_writes",
       ActionKind::IgnoreWrites,
       {station, config::address("object", &E::object, kOptional, "one object alone")}},
      {"heed_writes", ActionKind::HeedWrites, {station}},
      {"set_object",
       ActionKind::SetObject,
       {station, config::address("object", &E::object, kRequired, "index:sub"),
        config::number("value", &E::value, Dimension::None, {-2147483648.0, 4294967295.0}, kRequired,
                       "what it reads")}},
      {"drive_fault",
       ActionKind::DriveFault,
       {axis, config::integer("code", &E::code, {1, 0xFFFF}, kRequired, "as it stands in 603Fh"),
        config::integer("drive", &E::count, {0, 1}, kOptional, "which side of a gantry axis")}},
      {"stall", ActionKind::Stall, {axis}},
      {"release", ActionKind::Release, {axis}},
      {"power_off", ActionKind::PowerOff, {station}},
      {"power_on", ActionKind::PowerOn, {station}},
      {"power_cycle",
       ActionKind::PowerCycle,
       {station, config::number("dark", &E::hold_s, Dimension::Time, {1e-3, 3600}, kOptional, "how long it is off")}},
      {"remove_mark", ActionKind::RemoveMark, {name}},
      {"move_mark",
       ActionKind::MoveMark,
       {name, config::point("by", &E::by, kAny, kRequired, "[1 mm, 0 mm] in the board's frame")}},
      {"stain",
       ActionKind::Stain,
       {config::text("name", &E::name, kOptional, "of a mark that `by` counts from; else from the board's origin"),
        config::point("by", &E::by, kAny, kRequired, "[1 mm, 0 mm] in the board's frame"),
        config::number("diameter", &E::diameter, Dimension::Length, {0.001, 1000}, kRequired, "of the blot"),
        config::number("grey", &E::grey, Dimension::None, {0, 255}, kOptional, "grey level")}},
      {"add_obstacle",
       ActionKind::AddObstacle,
       {name, config::point("centre", &E::at_mm, kAny, kRequired, "in the machine frame"),
        config::point("size", &E::size, {0.001, 10000}, kRequired, "edges of the box")}},
      {"remove_obstacle", ActionKind::RemoveObstacle, {name}},
      {"press",
       ActionKind::Press,
       {input, config::number("hold", &E::hold_s, Dimension::Time, {0.001, 3600}, kOptional, "how long")}},
      {"set_input", ActionKind::SetInput, {input, config::flag("on", &E::on, kRequired, "its new level")}},
      {"camera_dead", ActionKind::CameraDead, {}},
      {"camera_alive", ActionKind::CameraAlive, {}},
  };
  return table;
}

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

/// Names become ids; a name that the machine does not have is a mistake that names the nearest one it has.
class Resolver {
 public:
  Resolver(const config::Machine& machine, Mistakes& mistakes) : machine_(machine), mistakes_(mistakes) {}

  void resolve(const Entry& e, Action& a) {
    if (e.axis.given()) {
      std::vector<std::string_view> names;
      for (const config::Axis& axis : machine_.axes) {
        names.push_back(axis.name);
        if (axis.name == e.axis.value) a.axis = axis.id;
      }
      expect("axis", e.axis, names);
    }
    if (e.station.given()) {
      std::vector<std::string_view> names;
      for (const config::Station& station : machine_.stations) {
        names.push_back(station.name);
        if (station.name == e.station.value) a.station = station.id;
      }
      expect("station", e.station, names);
    }
    if (e.input.given()) {
      std::vector<std::string_view> names;
      for (std::size_t i = 0; i < config::kInputs; ++i) {
        names.push_back(config::name(static_cast<config::Input>(i)));
        if (names.back() == e.input.value) a.input = static_cast<config::Input>(i);
      }
      expect("input", e.input, names);
    }
  }

 private:
  void expect(std::string_view what, const At<std::string>& value, const std::vector<std::string_view>& names) {
    if (std::find(names.begin(), names.end(), value.value) != names.end()) return;
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("the machine has no {} '{}'; {}", what, value.value, did_you_mean(value.value, names)),
                  value.place);
  }
  const config::Machine& machine_;
  Mistakes& mistakes_;
};

const ActionRow* row_of(const Node& node, Mistakes& mistakes) {
  if (!config::expect_map(node, "an entry such as {at: cycle 100, do: lose_frames, count: 3}", mistakes))
    return nullptr;
  const Node* act = node.find("do");
  if (act == nullptr) {
    mistakes.add(Fault::MissingKey, "an entry needs 'do', for example do: remove_mark", node.place);
    return nullptr;
  }
  std::vector<std::string_view> names;
  for (const ActionRow& row : actions()) {
    if (act->text == row.name) return &row;
    names.push_back(row.name);
  }
  mistakes.add(Fault::BadValue,
               fmt::format("nothing is known that does '{}'; {}", act->text, did_you_mean(act->text, names)),
               act->place);
  return nullptr;
}

void read_entry(const Node& node, const config::Machine& machine, Mistakes& mistakes, std::vector<ScriptEntry>& to) {
  if (node.kind == Node::Kind::Refused) return;
  const ActionRow* row = row_of(node, mistakes);
  if (row == nullptr) return;
  Fields<Entry> fields = row->fields;
  fields.insert(fields.end(), common().begin(), common().end());
  Entry e;
  config::read_object(node, fields, e, node.place, mistakes);
  ScriptEntry entry;
  entry.where = fmt::format("{}:{}:{}", mistakes.file(), node.place.line, node.place.column);
  entry.text = fmt::format("{} at {}", row->name, e.at.given() ? e.at.value : "once");
  Action& a = entry.action;
  a.kind = row->kind;
  a.name = e.name.value;
  a.on = e.on;
  a.code = e.code;
  a.count = e.count;
  a.size = e.size;
  a.at = a.kind == ActionKind::AddObstacle ? e.at_mm : Vec3{e.by.x, e.by.y, 0};
  a.diameter = e.diameter;
  a.grey = e.grey;
  a.hold = time_of(e.by_s > 0 || a.kind == ActionKind::Jitter ? e.by_s : e.hold_s);
  if (a.kind == ActionKind::CountErrors) a.code = e.port;
  a.object = e.object;
  a.amount = a.kind == ActionKind::Drift ? e.ppm : e.value;
  a.noise.loss = e.loss, a.noise.corrupt = e.corrupt, a.noise.header = e.header;
  a.noise.duplicate = e.duplicate, a.noise.delay = e.delay, a.noise.reorder = e.reorder, a.noise.seed = e.seed;
  Resolver(machine, mistakes).resolve(e, a);
  if (e.at.given()) {
    if (const auto t = trigger_of(e.at.value))
      entry.trigger = *t;
    else
      mistakes.add(Fault::BadValue,
                   fmt::format("'{}' is no instant that the world knows; write {}", e.at.value, kTriggers), e.at.place);
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
