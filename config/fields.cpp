#include "config/fields.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "core/near_word.hpp"

namespace gantry::config {
namespace {

constexpr std::string_view kVersionKey = "version";  // which every format has
constexpr std::size_t kMaxName = 64, kMaxText = 600, kMaxNumber = 60;

std::string shown(std::string_view text) { return shortened(text, 40); }

std::string what_it_is(const Node& node) {
  switch (node.kind) {
    case Node::Kind::Empty: return "nothing stands here";
    case Node::Kind::Sequence: return "a list stands here";
    case Node::Kind::Map: return "keys stand here";
    default: return fmt::format("'{}' stands here", shown(node.text));
  }
}

/// False for a node that has been reported already and for anything but a scalar, which is reported now.
bool expect_scalar(const Node& node, std::string_view wanted, Mistakes& mistakes) {
  if (node.kind == Node::Kind::Refused) return false;
  if (node.kind == Node::Kind::Scalar) return true;
  mistakes.add(Fault::BadValue, fmt::format("{}; expected {}", what_it_is(node), wanted), node.location);
  return false;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxName && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return is_letter(c) || is_digit(c) || c == '_' || c == '-' || c == '.'; });
}

/// Plain text that some YAML reader takes for another type: booleans and nulls of YAML 1.1, numbers, dates, 60-based
/// numbers, .nan and .inf. (Y and N are not: no reader in use does, and Y is an axis.)
bool ambiguous(const Node& node) {
  if (node.quoted) return false;
  std::string lower = node.text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  for (const std::string_view word :
       {"yes", "no", "on", "off", "true", "false", "null", "~", ".nan", ".inf", "-.inf", "+.inf", "="})
    if (lower == word) return true;
  const bool numeric = std::all_of(lower.begin(), lower.end(), [](char c) {
    return is_digit(c) || std::string_view("+-.eE_:xob").find(c) != std::string_view::npos;
  });
  return numeric && std::any_of(lower.begin(), lower.end(), is_digit) && !is_letter(lower[0]);
}

bool in_range(double value, const Range& range) {
  // A hair of slack: 180 deg read from text and 180 deg in code differ in the last bit.
  const double slack = 1e-12 * std::max(1.0, std::abs(value));
  return value >= range.min - slack && value <= range.max + slack;
}
std::string outside(double value, const Range& range, Dimension d) {
  if (!std::isfinite(range.max))
    return fmt::format("{} is less than {}", as_written(value, d), as_written(range.min, d));
  if (!std::isfinite(range.min))
    return fmt::format("{} is more than {}", as_written(value, d), as_written(range.max, d));
  if (range.min == range.max)
    return fmt::format("{} stands here; expected {}", as_written(value, d), as_written(range.min, d));
  return fmt::format("{} is outside {} .. {}", as_written(value, d), as_written(range.min, d),
                     as_written(range.max, d));
}

}  // namespace

std::string as_written(double value, Dimension dimension) {
  if (dimension == Dimension::Angle) return fmt::format("{:.6g} deg", units::deg(value));
  if (dimension == Dimension::Ratio) return fmt::format("{:.6g} %", value * 100);
  const std::string_view unit = units::name(dimension);
  return unit.empty() ? fmt::format("{:.9g}", value) : fmt::format("{:.9g} {}", value, unit);
}

std::optional<std::string> read_scalar(const Node& node, std::string_view wanted, Mistakes& mistakes) {
  if (!expect_scalar(node, wanted, mistakes)) return std::nullopt;
  return node.text;
}

std::optional<Quantity> read_quantity(const Node& node, const ValueShape& shape, Mistakes& mistakes) {
  const Dimension first = shape.dimensions.front();
  if (!expect_scalar(node, fmt::format("a value such as '{}'", units::example(first)), mistakes)) return std::nullopt;
  if (node.text.size() > kMaxNumber) {
    mistakes.add(Fault::BadValue,
                 fmt::format("'{}' is not a number; write for example '{}'", shown(node.text), units::example(first)),
                 node.location);
    return std::nullopt;
  }
  std::optional<Error> error;
  for (const Dimension dimension : shape.dimensions) {
    const Result<double> value = units::parse(node.text, dimension);
    if (!value) {
      if (!error) error = value.error();
      continue;
    }
    if (!in_range(*value, shape.range)) {
      mistakes.add(Fault::OutOfRange, outside(*value, shape.range, dimension), node.location);
      return std::nullopt;
    }
    return Quantity{*value, dimension};
  }
  mistakes.add(error->fault, error->message, node.location);
  return std::nullopt;
}

std::optional<std::int64_t> read_integer(const Node& node, const ValueShape& shape, Mistakes& mistakes) {
  if (!expect_scalar(node, "a whole number", mistakes)) return std::nullopt;
  std::string_view text = node.text;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative) text.remove_prefix(1);
  const bool hex = text.size() > 2 && text[0] == '0' && text[1] == 'x';
  if (hex) text.remove_prefix(2);
  std::int64_t value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
  const bool octal = !hex && text.size() > 1 && text[0] == '0';  // 010 is 8 to some readers and 10 to others
  if (text.empty() || node.quoted || octal || text[0] == '-' || ec != std::errc{} || end != text.data() + text.size()) {
    mistakes.add(Fault::BadValue,
                 fmt::format("'{}' is not a whole number; write {:.0f}{}, without quotes, unit or leading zero",
                             shown(node.text), std::clamp(12.0, shape.range.min, shape.range.max),
                             in_range(0x1A, shape.range) ? " or 0x1A" : ""),
                 node.location);
    return std::nullopt;
  }
  if (negative) value = -value;
  if (!in_range(static_cast<double>(value), shape.range)) {
    mistakes.add(Fault::OutOfRange, outside(static_cast<double>(value), shape.range, Dimension::None), node.location);
    return std::nullopt;
  }
  return value;
}

std::optional<bool> read_flag(const Node& node, Mistakes& mistakes) {
  if (!expect_scalar(node, "true or false", mistakes)) return std::nullopt;
  if (!node.quoted && node.text == "true") return true;
  if (!node.quoted && node.text == "false") return false;
  mistakes.add(Fault::BadValue, fmt::format("'{}' stands here; write true or false", shown(node.text)), node.location);
  return std::nullopt;
}

std::optional<std::string> read_word(const Node& node, const ValueShape& shape, Mistakes& mistakes) {
  const bool name = shape.kind == ValueShape::Kind::Name;
  if (!expect_scalar(node, name ? "a name" : "text", mistakes)) return std::nullopt;
  if (ambiguous(node)) {
    mistakes.add(Fault::BadValue,
                 fmt::format("'{}' is no text to every YAML reader; {}", shown(node.text),
                             name ? "choose another name" : "put it in quotes"),
                 node.location);
  } else if (name && !is_name(node.text)) {
    mistakes.add(
        Fault::BadValue,
        fmt::format("'{}' is no name; a letter, then letters, digits, _ - . (at most {})", shown(node.text), kMaxName),
        node.location);
  } else if (node.text.empty() || node.text.size() > kMaxText) {
    mistakes.add(Fault::OutOfRange, fmt::format("1 .. {} bytes of text belong here", kMaxText), node.location);
  } else {
    return node.text;
  }
  return std::nullopt;
}

std::optional<std::size_t> read_choice(const Node& node, const ValueShape& shape, Mistakes& mistakes) {
  const std::string all = fmt::format("{}", fmt::join(shape.choices, ", "));
  if (!expect_scalar(node, "one of: " + all, mistakes)) return std::nullopt;
  for (std::size_t i = 0; i < shape.choices.size(); ++i)
    if (shape.choices[i] == node.text) return i;
  mistakes.add(Fault::BadValue, fmt::format("'{}' stands here; expected one of: {}", shown(node.text), all),
               node.location);
  return std::nullopt;
}

std::optional<std::pair<std::uint16_t, std::uint8_t>> read_address(const Node& node, Mistakes& mistakes) {
  if (!expect_scalar(node, "an object such as 0x6099:1", mistakes)) return std::nullopt;
  const std::string_view text = node.text;
  const std::size_t colon = std::min(text.find(':'), text.size());
  unsigned index = 0, sub = 0;
  bool ok = text.size() > 2 && text.substr(0, 2) == "0x";
  if (ok) {
    const auto [end, ec] = std::from_chars(text.data() + 2, text.data() + colon, index, 16);
    ok = ec == std::errc{} && end == text.data() + colon && index > 0 && index <= 0xFFFF;
  }
  if (ok && colon < text.size()) {
    const auto [end, ec] = std::from_chars(text.data() + colon + 1, text.data() + text.size(), sub, 10);
    ok = ec == std::errc{} && end == text.data() + text.size() && sub <= 255;
  }
  if (ok) return std::pair{static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)};
  mistakes.add(Fault::BadValue, fmt::format("'{}' is no object; write 0x6040 or 0x6099:1", shown(text)), node.location);
  return std::nullopt;
}

bool expect_list(const Node& node, Range count, Mistakes& mistakes) {
  if (node.kind == Node::Kind::Refused) return false;
  if (node.kind != Node::Kind::Sequence) {
    mistakes.add(Fault::BadValue,
                 fmt::format("{}; expected a list{}", what_it_is(node),
                             node.kind == Node::Kind::Map ? ": begin each item with '- '" : ""),
                 node.location);
    return false;
  }
  return expect_count(node, count, mistakes);
}

bool expect_count(const Node& node, Range count, Mistakes& mistakes) {
  const auto n = static_cast<double>(node.items.size());
  if (in_range(n, count)) return true;
  const bool few = n < count.min;
  mistakes.add(Fault::OutOfRange,
               fmt::format("{} {} here; {} {} are wanted", n, n == 1 ? "stands" : "stand", few ? "at least" : "at most",
                           few ? count.min : count.max),
               node.location);
  return false;
}

bool expect_map(const Node& node, std::string_view what, Mistakes& mistakes) {
  if (node.kind == Node::Kind::Map) return true;
  if (node.kind != Node::Kind::Refused)
    mistakes.add(Fault::BadValue,
                 fmt::format("{}; expected {}{}", what_it_is(node), what,
                             node.kind == Node::Kind::Sequence ? ", without '- '" : ""),
                 node.location);
  return false;
}

bool expect_name(const Node::Key& key, Mistakes& mistakes) {
  Node as_node;
  as_node.kind = Node::Kind::Scalar;
  as_node.text = key.text;
  as_node.location = key.location;
  return read_word(as_node, {ValueShape::Kind::Name, {}, kAny, {}, {}, {}}, mistakes).has_value();
}

namespace {

bool is_known(const std::vector<const FieldShape*>& known, std::string_view key) {
  return std::any_of(known.begin(), known.end(), [&](const FieldShape* field) { return field->key == key; });
}

/// A value that may stand behind a key; empty: it is too long to show, or none comes to mind.
std::string example_of(const ValueShape& shape) {
  using Kind = ValueShape::Kind;
  switch (shape.kind) {
    case Kind::Number: {
      const Dimension dimension = shape.dimensions.empty() ? Dimension::None : shape.dimensions.front();
      const std::string text(units::example(dimension));
      const auto value = units::parse(text, dimension);
      return value && *value >= shape.range.min && *value <= shape.range.max ? text : "";
    }
    case Kind::Integer: return fmt::format("{:.0f}", std::isfinite(shape.range.min) ? shape.range.min : 1.0);
    case Kind::Flag: return "true";
    case Kind::Choice: return shape.choices.empty() ? "" : shape.choices.front();
    case Kind::Tuple: {
      std::string all;
      for (std::size_t i = 0; i + shape.optional_items < shape.items.size(); ++i) {
        const std::string one = example_of(shape.items[i]);
        if (one.empty()) return "";
        all += (i > 0 ? ", " : "") + one;
      }
      return "[" + all + "]";
    }
    default: return "";
  }
}

std::string for_example(const FieldShape& field) {
  const std::string value = example_of(field.shape);
  return value.empty() ? "" : fmt::format("; write for example `{}: {}`", field.key, value);
}

/// Where one key is unknown and one is missing, that one was meant, however little it is like it; else null.
const FieldShape* only_one_missing(const Node& map, const std::vector<const FieldShape*>& known) {
  std::size_t unknown = 0, missing = 0;
  const FieldShape* found = nullptr;
  for (const Node::Key& key : map.keys) unknown += !is_known(known, key.text);
  for (const FieldShape* field : known)
    if (field->need == kRequired && !map.find(field->key)) ++missing, found = field;
  return unknown == 1 && missing == 1 ? found : nullptr;
}

}  // namespace

void check_keys(const Node& map, const std::vector<const FieldShape*>& known, Location owner, Mistakes& mistakes) {
  std::vector<std::string_view> words;
  for (const FieldShape* field : known) words.push_back(field->key);
  std::vector<std::string_view> open;  // that are not there
  std::copy_if(words.begin(), words.end(), std::back_inserter(open),
               [&](std::string_view word) { return map.find(word) == nullptr; });
  const FieldShape* const only = only_one_missing(map, known);
  std::vector<std::string_view> meant;  // a misspelt key is one mistake, not an unknown and a missing one
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const auto& key = map.keys[i];
    if (map.items[i].kind == Node::Kind::Refused || is_known(known, key.text)) continue;
    if (mistakes.full()) {
      mistakes.add(Fault::UnknownKey, {}, key.location);
      continue;
    }
    const auto& likely = nearest(key.text, open).empty() ? words : open;
    std::string_view near = nearest(key.text, likely);
    std::string words_of_it = did_you_mean(key.text, likely);
    if (near.empty() && only != nullptr) {
      near = only->key;
      words_of_it = fmt::format("{} It is missing here ({}){}", did_you_mean(only->key), only->doc, for_example(*only));
    }
    if (!near.empty()) meant.push_back(near);
    // {why: one, two}: "two" is read as a key.
    const char* const comma = map.items[i].kind == Node::Kind::Empty ? " (text with a comma belongs in quotes)" : "";
    mistakes.add(Fault::UnknownKey, fmt::format("unknown key '{}'; {}{}", shown(key.text), words_of_it, comma),
                 key.location);
  }
  for (const FieldShape* field : known)
    if (field->need == kRequired && !map.find(field->key) &&
        std::find(meant.begin(), meant.end(), field->key) == meant.end())
      mistakes.add(Fault::MissingKey,
                   fmt::format("'{}' is missing here ({}){}", field->key, field->doc, for_example(*field)), owner);
}

std::size_t told(const Mistakes& mistakes) {
  return mistakes.none() ? 0 : mistakes.full() ? Mistakes::kMost : mistakes.errors().size();
}

bool is_of_format(const Node& root, const std::vector<FieldShape>& format, std::string_view what, Mistakes& mistakes) {
  constexpr std::size_t kFew = 3, kShown = 6, kShare = 4;
  std::vector<std::string_view> wanted, there;
  for (const FieldShape& field : format)
    if (field.need == kRequired && field.key != kVersionKey) wanted.push_back(field.key);
  for (const auto& key : root.keys)
    if (key.text != kVersionKey && there.size() < kShown) there.push_back(key.text);
  const auto known = static_cast<std::size_t>(std::count_if(format.begin(), format.end(), [&](const FieldShape& field) {
    return field.key != kVersionKey && root.find(field.key) != nullptr;
  }));
  const bool a_list = root.kind == Node::Kind::Sequence;
  if (!a_list && (root.kind != Node::Kind::Map || root.keys.size() < kFew || kShare * known > root.keys.size()))
    return true;
  mistakes.add(Fault::BadValue,
               fmt::format("this is not {0}: {1}; {0} has the keys {2}; name another file", what,
                           a_list ? "it is a list" : fmt::format("its keys are {}, ...", fmt::join(there, ", ")),
                           fmt::join(wanted, ", ")),
               {1, 1});
  return false;
}

std::vector<std::size_t> kinds_of(const Node& item, const std::vector<std::string_view>& kinds, Mistakes& mistakes) {
  if (item.kind == Node::Kind::Refused) return {};
  const std::string sample = fmt::format("write for example '- {}: {{...}}'", kinds.front());
  if (item.kind != Node::Kind::Map) {
    mistakes.add(Fault::BadValue,
                 fmt::format("{}; expected one of {}; {}", what_it_is(item), fmt::join(kinds, ", "), sample),
                 item.location);
    return {};
  }
  std::vector<std::size_t> named;
  std::size_t other = item.keys.size();  // the first key that names none
  for (std::size_t i = 0; i < item.keys.size(); ++i)
    if (std::find(kinds.begin(), kinds.end(), item.keys[i].text) != kinds.end())
      named.push_back(i);
    else
      other = std::min(other, i);
  if (named.size() > 1) {
    mistakes.add(Fault::BadValue,
                 fmt::format("one kind belongs to an item, and '{}' and '{}' stand here; begin '{}' with '- '",
                             item.keys[named[0]].text, item.keys[named[1]].text, item.keys[named[1]].text),
                 item.keys[named[1]].location);
  } else if (named.empty() && item.keys.size() == 1) {
    if (item.items[0].kind == Node::Kind::Refused) return {};
    mistakes.add(Fault::UnknownKey,
                 fmt::format("unknown key '{}'; {}", shown(item.keys[0].text), did_you_mean(item.keys[0].text, kinds)),
                 item.keys[0].location);
  } else if (named.empty()) {
    mistakes.add(Fault::BadValue,
                 fmt::format("no kind is named here; expected one of {}; {}", fmt::join(kinds, ", "), sample),
                 item.keys.empty() ? item.location : item.keys[0].location);
  } else if (other < item.keys.size()) {
    const Node& of_kind = item.items[named[0]];
    mistakes.add(Fault::BadValue,
                 fmt::format("'{0}' stands beside '{1}'; what belongs to '{1}' is indented further than it",
                             shown(item.keys[other].text), item.keys[named[0]].text),
                 item.keys[other].location);
    if (of_kind.kind != Node::Kind::Map) return {};
  }
  return named;
}

bool read_tuple(const Node& node, const ValueShape& shape, std::vector<Quantity>& to, Mistakes& mistakes) {
  if (node.kind == Node::Kind::Refused) return false;
  const std::size_t most = shape.items.size(), least = most - shape.optional_items;
  if (node.kind != Node::Kind::Sequence || node.items.size() > most || node.items.size() < least) {
    std::string sample;
    for (std::size_t i = 0; i < least; ++i)
      sample += (i == 0 ? "" : ", ") + std::string(units::example(shape.items[i].dimensions.front()));
    const std::string wanted = least == most ? std::to_string(most) : fmt::format("{} or {}", least, most);
    mistakes.add(Fault::BadValue,
                 node.kind == Node::Kind::Sequence
                     ? fmt::format("{} values stand here; expected {}, such as [{}]", node.items.size(), wanted, sample)
                     : fmt::format("{}; expected [{}]", what_it_is(node), sample),
                 node.location);
    return false;
  }
  to.clear();
  for (std::size_t i = 0; i < node.items.size(); ++i)
    if (const auto v = read_quantity(node.items[i], shape.items[i], mistakes)) to.push_back(*v);
  return to.size() == node.items.size();
}

}  // namespace gantry::config
