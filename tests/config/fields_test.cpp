// What stands behind a key: every value that is not as its row says is a mistake at its location.
#include "config/fields.hpp"

#include <array>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace gantry::config {
namespace {

enum class Colour { Red, Green };
struct Item {
  std::string name;
  Location location;
  double size = 0;
};
struct Thing {
  double speed = 0, ratio = 1;
  At<Quantity> extent;
  int count = -1;
  bool on = false;
  std::string label, title;
  Colour colour = Colour::Red;
  std::pair<int, int> unused;
  At<Vec2> at;
  std::vector<Item> items;
  std::optional<Item> extra;
  struct Address {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
  } object;
};

const Fields<Item> kItem{number("size", &Item::size, Dimension::Length, {0, 10}, kRequired, "how large")};
const Fields<Thing> kThing{
    number("speed", &Thing::speed, Dimension::Speed, {0.5, 100}, kRequired, "how fast"),
    number("ratio", &Thing::ratio, Dimension::None, {0, 5}, kOptional, "a plain number"),
    quantity("extent", &Thing::extent, {Dimension::Length, Dimension::Angle}, kOptional, "mm or deg"),
    integer("count", &Thing::count, {0, 2000}, kOptional, "how many"),
    flag("on", &Thing::on, kOptional, "is it"),
    name_of("label", &Thing::label, kOptional, "its name"),
    text("title", &Thing::title, kOptional, "its title"),
    choice("colour", &Thing::colour, Choices<Colour>{{"red", Colour::Red}, {"green", Colour::Green}}, kOptional,
           "its colour"),
    point("at", &Thing::at, {-50, 50}, kOptional, "where"),
    named("items", &Thing::items, kItem, {0, 2}, kOptional, "its items"),
    object("extra", &Thing::extra, kItem, kOptional, "one more"),
    address("object", &Thing::object, kOptional, "an object"),
};

struct Outcome {
  std::optional<Thing> thing;
  std::vector<Error> errors;
};
Outcome read(const std::string& text) {
  Mistakes mistakes("f.yaml");
  Outcome out;
  out.thing = read_fields(text, kThing, mistakes);
  out.errors = mistakes.errors();
  return out;
}

TEST(Fields, read_values_into_the_units_of_the_house) {
  const Outcome out = read(
      "speed: 0.02 m/s\nratio: 2.5\nextent: 90 deg\ncount: 0x1F\non: true\nlabel: y1\ntitle: \"no\"\ncolour: green\n"
      "at: [1 mm, -2.5 mm]\nitems:\n  b: {size: 1 mm}\n  a: {size: 2 mm}\nextra: {size: 3 mm}\nobject: 0x6099:1\n");
  ASSERT_TRUE(out.errors.empty()) << to_text(out.errors[0]);
  const Thing& t = *out.thing;
  EXPECT_DOUBLE_EQ(t.speed, 20);
  EXPECT_EQ(t.extent.value.dimension, Dimension::Angle);
  EXPECT_DOUBLE_EQ(t.extent.value.value, units::rad(90));
  EXPECT_EQ(t.extent.location, (Location{3, 9}));
  EXPECT_EQ(t.count, 31);
  EXPECT_EQ(t.title, "no");
  EXPECT_EQ(t.colour, Colour::Green);
  EXPECT_EQ(t.at.value.y, -2.5);
  ASSERT_EQ(t.items.size(), 2u);
  EXPECT_EQ(t.items[0].name, "b") << "the order of the file";
  EXPECT_EQ(t.items[1].location, (Location{12, 3}));
  EXPECT_EQ(t.extra->size, 3);
  EXPECT_EQ(t.object.index, 0x6099);
  EXPECT_EQ(t.object.sub, 1);
}

struct Trick {
  const char* line;
  Fault fault;
  int column;
  const char* says;
};
void PrintTo(const Trick& trick, std::ostream* out) { *out << trick.line; }
class Value : public testing::TestWithParam<Trick> {};

TEST_P(Value, is_refused_with_its_place) {
  const Trick& t = GetParam();
  const Outcome out = read(std::string("speed: 1 mm/s\n") + t.line + "\n");
  ASSERT_EQ(out.errors.size(), 1u) << (out.errors.empty() ? "" : to_text(out.errors.back()));
  EXPECT_EQ(out.errors[0].fault, t.fault) << to_text(out.errors[0]);
  EXPECT_EQ(out.errors[0].where, "f.yaml:2:" + std::to_string(t.column)) << to_text(out.errors[0]);
  EXPECT_NE(out.errors[0].message.find(t.says), std::string::npos) << to_text(out.errors[0]);
}

INSTANTIATE_TEST_SUITE_P(
    Fields, Value,
    testing::Values(
        // numbers
        Trick{"extent: 5", Fault::BadUnit, 9, "lacks a unit"}, Trick{"extent: 5 mm/s", Fault::BadUnit, 9, "mm/s"},
        Trick{"extent: 5 inch", Fault::BadUnit, 9, "inch"}, Trick{"extent: .nan mm", Fault::BadValue, 9, ".nan"},
        Trick{"extent: .inf", Fault::BadValue, 9, ".inf"}, Trick{"extent: 1e999 mm", Fault::BadValue, 9, "1e999"},
        Trick{"extent: 010 mm", Fault::BadValue, 9, "010"}, Trick{"extent: 0x10 mm", Fault::BadUnit, 9, "x10"},
        Trick{"extent: 1_000 mm", Fault::BadUnit, 9, "_000"},
        Trick{"extent: 1,5 mm", Fault::BadValue, 9, "decimal comma"},
        Trick{"extent: --5 mm", Fault::BadValue, 9, "--5"}, Trick{"extent:", Fault::BadValue, 1, "nothing stands here"},
        Trick{"extent: ~", Fault::BadValue, 9, "nothing stands here"},
        Trick{"extent: [5 mm]", Fault::BadValue, 9, "a list"}, Trick{"extent: {a: 5 mm}", Fault::BadValue, 9, "keys"},
        Trick{"ratio: 2 mm", Fault::BadUnit, 8, "plain number"}, Trick{"ratio: .inf", Fault::BadValue, 8, ".inf"},
        Trick{"ratio: 5.01", Fault::OutOfRange, 8, "0 .. 5"}, Trick{"ratio: -0.1", Fault::OutOfRange, 8, "0 .. 5"},
        Trick{"ratio: 010", Fault::BadValue, 8, "010"},
        // whole numbers
        Trick{"count: 010", Fault::BadValue, 8, "010"}, Trick{"count: 1.5", Fault::BadValue, 8, "1.5"},
        Trick{"count: 1e3", Fault::BadValue, 8, "1e3"}, Trick{"count: \"12\"", Fault::BadValue, 8, "12"},
        Trick{"count: 0o17", Fault::BadValue, 8, "0o17"}, Trick{"count: 0b11", Fault::BadValue, 8, "0b11"},
        Trick{"count: 12 mm", Fault::BadValue, 8, "12 mm"}, Trick{"count: +5", Fault::BadValue, 8, "+5"},
        Trick{"count: ''", Fault::BadValue, 8, ""}, Trick{"count: 1:30", Fault::BadValue, 8, "1:30"},
        Trick{"count: 99999999999999999999", Fault::BadValue, 8, "999"},
        Trick{"count: -1", Fault::OutOfRange, 8, "0 .. 2000"}, Trick{"count: 2001", Fault::OutOfRange, 8, "0 .. 2000"},
        // flags
        Trick{"on: yes", Fault::BadValue, 5, "true or false"}, Trick{"on: no", Fault::BadValue, 5, "true or false"},
        Trick{"on: True", Fault::BadValue, 5, "true or false"}, Trick{"on: 1", Fault::BadValue, 5, "true or false"},
        Trick{"on: \"true\"", Fault::BadValue, 5, "true or false"},
        // names and text
        Trick{"label: no", Fault::BadValue, 8, "another name"}, Trick{"label: Off", Fault::BadValue, 8, "another name"},
        Trick{"label: 12", Fault::BadValue, 8, "another name"}, Trick{"label: a b", Fault::BadValue, 8, "no name"},
        Trick{"label: \"../x\"", Fault::BadValue, 8, "no name"}, Trick{"label: \"\"", Fault::BadValue, 8, "no name"},
        Trick{"title: no", Fault::BadValue, 8, "quotes"}, Trick{"title: 8.4", Fault::BadValue, 8, "quotes"},
        Trick{"title: .nan", Fault::BadValue, 8, "quotes"}, Trick{"title: 2024-06-01", Fault::BadValue, 8, "quotes"},
        Trick{"title: 1:30", Fault::BadValue, 8, "quotes"},
        Trick{"title: null", Fault::BadValue, 8, "nothing stands here"},
        Trick{"title: \"\"", Fault::OutOfRange, 8, "bytes of text"},
        // the rest
        Trick{"colour: gren", Fault::BadValue, 9, "red, green"}, Trick{"at: 5 mm", Fault::BadValue, 5, "expected ["},
        Trick{"at: [1 mm]", Fault::BadValue, 5, "expected 2"},
        Trick{"at: [1 mm, 2 mm, 3 mm]", Fault::BadValue, 5, "expected 2"},
        Trick{"at: [1 mm, 2]", Fault::BadUnit, 12, "lacks a unit"},
        Trick{"at: [1 mm, 51 mm]", Fault::OutOfRange, 12, "-50 mm .. 50 mm"},
        Trick{"items: {a: {size: 1 mm}, b: {size: 1 mm}, c: {size: 1 mm}}", Fault::OutOfRange, 8,
              "3 stand here; at most 2"},
        Trick{"items: {a: {size: 11 mm}}", Fault::OutOfRange, 19, "10 mm"},
        Trick{"items: {a: {}}", Fault::MissingKey, 9, "'size'"},
        Trick{"items: {a b: {size: 1 mm}}", Fault::BadValue, 9, "no name"},
        Trick{"items: [a]", Fault::BadValue, 8, "a list"}, Trick{"extra: 5", Fault::BadValue, 8, "expected keys"},
        Trick{"object: 6099h", Fault::BadValue, 9, "0x6040"},
        Trick{"object: 0x6099:300", Fault::BadValue, 9, "no object"},
        Trick{"object: 0x16040", Fault::BadValue, 9, "no object"},
        Trick{"color: red", Fault::UnknownKey, 1, "'colour'"},
        Trick{"weather: 5", Fault::UnknownKey, 1, "known: speed"}));

TEST(Fields, an_unknown_key_that_stands_again_is_one_error_with_its_places) {
  std::string text = "speed: 0.02 m/s\nitems:\n";
  for (const char name : std::string("ab")) text += fmt::format("  {}: {{sise: 1 mm}}\n", name);
  const Outcome out = read(text);
  ASSERT_EQ(out.errors.size(), 1U);
  EXPECT_EQ(to_text(out.errors[0]), "f.yaml:3:7: unknown key 'sise'; did you mean 'size'?; the same at 4:7 [G402]");
}

TEST(Fields, a_long_value_makes_no_long_message) {
  const std::string digits(100000, '7'), accents = std::string(39, 'x') + "\u00e9\u00e9";
  for (const std::string& value : {digits, "\"" + digits + "\"", accents}) {
    const Outcome out = read("speed: " + value + "\n");
    ASSERT_EQ(out.errors.size(), 1u);
    EXPECT_LT(out.errors[0].message.size(), 200u);
    EXPECT_NE(out.errors[0].message.find("20 mm/s"), std::string::npos) << out.errors[0].message;
  }
  const Outcome cut = read("colour: " + accents + "\n");
  EXPECT_NE(cut.errors.back().message.find(std::string(39, 'x') + "..."), std::string::npos) << "no half character";
  EXPECT_EQ(shortened("\u00e9\u00e9", 3), "\u00e9...");
}

TEST(Fields, a_misspelt_key_is_one_mistake) {
  const Outcome out = read("sped: 1 mm/s\n");
  ASSERT_EQ(out.errors.size(), 1u);
  EXPECT_EQ(out.errors[0].where, "f.yaml:1:1");
  EXPECT_NE(out.errors[0].message.find("'speed'"), std::string::npos);
}

TEST(Fields, a_comma_that_cuts_text_is_hinted_at) {
  const Outcome out = read("speed: 1 mm/s\nextra: {size: 1 mm, and so on}\n");
  ASSERT_EQ(out.errors.size(), 1u);
  EXPECT_NE(out.errors[0].message.find("belongs in quotes"), std::string::npos);
}

TEST(Fields, a_missing_key_is_told_where_its_owner_stands) {
  const Outcome out = read("ratio: 1\nitems:\n  first:\n    {}\n");
  ASSERT_EQ(out.errors.size(), 2u);
  EXPECT_EQ(out.errors[0].where, "f.yaml:1:1");
  EXPECT_EQ(out.errors[1].where, "f.yaml:3:3");
}

TEST(Fields, what_is_refused_as_yaml_is_not_told_again) {
  EXPECT_EQ(read("speed: &v 1 mm/s\nitems: {a: {size: *v}}\n").errors.size(), 1u);
  EXPECT_EQ(read("speed: 1 mm/s\nspeed: 2\n").errors.size(), 1u);
}

TEST(Fields, all_mistakes_of_a_file_are_told_in_its_order) {
  const Outcome out = read("speed: 1000 mm/s\non: yes\ncolour: blue\nat: [1, 2]\nextra: {sise: 1 mm}\n");
  const std::array<const char*, 6> where{"f.yaml:1:8", "f.yaml:2:5", "f.yaml:3:9",
                                         "f.yaml:4:6", "f.yaml:4:9", "f.yaml:5:9"};
  ASSERT_EQ(out.errors.size(), where.size());
  for (std::size_t i = 0; i < where.size(); ++i) EXPECT_EQ(out.errors[i].where, where[i]);
}

}  // namespace
}  // namespace gantry::config
