// A format is a table of fields: one row names a key, what stands behind it, its range and whether it is needed. The
// same table reads a file, makes the JSON Schema for editors and the tables of the docs.
//   const Fields<Material> kMaterial{
//       number("speed", &Material::speed, Dimension::Speed, {0.1, 500}, kRequired, "path speed of a bead"), ...};
//   std::optional<Recipe> recipe = read_fields(text, kRecipe, mistakes);   // mistakes.none(): it may be used
// Structs that hold a member `location` (line, column) learn where they stand; members of type At<V> learn where their
// value stands. A member `unread` is set where anything of the struct was a mistake: nothing more is told by its
// values, which would only be what the first mistake leads to.
#pragma once
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "config/line_slip.hpp"
#include "config/yaml.hpp"
#include "core/units.hpp"
#include "core/vec.hpp"

namespace gantry::config {

using units::Dimension;

/// A value and where it was written; location.line 0: it was not given.
template <class V>
struct At {
  V value{};
  Location location;
  [[nodiscard]] bool given() const { return location.line > 0; }
};

/// A number that may be of one of several dimensions (an axis is in mm or in degrees).
struct Quantity {
  double value = 0;  ///< in the house's unit of `dimension`
  Dimension dimension = Dimension::None;
};

/// Inclusive, in the house's unit; of lists: of the count.
struct Range {
  double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();
};
inline constexpr Range kAny{};

enum class Need : bool { Optional, Required };
inline constexpr Need kOptional = Need::Optional, kRequired = Need::Required;

struct FieldShape;
/// What may stand behind a key.
struct ValueShape {
  enum class Kind {
    Number,   ///< with a unit when dimensions are given
    Integer,  ///< decimal or 0x..
    Flag,     ///< true or false
    Name,     ///< letter, then letters, digits, _ - .
    Text,
    Choice,
    Address,  ///< 0x6099:1
    Setting,  ///< a number with or without a unit, or a list of them
    Object,
    List,   ///< of items[0]
    Tuple,  ///< items, of which the last `optional_items` may be left out
    Named,  ///< map from a name to items[0]
    Names,  ///< one of items[0], or a list of them
    OneOf,  ///< a map with exactly one of `fields`
  } kind = Kind::Text;
  std::vector<Dimension> dimensions;
  Range range;
  std::vector<std::string> choices;
  std::vector<FieldShape> fields;
  std::vector<ValueShape> items;
  std::size_t optional_items = 0;
};
struct FieldShape {
  std::string key;
  Need need = kOptional;
  std::string doc;
  ValueShape shape;
  std::string fallback{};  ///< what holds when the key is left out, as one would write it; empty: nothing does
};

template <class T>
struct Field {
  FieldShape row;
  std::function<void(const Node&, T&, Mistakes&)> read;
};
template <class T>
using Fields = std::vector<Field<T>>;

// Reading of one value: nullopt, and a mistake with its location, when it is not as the shape wants.
std::optional<Quantity> read_quantity(const Node& node, const ValueShape& shape, Mistakes& mistakes);
std::optional<std::int64_t> read_integer(const Node& node, const ValueShape& shape, Mistakes& mistakes);
std::optional<bool> read_flag(const Node& node, Mistakes& mistakes);
std::optional<std::string> read_word(const Node& node, const ValueShape& shape, Mistakes& mistakes);
std::optional<std::size_t> read_choice(const Node& node, const ValueShape& shape, Mistakes& mistakes);
/// Any plain value, as it is written.
std::optional<std::string> read_scalar(const Node& node, std::string_view wanted, Mistakes& mistakes);
/// Index and sub-index of "0x6099:1".
std::optional<std::pair<std::uint16_t, std::uint8_t>> read_address(const Node& node, Mistakes& mistakes);
/// False, and a mistake, when the node is no such container or its count is out of range.
bool expect_list(const Node& node, Range count, Mistakes& mistakes);
bool expect_count(const Node& node, Range count, Mistakes& mistakes);
bool expect_map(const Node& node, std::string_view what, Mistakes& mistakes);
bool expect_name(const Node::Key& key, Mistakes& mistakes);
/// Unknown and missing keys of a map. `owner` is where a missing key is reported.
void check_keys(const Node& map, const std::vector<const FieldShape*>& known, Location owner, Mistakes& mistakes);
/// False, and one mistake, where hardly a key of a file belongs to this format: another kind of file is meant. `what`:
/// "a recipe".
bool is_of_format(const Node& root, const std::vector<FieldShape>& format, std::string_view what, Mistakes& mistakes);
/// Of an item of a list whose one key names its kind, one of `kinds`: which of its keys do. More or less than one is
/// one mistake, whatever else stands there.
std::vector<std::size_t> kinds_of(const Node& item, const std::vector<std::string_view>& kinds, Mistakes& mistakes);

template <class T>
ValueShape object_shape(const Fields<T>& fields) {
  ValueShape shape;
  shape.kind = ValueShape::Kind::Object;
  for (const Field<T>& field : fields) shape.fields.push_back(field.row);
  return shape;
}

template <class T>
void set_location(T& to, Location location) {
  if constexpr (requires { to.location.line; }) to.location.line = location.line, to.location.column = location.column;
}

template <class T>
void set_unread(T& to, bool unread) {
  if constexpr (requires { to.unread; }) to.unread = unread;
}

/// How many mistakes there are, as far as they are kept.
std::size_t told(const Mistakes& mistakes);

/// Reads a map into a struct. `owner`: where its name stands.
template <class T>
void read_object(const Node& node, const Fields<T>& fields, T& to, Location owner, Mistakes& mistakes) {
  set_location(to, owner);
  set_unread(to, true);
  if (!expect_map(node, "keys with values", mistakes)) return;
  const std::size_t before = told(mistakes);
  std::vector<const FieldShape*> known;
  for (const Field<T>& field : fields) known.push_back(&field.row);
  check_keys(node, known, owner, mistakes);
  bool refused = false;
  for (const Field<T>& field : fields)
    if (const Node* value = node.find(field.row.key); value && value->kind != Node::Kind::Refused)
      field.read(*value, to, mistakes);
    else
      refused = refused || value != nullptr;
  set_unread(to, refused || told(mistakes) != before);
}

/// A whole file. nullopt: not well-formed YAML, a line of it is missing, or, where it is told what it should be, quite
/// another kind of file; with mistakes the value is only good for looking for more of them. `mistakes`: of this file,
/// none yet. `tree`: where to put what the value was made from.
template <class T>
std::optional<T> read_fields(std::string_view text, const Fields<T>& fields, Mistakes& mistakes,
                             std::string_view what = {}, std::optional<Node>* tree = nullptr) {
  const std::vector<FieldShape> format = object_shape(fields).fields;
  const auto read = [&](std::string_view from, Mistakes& told) -> std::optional<T> {
    std::optional<Node> root = read_yaml(from, told);
    if (!root || (!what.empty() && !is_of_format(*root, format, what, told))) return std::nullopt;
    T to{};
    read_object(*root, fields, to, {1, 1}, told);
    if (tree != nullptr) *tree = std::move(root);
    return to;
  };
  auto out = read(text, mistakes);
  const auto slip = find_line_slip(text, mistakes, format, [&](std::string_view trial) {
    Mistakes told(mistakes.file());
    read(trial, told);
    return told;
  });
  if (!slip) return out;
  mistakes = slip->left;
  Mistakes told_already(mistakes.file());
  return slip->mended ? read(*slip->mended, told_already) : std::nullopt;
}

namespace detail {
template <class V>
struct IsAt : std::false_type {};
template <class V>
struct IsAt<At<V>> : std::true_type {};
template <class V>
struct IsOptional : std::false_type {};
template <class V>
struct IsOptional<std::optional<V>> : std::true_type {};

template <class V, class X>
void put(V& to, X&& value, const Node& node) {
  if constexpr (IsAt<V>::value) {
    put(to.value, std::forward<X>(value), node);
    to.location = node.location;
  } else if constexpr (IsOptional<V>::value) {
    put(to.emplace(), std::forward<X>(value), node);
  } else {
    to = static_cast<V>(std::forward<X>(value));
  }
}
/// The struct behind a member that may be optional.
template <class V>
auto& object_in(V& to) {
  if constexpr (IsOptional<V>::value)
    return to.emplace();
  else
    return to;
}
}  // namespace detail

/// A number as one would write it: "5 mm", "2.5 deg", "3".
std::string as_written(double value, Dimension dimension);

namespace detail {
/// What a member holds when its key is left out.
template <class T, class V>
std::string fallback(V T::*member, Need need, Dimension dimension) {
  if constexpr (std::is_arithmetic_v<V>)
    if (need == kOptional) return as_written(static_cast<double>(T{}.*member), dimension);
  return {};
}
}  // namespace detail

// One function a kind of row.

template <class T, class V>
Field<T> number(std::string key, V T::*member, Dimension dimension, Range range, Need need, std::string doc) {
  ValueShape shape{ValueShape::Kind::Number, {dimension}, range, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), shape, detail::fallback(member, need, dimension)},
          [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_quantity(node, shape, mistakes)) detail::put(to.*member, v->value, node);
          }};
}

/// A number whose unit tells which of several dimensions it has.
template <class T>
Field<T> quantity(std::string key, At<Quantity> T::*member, std::vector<Dimension> dimensions, Need need,
                  std::string doc) {
  ValueShape shape{ValueShape::Kind::Number, std::move(dimensions), kAny, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_quantity(node, shape, mistakes)) detail::put(to.*member, *v, node);
          }};
}

template <class T, class V>
Field<T> integer(std::string key, V T::*member, Range range, Need need, std::string doc) {
  ValueShape shape{ValueShape::Kind::Integer, {}, range, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), shape, detail::fallback(member, need, Dimension::None)},
          [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_integer(node, shape, mistakes)) detail::put(to.*member, *v, node);
          }};
}

template <class T, class V>
Field<T> flag(std::string key, V T::*member, Need need, std::string doc) {
  ValueShape shape{ValueShape::Kind::Flag, {}, kAny, {}, {}, {}};
  std::string otherwise;
  if constexpr (std::is_same_v<V, bool>)
    if (need == kOptional) otherwise = T{}.*member ? "true" : "false";
  return {{std::move(key), need, std::move(doc), shape, std::move(otherwise)},
          [member](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_flag(node, mistakes)) detail::put(to.*member, *v, node);
          }};
}

template <class T, class V>
Field<T> word(ValueShape::Kind kind, std::string key, V T::*member, Need need, std::string doc) {
  ValueShape shape{kind, {}, kAny, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_word(node, shape, mistakes)) detail::put(to.*member, *v, node);
          }};
}
/// A name of something: no blanks, nothing that YAML could read as another type.
template <class T, class V>
Field<T> name_of(std::string key, V T::*member, Need need, std::string doc) {
  return word(ValueShape::Kind::Name, std::move(key), member, need, std::move(doc));
}
template <class T, class V>
Field<T> text(std::string key, V T::*member, Need need, std::string doc) {
  return word(ValueShape::Kind::Text, std::move(key), member, need, std::move(doc));
}

/// A name, or a list of names, each with its location.
template <class T>
Field<T> names(std::string key, std::vector<At<std::string>> T::*member, Range count, Need need, std::string doc) {
  ValueShape name{ValueShape::Kind::Name, {}, kAny, {}, {}, {}};
  ValueShape shape{ValueShape::Kind::Names, {}, count, {}, {}, {name}};
  return {{std::move(key), need, std::move(doc), shape},
          [member, name, count](const Node& node, T& to, Mistakes& mistakes) {
            const auto take = [&](const Node& one) {
              if (auto v = read_word(one, name, mistakes)) (to.*member).push_back({std::move(*v), one.location});
            };
            if (node.kind != Node::Kind::Sequence) return take(node);
            if (!expect_list(node, count, mistakes)) return;
            for (const Node& each : node.items) take(each);
          }};
}

template <class E>
using Choices = std::vector<std::pair<std::string, E>>;
template <class T, class V, class E>
Field<T> choice(std::string key, V T::*member, Choices<E> choices, Need need, std::string doc) {
  ValueShape shape{ValueShape::Kind::Choice, {}, kAny, {}, {}, {}};
  std::string otherwise;
  for (const auto& [name, value] : choices) {
    shape.choices.push_back(name);
    if constexpr (std::is_same_v<V, E>)
      if (need == kOptional && T{}.*member == value) otherwise = name;
  }
  return {{std::move(key), need, std::move(doc), shape, std::move(otherwise)},
          [member, shape, choices = std::move(choices)](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_choice(node, shape, mistakes)) detail::put(to.*member, choices[*v].second, node);
          }};
}

/// V: a struct of (index, sub).
template <class T, class V>
Field<T> address(std::string key, V T::*member, Need need, std::string doc) {
  ValueShape shape{ValueShape::Kind::Address, {}, kAny, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), shape}, [member](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto v = read_address(node, mistakes)) to.*member = V{v->first, v->second};
          }};
}

template <class T, class V, class U>
Field<T> object(std::string key, V T::*member, const Fields<U>& fields, Need need, std::string doc) {
  return {{std::move(key), need, std::move(doc), object_shape(fields)},
          [member, fields](const Node& node, T& to, Mistakes& mistakes) {
            read_object(node, fields, detail::object_in(to.*member), node.location, mistakes);
          }};
}

/// A sequence of maps.
template <class T, class U>
Field<T> list(std::string key, std::vector<U> T::*member, const Fields<U>& fields, Range count, Need need,
              std::string doc) {
  ValueShape shape{ValueShape::Kind::List, {}, count, {}, {}, {object_shape(fields)}};
  return {{std::move(key), need, std::move(doc), shape},
          [member, fields, count](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_list(node, count, mistakes)) return;
            for (const Node& item : node.items)
              if (item.kind != Node::Kind::Refused)
                read_object(item, fields, (to.*member).emplace_back(), item.location, mistakes);
          }};
}

/// A sequence of integers.
template <class T, class V>
Field<T> integers(std::string key, std::vector<V> T::*member, Range range, Need need, std::string doc) {
  ValueShape item{ValueShape::Kind::Integer, {}, range, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), {ValueShape::Kind::List, {}, {0, 1000}, {}, {}, {item}}},
          [member, item](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_list(node, {0, 1000}, mistakes)) return;
            for (const Node& each : node.items)
              if (const auto v = read_integer(each, item, mistakes)) (to.*member).push_back(static_cast<V>(*v));
          }};
}

template <class T>
Field<T> texts(std::string key, std::vector<std::string> T::*member, Need need, std::string doc) {
  ValueShape item{ValueShape::Kind::Text, {}, kAny, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), {ValueShape::Kind::List, {}, {0, 1000}, {}, {}, {item}}},
          [member, item](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_list(node, {0, 1000}, mistakes)) return;
            for (const Node& each : node.items)
              if (auto v = read_word(each, item, mistakes)) (to.*member).push_back(std::move(*v));
          }};
}

/// A map from names to maps; U has `name`, and its location is the name's.
template <class T, class U>
Field<T> named(std::string key, std::vector<U> T::*member, const Fields<U>& fields, Range count, Need need,
               std::string doc) {
  ValueShape shape{ValueShape::Kind::Named, {}, count, {}, {}, {object_shape(fields)}};
  return {{std::move(key), need, std::move(doc), shape},
          [member, fields, count](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_map(node, "names with values", mistakes)) return;
            expect_count(node, count, mistakes);
            for (std::size_t i = 0; i < node.keys.size(); ++i) {
              if (!expect_name(node.keys[i], mistakes) || node.items[i].kind == Node::Kind::Refused) continue;
              U& each = (to.*member).emplace_back();
              each.name = node.keys[i].text;
              read_object(node.items[i], fields, each, node.keys[i].location, mistakes);
            }
          }};
}

/// One of several tables, told apart by the single key of the map: `- dot: {...}`.
template <class U>
struct Variant {
  std::string key;
  std::string doc;
  std::function<void(U&)> tag;  ///< marks the struct as this variant
  Fields<U> fields;
};
template <class T, class U>
Field<T> list_of_variants(std::string key, std::vector<U> T::*member, std::vector<Variant<U>> variants, Range count,
                          Need need, std::string doc) {
  ValueShape one{ValueShape::Kind::OneOf, {}, kAny, {}, {}, {}};
  for (const Variant<U>& v : variants) one.fields.push_back({v.key, kOptional, v.doc, object_shape(v.fields)});
  ValueShape shape{ValueShape::Kind::List, {}, count, {}, {}, {one}};
  return {{std::move(key), need, std::move(doc), shape},
          [member, one, count, variants = std::move(variants)](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_list(node, count, mistakes)) return;
            std::vector<std::string_view> known;
            for (const FieldShape& each : one.fields) known.push_back(each.key);
            for (const Node& item : node.items)
              for (const std::size_t i : kinds_of(item, known, mistakes))
                for (const Variant<U>& v : variants)
                  if (item.keys[i].text == v.key && item.items[i].kind != Node::Kind::Refused) {
                    U& each = (to.*member).emplace_back();
                    v.tag(each);
                    read_object(item.items[i], v.fields, each, item.keys[i].location, mistakes);
                  }
          }};
}

namespace detail {
template <class V>
struct Point;
template <>
struct Point<Vec2> {
  static constexpr std::size_t kSize = 2;
  static Vec2 from(const double* v) { return {v[0], v[1]}; }
};
template <>
struct Point<Vec3> {
  static constexpr std::size_t kSize = 3;
  static Vec3 from(const double* v) { return {v[0], v[1], v[2]}; }
};
template <class V>
struct Point<At<V>> : Point<V> {};
template <class V>
struct Point<std::optional<V>> : Point<V> {};

inline ValueShape tuple_shape(std::size_t size, std::vector<Dimension> dimensions, Range range) {
  ValueShape item{ValueShape::Kind::Number, std::move(dimensions), range, {}, {}, {}};
  return {ValueShape::Kind::Tuple, {}, kAny, {}, {}, std::vector<ValueShape>(size, item)};
}
}  // namespace detail

/// The numbers of a tuple, as many as stand there; false when it is none.
bool read_tuple(const Node& node, const ValueShape& shape, std::vector<Quantity>& to, Mistakes& mistakes);

namespace detail {
inline ValueShape spot_shape(Range plane, Range height) {
  ValueShape shape = tuple_shape(3, {Dimension::Length}, plane);
  shape.items.back().range = height;
  shape.optional_items = 1;
  return shape;
}
inline std::optional<Vec3> read_spot(const Node& node, const ValueShape& shape, Mistakes& mistakes) {
  std::vector<Quantity> v;
  if (!read_tuple(node, shape, v, mistakes)) return std::nullopt;
  return Vec3{v[0].value, v[1].value, v.size() > 2 ? v[2].value : 0};
}
}  // namespace detail

/// [10 mm, 20 mm] or [10 mm, 20 mm, 5 mm], by the member's type.
template <class T, class V>
Field<T> point(std::string key, V T::*member, Range range, Need need, std::string doc) {
  ValueShape shape = detail::tuple_shape(detail::Point<V>::kSize, {Dimension::Length}, range);
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            std::vector<Quantity> v;
            if (!read_tuple(node, shape, v, mistakes)) return;
            double xyz[3] = {};
            for (std::size_t i = 0; i < v.size(); ++i) xyz[i] = v[i].value;
            detail::put(to.*member, detail::Point<V>::from(xyz), node);
          }};
}

/// A point on a surface, and its height over it: [10 mm, 20 mm], or [10 mm, 20 mm, 3 mm]; left out the height is 0.
template <class T>
Field<T> spot(std::string key, At<Vec3> T::*member, Range plane, Range height, Need need, std::string doc) {
  ValueShape shape = detail::spot_shape(plane, height);
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            if (const auto p = detail::read_spot(node, shape, mistakes)) detail::put(to.*member, *p, node);
          }};
}

/// A sequence of them.
template <class T>
Field<T> spots(std::string key, std::vector<At<Vec3>> T::*member, Range count, Range plane, Range height, Need need,
               std::string doc) {
  ValueShape item = detail::spot_shape(plane, height);
  return {{std::move(key), need, std::move(doc), {ValueShape::Kind::List, {}, count, {}, {}, {item}}},
          [member, item, count](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_list(node, count, mistakes)) return;
            for (const Node& each : node.items)
              if (const auto p = detail::read_spot(each, item, mistakes)) (to.*member).push_back({*p, each.location});
          }};
}

/// A tuple of numbers of one of several dimensions: travel: [0 mm, 500 mm].
template <class T>
Field<T> quantities(std::string key, At<std::vector<Quantity>> T::*member, std::size_t size,
                    std::vector<Dimension> dimensions, Need need, std::string doc) {
  ValueShape shape = detail::tuple_shape(size, std::move(dimensions), kAny);
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            std::vector<Quantity> v;
            if (read_tuple(node, shape, v, mistakes)) detail::put(to.*member, std::move(v), node);
          }};
}

/// A map from names to one number each: park: {X: 20 mm, C: 0 deg}.
struct NamedQuantity {
  std::string name;
  Location location;
  At<Quantity> quantity;
};
template <class T>
Field<T> named_quantities(std::string key, std::vector<NamedQuantity> T::*member, std::vector<Dimension> dimensions,
                          Need need, std::string doc) {
  ValueShape item{ValueShape::Kind::Number, std::move(dimensions), kAny, {}, {}, {}};
  return {{std::move(key), need, std::move(doc), {ValueShape::Kind::Named, {}, kAny, {}, {}, {item}}},
          [member, item](const Node& node, T& to, Mistakes& mistakes) {
            if (!expect_map(node, "names with values", mistakes)) return;
            for (std::size_t i = 0; i < node.keys.size(); ++i)
              if (expect_name(node.keys[i], mistakes))
                if (const auto v = read_quantity(node.items[i], item, mistakes))
                  (to.*member).push_back({node.keys[i].text, node.keys[i].location, {*v, node.items[i].location}});
          }};
}

/// A value that names the version of the format; another one than `version` is a mistake.
template <class T>
Field<T> format_version(std::int64_t version) {
  const auto v = static_cast<double>(version);
  ValueShape shape{ValueShape::Kind::Integer, {}, {v, v}, {}, {}, {}};
  return {{"version", kRequired, "version of this format", shape},
          [shape](const Node& node, T&, Mistakes& mistakes) { read_integer(node, shape, mistakes); }};
}

}  // namespace gantry::config
