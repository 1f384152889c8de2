#include "config/schema.hpp"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace gantry::config {
namespace {

using Json = nlohmann::ordered_json;
using Kind = ValueShape::Kind;

constexpr const char* kNamePattern = "^[A-Za-z][A-Za-z0-9_.-]{0,63}$";

std::string units_pattern(const std::vector<Dimension>& dimensions) {
  std::string units;
  for (const Dimension d : dimensions)
    for (const std::string_view unit : units::symbols(d)) {
      if (!units.empty()) units += '|';
      for (const char c : unit) units += c == '^' ? "\\^" : std::string(1, c);
    }
  return "^[-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][-+]?[0-9]+)? *(" + units + ")$";
}

/// "0.1 mm .. 50 mm"; empty when anything goes.
std::string range_text(const ValueShape& shape) {
  const Dimension d = shape.dimensions.empty() ? Dimension::None : shape.dimensions.front();
  const bool low = std::isfinite(shape.range.min), high = std::isfinite(shape.range.max);
  if (low && high) {
    return shape.range.min == shape.range.max
               ? as_written(shape.range.min, d)
               : fmt::format("{} .. {}", as_written(shape.range.min, d), as_written(shape.range.max, d));
  }
  if (low) return fmt::format("at least {}", as_written(shape.range.min, d));
  return high ? fmt::format("at most {}", as_written(shape.range.max, d)) : "";
}

Json value_schema(const ValueShape& shape);

/// As JSON has it: what is written without a unit is a number or a flag.
Json fallback(const FieldShape& field) {
  const bool text = field.shape.kind == Kind::Choice ||
                    (field.shape.kind == Kind::Number && field.shape.dimensions.front() != Dimension::None);
  return text ? Json(field.fallback) : Json::parse(field.fallback);
}

Json object_schema(const std::vector<FieldShape>& fields) {
  Json out{{"type", "object"}, {"additionalProperties", false}};
  Json required = Json::array();
  Json& properties = out["properties"] = Json::object();
  for (const FieldShape& field : fields) {
    Json value = value_schema(field.shape);
    std::string doc = field.doc;
    if (field.shape.kind == Kind::Number && !range_text(field.shape).empty())
      doc += " (" + range_text(field.shape) + ")";
    value["description"] = doc;
    if (!field.fallback.empty()) value["default"] = fallback(field);
    properties[field.key] = std::move(value);
    if (field.need == kRequired) required.push_back(field.key);
  }
  if (!required.empty()) out["required"] = std::move(required);
  return out;
}

void set_bounds(Json& to, const Range& range, const char* least, const char* most, bool whole) {
  const auto number = [&](double v) { return whole ? Json(static_cast<std::int64_t>(v)) : Json(v); };
  if (std::isfinite(range.min) && range.min > -9e15) to[least] = number(range.min);
  if (std::isfinite(range.max) && range.max < 9e15) to[most] = number(range.max);
}

Json value_schema(const ValueShape& shape) {
  Json out;
  switch (shape.kind) {
    case Kind::Number:
      if (shape.dimensions.front() == Dimension::None) {
        out["type"] = "number";
        set_bounds(out, shape.range, "minimum", "maximum", false);
      } else {
        out["type"] = "string";
        out["pattern"] = units_pattern(shape.dimensions);
      }
      break;
    case Kind::Integer:
      out["type"] = "integer";
      set_bounds(out, shape.range, "minimum", "maximum", true);
      break;
    case Kind::Flag: out["type"] = "boolean"; break;
    case Kind::Name: out = {{"type", "string"}, {"pattern", kNamePattern}}; break;
    case Kind::Text: out = {{"type", "string"}, {"minLength", 1}, {"maxLength", 600}}; break;
    case Kind::Choice: out["enum"] = shape.choices; break;
    case Kind::Address:
      // 0x6040 alone is a number to YAML readers, 0x6099:1 is text.
      out["anyOf"] = Json::array({Json{{"type", "integer"}, {"minimum", 1}, {"maximum", 0xFFFF}},
                                  Json{{"type", "string"}, {"pattern", "^0x[0-9A-Fa-f]{1,4}(:[0-9]{1,3})?$"}}});
      break;
    case Kind::Setting: out["type"] = Json::array({"number", "string", "array"}); break;
    case Kind::Object: out = object_schema(shape.fields); break;
    case Kind::List:
      out["type"] = "array";
      out["items"] = value_schema(shape.items.front());
      set_bounds(out, shape.range, "minItems", "maxItems", true);
      break;
    case Kind::Names: {
      Json several{{"type", "array"}, {"items", value_schema(shape.items.front())}};
      set_bounds(several, shape.range, "minItems", "maxItems", true);
      out["anyOf"] = Json::array({value_schema(shape.items.front()), several});
      break;
    }
    case Kind::Tuple:
      out = {
          {"type", "array"}, {"minItems", shape.items.size() - shape.optional_items}, {"maxItems", shape.items.size()}};
      out["items"] = value_schema(shape.items.front());
      break;
    case Kind::Named:
      out["type"] = "object";
      out["propertyNames"] = Json{{"pattern", kNamePattern}};
      out["additionalProperties"] = value_schema(shape.items.front());
      set_bounds(out, shape.range, "minProperties", "maxProperties", true);
      break;
    case Kind::OneOf:
      out = object_schema(shape.fields);
      out["minProperties"] = out["maxProperties"] = 1;
      break;
  }
  return out;
}

std::string sample(const ValueShape& shape);
std::string samples(const std::vector<ValueShape>& items) {
  std::string out;
  for (const ValueShape& item : items) out += (out.empty() ? "" : ", ") + sample(item);
  return out;
}
std::string sample(const ValueShape& shape) {
  switch (shape.kind) {
    case Kind::Number: {
      std::string out;
      for (const Dimension d : shape.dimensions) out += (out.empty() ? "" : " or ") + std::string(units::example(d));
      return out;
    }
    case Kind::Integer: return "whole number";
    case Kind::Flag: return "true, false";
    case Kind::Name: return "name";
    case Kind::Text: return "text";
    case Kind::Choice: return fmt::format("{}", fmt::join(shape.choices, ", "));
    case Kind::Address: return "0x6099:1";
    case Kind::Setting: return "2.1 A or 10000";
    case Kind::Object: return "keys";
    case Kind::List: return "list";
    case Kind::Tuple: {
      const auto always = shape.items.end() - static_cast<std::ptrdiff_t>(shape.optional_items);
      const std::string all = "[" + samples({shape.items.begin(), always}) + "]";
      return shape.optional_items == 0 ? all : all + " or [" + samples(shape.items) + "]";
    }
    case Kind::Named: return "names";
    case Kind::Names: return "name or [name, name]";
    case Kind::OneOf: return "one key";
  }
  return "";
}

/// Of each number; where the last one, which may be left out, has its own, that too. Of a list also how many.
std::string ranges(const ValueShape& shape) {
  if (shape.kind == Kind::Named || shape.kind == Kind::Names) return "";
  if (shape.kind == Kind::Tuple) {
    const std::string first = range_text(shape.items.front()), last = range_text(shape.items.back());
    return last == first ? first : fmt::format("{}; the last {}", first, last);
  }
  if (shape.kind != Kind::List || shape.items.front().kind != Kind::Tuple) return range_text(shape);
  const std::string many = range_text(shape), each = ranges(shape.items.front());
  return many.empty() ? each : fmt::format("{} of them{}{}", many, each.empty() ? "" : ": ", each);
}

/// `choice`: one of the fields stands there, so that none of them can be said to be left out.
void rows(const std::vector<FieldShape>& fields, const std::string& above, bool choice, std::string& out);
void rows_below(const ValueShape& shape, const std::string& path, std::string& out) {
  if (shape.kind == Kind::Object || shape.kind == Kind::OneOf)
    rows(shape.fields, path + ".", shape.kind == Kind::OneOf, out);
  if (shape.kind == Kind::List) rows_below(shape.items.front(), path + "[]", out);
  if (shape.kind == Kind::Named) rows_below(shape.items.front(), path + ".NAME", out);
}
void rows(const std::vector<FieldShape>& fields, const std::string& above, bool choice, std::string& out) {
  for (const FieldShape& field : fields) {
    std::string value = sample(field.shape);
    if (field.shape.kind == Kind::List && field.shape.items.front().kind != Kind::Object &&
        field.shape.items.front().kind != Kind::OneOf)
      value = "list of " + sample(field.shape.items.front());
    const std::string need = field.need == kRequired || choice ? ""
                             : field.fallback.empty()          ? " (may be left out)"
                                                               : fmt::format(" (left out: {})", field.fallback);
    out += fmt::format("| `{}{}` | {} | {} | {}{} |\n", above, field.key, value, ranges(field.shape), field.doc, need);
    rows_below(field.shape, above + field.key, out);
  }
}

}  // namespace

std::string json_schema(const std::string& title, const std::vector<FieldShape>& format) {
  Json out{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title}};
  out.update(object_schema(format));
  return out.dump(1) + "\n";
}

std::string key_table(const std::vector<FieldShape>& format) {
  std::string out = "| key | value | range | meaning |\n|---|---|---|---|\n";
  rows(format, "", false, out);
  return out;
}

}  // namespace gantry::config
