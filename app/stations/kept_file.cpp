#include "app/stations/kept_file.hpp"

#include <filesystem>
#include <fmt/format.h>

#include "config/yaml.hpp"
#include "core/new_file.hpp"

namespace gantry::stations {
namespace {

constexpr int kFormat = 1;

}  // namespace

std::string KeptFile::path(const std::string& state, const std::string& bus) const {
  return fmt::format("{}/{}-{}.json", state, stem, bus.substr(0, bus.find(':')));
}

Result<void> KeptFile::read(const std::string& file, const std::function<void(const Json&)>& take) const {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return {};
  const auto text = config::read_text_file(file);
  if (!text) return tl::unexpected(text.error());
  try {
    const Json all = Json::parse(*text);
    if (all.at("format").get<int>() != kFormat) throw std::runtime_error("another format");
    take(all.at(std::string(rows)));
  } catch (const std::exception& error) {
    return fail(Fault::BadValue,
                fmt::format("{} cannot be read ({}); {}", unreadable, config::shortened(error.what(), 200), remedy),
                file);
  }
  return {};
}

Result<void> KeptFile::write(const std::string& file, const Json& all) const {
  return write_new_file(file, Json{{"format", kFormat}, {std::string(rows), all}}.dump(2) + "\n");
}

}  // namespace gantry::stations
