// Every key of a recipe, of a machine file and of a drive's profile, written wrong in each way that its kind of value
// knows: misspelt, without its unit, in another dimension, beyond its range, a word for a number, a list for a value,
// nothing at all. Each brings one message, where it stands, that says what to write. The formats themselves say what
// there is to try.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <unistd.h>
#include <utility>

#include "config/formats.hpp"
#include "config/machine.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::wrong {
namespace {

namespace fs = std::filesystem;
using config::FieldShape;
using config::Location;
using config::Node;
using config::ValueShape;
using Kind = ValueShape::Kind;

/// A place in the text where something else is written, and where that is told.
struct Slip {
  std::string what;  ///< "board.size: without a unit"
  std::size_t at = 0, bytes = 0;
  std::string instead;
  std::string told_at;  ///< "3:9"
};

std::string shown(Location location) { return fmt::format("{}:{}", location.line, location.column); }

/// Goes through a text and its format side by side.
class Slips {
 public:
  /// Of those keys that no text before had.
  std::vector<Slip> of(const std::string& text, const std::vector<FieldShape>& format) {
    config::Mistakes none("");
    text_ = text, root_ = *config::read_yaml(text_, none);
    fields(root_, format, "");
    return std::exchange(slips_, {});
  }
  /// Keys of the format of which none stands in the text.
  [[nodiscard]] std::set<std::string> untried() const {
    std::set<std::string> rest;
    std::set_difference(known_.begin(), known_.end(), tried_.begin(), tried_.end(), std::inserter(rest, rest.end()));
    return rest;
  }

 private:
  [[nodiscard]] std::size_t offset(Location location) const {
    std::size_t at = 0;
    for (int line = 1; line < location.line; ++line) at = text_.find('\n', at) + 1;
    return at + static_cast<std::size_t>(location.column) - 1;  // these files are ASCII up to what is changed
  }
  void add(const std::string& path, const std::string& how, Location location, std::size_t bytes,
           const std::string& instead, Location told) {
    slips_.push_back({path + ": " + how, offset(location), bytes, instead, shown(told)});
  }

  void fields(const Node& map, const std::vector<FieldShape>& format, const std::string& path) {
    for (const FieldShape& field : format) known(field, path);
    for (std::size_t i = 0; i < map.keys.size(); ++i) {
      const auto& key = map.keys[i];
      const auto field =
          std::find_if(format.begin(), format.end(), [&](const FieldShape& f) { return f.key == key.text; });
      if (field == format.end()) {
        ADD_FAILURE() << path << key.text << " is not in the format";
        continue;
      }
      const std::string here = path + key.text;
      const bool first = tried_.insert(here).second;
      if (first) add(here, "misspelt", key.location, key.text.size(), key.text + "q", key.location);
      value(map.items[i], field->shape, here, first, key.location);
    }
  }
  void known(const FieldShape& field, const std::string& path) {
    known_.insert(path + field.key);
    inside(field.shape, path + field.key);
  }
  void inside(const ValueShape& shape, const std::string& path) {
    if (shape.kind == Kind::Object || shape.kind == Kind::OneOf)
      for (const FieldShape& each : shape.fields) known(each, path + ".");
    if (shape.kind == Kind::List || shape.kind == Kind::Named) inside(shape.items[0], path + "[]");
  }

  void value(const Node& node, const ValueShape& shape, const std::string& path, bool first, Location key) {
    switch (shape.kind) {
      case Kind::Object: return fields(node, shape.fields, path + ".");
      case Kind::OneOf: return one_of(node, shape, path);
      case Kind::List:
      case Kind::Named:
        for (const Node& item : node.items)
          value(item, shape.items[0], path + "[]", first && &item == &node.items[0], {});
        return;
      case Kind::Tuple:
        if (first && !node.items.empty()) scalar(node.items[0], shape.items[0], path + "[0]", {});
        return;
      case Kind::Setting:
      case Kind::Names: return;
      default:
        if (first && node.kind == Node::Kind::Scalar) scalar(node, shape, path, key);
    }
  }
  void one_of(const Node& node, const ValueShape& shape, const std::string& path) {
    const auto kind = std::find_if(shape.fields.begin(), shape.fields.end(),
                                   [&](const FieldShape& f) { return f.key == node.keys[0].text; });
    tried_.insert(path + "." + kind->key);
    fields(node.items[0], kind->shape.fields, path + "." + kind->key + ".");
  }

  static constexpr double kExact = 1e15;  ///< whole numbers up to here differ by one as doubles, too

  /// `key`: of the value; line 0: it is one of a list.
  void scalar(const Node& node, const ValueShape& shape, const std::string& path, Location key) {
    const auto slip = [&](const std::string& how, const std::string& instead) {
      add(path, how, node.location, node.text.size() + (node.quoted ? 2 : 0), instead, node.location);
    };
    slip("keys for a value", "{a: 1}");
    if (key.line > 0) {
      add(path, "nothing", node.location, node.text.size() + (node.quoted ? 2 : 0), "", key);
      slip("a list for a value", "[1, 2]");
    }
    switch (shape.kind) {
      case Kind::Number: {
        const auto d = shape.dimensions.front();
        slip("a word for a number", "much");
        if (d == config::Dimension::None) return slip("a unit too many", "1 mm");
        slip("without a unit", "1");
        slip("a decimal comma", "\"1,5 " + std::string(units::name(d)) + "\"");
        slip("in another dimension", d == config::Dimension::Time ? "1 mm" : "1 s");
        if (std::isfinite(shape.range.max)) slip("too large", config::as_written(shape.range.max * 2 + 1, d));
        if (std::isfinite(shape.range.min)) slip("too small", config::as_written(shape.range.min - 1, d));
        return;
      }
      case Kind::Integer:
        slip("a word for a whole number", "many");
        slip("a fraction", "1.5");
        if (shape.range.max < kExact) slip("too large", fmt::format("{:.0f}", shape.range.max + 1));
        if (shape.range.min > -kExact) slip("too small", fmt::format("{:.0f}", shape.range.min - 1));
        return;
      case Kind::Flag: return slip("a word for a flag", "yes");
      case Kind::Choice: return slip("none of the choices", "other");
      case Kind::Name: slip("a name with a blank", "two words"); return slip("a number for a name", "12");
      case Kind::Address: return slip("an address without 0x", "6040");
      default: return;
    }
  }

  std::string text_;
  Node root_;
  std::vector<Slip> slips_;
  std::set<std::string> tried_, known_;
};

/// That the message tells what to write.
bool says_what_to_write(const std::string& message) {
  constexpr const char* kRemedies[] = {
      "write",        "expected",       "did you mean",     "known:",     "is outside", "is less than",
      "is more than", "choose another", "put it in quotes", "is missing", "leave out",  "a letter, then",
      "begin",        "belong"};
  return std::any_of(std::begin(kRemedies), std::end(kRemedies),
                     [&](const char* each) { return message.find(each) != std::string::npos; });
}

/// One mistake after the other in texts that together have every key of the format.
template <class Judge>
void expect_one_message_each(const std::vector<std::string>& texts, const std::vector<FieldShape>& format,
                             std::size_t every, Judge&& mistakes_of) {
  Slips slips;
  std::size_t tried = 0;
  for (const std::string& text : texts) {
    ASSERT_TRUE(mistakes_of(text).empty()) << to_text(mistakes_of(text).front());
    const std::vector<Slip> all = slips.of(text, format);
    for (std::size_t i = 0; i < all.size(); i += every, ++tried) {
      const Slip& slip = all[i];
      std::string changed = text;
      changed.replace(slip.at, slip.bytes, slip.instead);
      const std::vector<Error> errors = mistakes_of(changed);
      std::string said;
      for (const Error& e : errors) said += "\n  " + to_text(e);
      if (errors.size() != 1) {
        ADD_FAILURE() << slip.what << ": " << errors.size() << " messages" << said;
        continue;
      }
      EXPECT_TRUE(errors[0].where.ends_with(":" + slip.told_at)) << slip.what << ", at " << slip.told_at << said;
      EXPECT_TRUE(says_what_to_write(errors[0].message)) << slip.what << said;
      EXPECT_EQ(info(errors[0].fault).exit_code, ExitCode::InvalidFile) << slip.what << said;
    }
  }
  std::string untried;
  for (const std::string& key : slips.untried()) untried += " " + key;
  EXPECT_EQ(untried, "") << "keys that stand in none of the files";
  std::printf("%zu mistakes\n", tried);
}

TEST(EveryKey, of_a_recipe_written_wrong_brings_one_message) {
  const std::string text = *config::read_text_file(GANTRY_SOURCE_DIR "/tests/wrong/full-recipe.yaml");
  const recipes::ReadText wave = [](const std::string&) -> Result<std::string> { return "x_mm,y_mm\n10,10\n20,20\n"; };
  expect_one_message_each({text}, recipes::recipe_format(), 1, [&](const std::string& changed) {
    const auto r = recipes::parse(changed, "r.yaml", wave);
    return r ? std::vector<Error>{} : r.error();
  });
}

TEST(EveryKey, of_a_machine_file_written_wrong_brings_one_message) {
  const fs::path folder = fs::path(testing::TempDir()) / ("gantry_every_key_" + std::to_string(::getpid()));
  fs::create_directories(folder / "machines");
  for (const char* kind : {"drives", "devices"})
    fs::create_directory_symlink(fs::absolute(fs::path("config") / kind), folder / kind);
  const std::string file = (folder / "machines" / "m.yaml").string();
  std::string text = *config::read_text_file("config/machines/dispenser.yaml");
  const auto also = [&](const std::string& behind, const std::string& more) {
    const auto at = text.find(behind);
    ASSERT_NE(at, std::string::npos) << behind;
    text.insert(at + behind.size(), more);
  };
  also("    drives: [{station: z", ", invert: false");
  also("    response_delay: 3 ms\n", "    path_error: 0.1 mm\n");
  also("position: 1 mm", ", timeout: 60 s, limits_unseen: false");
  also("rack_max: 12 mm", ", square_max: 1 mm");
  also("  frames_lost_max: 3\n", "  map: separate\n");
  also("centre: [10 mm, 0 mm, 90 mm]", ", rotation: 0 deg, on_turn: false");
  also("  start:        {station: io, bit: 0", ", invert: false");
  also("probe: {axis: Z, ", "fast: 10 mm/s, back_off: 1 mm, ");
  also("\nscene:\n",
       "  ball: {capsule: {diameter: 2 mm, height: 4 mm}, rotation: 0 deg, centre: [400 mm, 300 mm, -100 mm]}\n");
  also("position: 2, alias: 2",
       ", declared: [run_current], emergency_stop_elsewhere: false, inputs: {negative_limit: 0, "
       "positive_limit: 1, home: 2}");
  also("  reset:        {station: io, ", "terminal: DI9} # ");
  also("U: {lag: 1 ms, ", "delay: 0 ms, home_active: below, ");
  also("  camera_noise: 2\n",
       "  tip_errors: {needle: [0 mm, 0 mm, 0 mm], camera: [0 mm, 0 mm, 0 mm], probe: [0 mm, 0 mm, 0 mm]}\n");
  also("machine: dispenser\n",
       "keep_out:\n"
       "  door: {box: [40 mm, 20 mm, 50 mm], centre: [500 mm, 400 mm, -50 mm], rotation: 5 deg}\n"
       "  hose: {cylinder: {diameter: 20 mm, height: 30 mm}, centre: [500 mm, 300 mm, -50 mm]}\n"
       "  lamp: {capsule: {diameter: 20 mm, height: 30 mm}, centre: [500 mm, 200 mm, -50 mm]}\n"
       "brake: {axis: Z, output: holds, time: 100 ms, release: 80 ms}\nhold_within: 2 s\noverride_max: 100 %\n");
  also("  healthy:        {station: io, bit: 7", ", invert: false}\n  holds: {station: io, terminal: DO8");
  expect_one_message_each({text}, config::machine_format(), 7, [&](const std::string& changed) {
    std::ofstream(file) << changed;
    const auto m = config::load_machine(file);
    return m ? std::vector<Error>{} : m.error();
  });
  fs::remove_all(folder);
}

TEST(EveryKey, of_a_profile_written_wrong_brings_one_message) {
  const std::string file =
      (fs::path(testing::TempDir()) / ("gantry_every_key_" + std::to_string(::getpid()) + ".yaml")).string();
  std::vector<std::string> texts;
  for (const char* folder : {"config/drives", "config/devices"})
    for (const std::string& name : config::yaml_files_in(folder))
      texts.push_back(*config::read_text_file(std::string(folder) + "/" + name + ".yaml"));
  texts.back() += "clock_bits: 64\n";
  expect_one_message_each(texts, config::profile_format(), 1, [&](const std::string& changed) {
    std::ofstream(file) << changed;
    const auto p = config::load_profile(file);
    return p ? std::vector<Error>{} : p.error();
  });
  fs::remove(file);
}

}  // namespace
}  // namespace gantry::wrong
