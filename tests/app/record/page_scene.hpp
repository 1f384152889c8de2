// The scene as a page holds it, read back out of the page.
#pragma once
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

#include "core/vec.hpp"

namespace gantry::record {

/// What the script element with this id holds.
inline std::string script_with(const std::string& page, const std::string& id) {
  const auto begin = page.find("id=\"" + id + "\">");
  if (begin == std::string::npos) return {};
  const auto content = page.find('>', begin) + 1;
  return page.substr(content, page.find("</script>", content) - content);
}

inline nlohmann::json scene_in(const std::string& page) {
  return nlohmann::json::parse(script_with(page, "scene-data"));
}

/// The page without what its scripts hold: the markup.
inline std::string markup_of(std::string page) {
  for (std::size_t at = 0; (at = page.find("<script", at)) != std::string::npos;) {
    const auto content = page.find('>', at) + 1;
    page.erase(content, page.find("</script>", content) - content);
    at = content;
  }
  return page;
}

inline Vec3 vec(const nlohmann::json& j, std::size_t at = 0) {
  return {j.at(at).get<double>(), j.at(at + 1).get<double>(), j.at(at + 2).get<double>()};
}

inline const nlohmann::json& named(const nlohmann::json& all, const std::string& key, const std::string& name) {
  for (const auto& each : all)
    if (each.at(key) == name) return each;
  ADD_FAILURE() << "nothing is named " << name;
  static const nlohmann::json kNone;
  return kNone;
}

}  // namespace gantry::record
