#include "app/stations/accepted.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "config/yaml.hpp"
#include "core/new_file.hpp"

namespace gantry::stations {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kFormat = 1;

Json to_json(const config::Accepted& a) {
  return {{"vendor", a.vendor}, {"product", a.product}, {"revision", a.revision},
          {"serial", a.serial}, {"date", a.date},       {"restart_pending", a.restart_pending}};
}

config::Accepted from_json(const Json& j) {
  return {.vendor = j.at("vendor").get<std::uint32_t>(),
          .product = j.at("product").get<std::uint32_t>(),
          .revision = j.at("revision").get<std::uint32_t>(),
          .serial = j.at("serial").get<std::uint32_t>(),
          .date = j.at("date").get<std::string>(),
          .restart_pending = j.at("restart_pending").get<bool>()};
}

}  // namespace

std::string accepted_file(const std::string& state, const std::string& bus) {
  return fmt::format("{}/accepted-{}.json", state, bus.substr(0, bus.find(':')));
}

Result<void> read_accepted(const std::string& file, config::Machine& machine) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return {};
  const auto text = config::read_text_file(file);
  if (!text) return tl::unexpected(text.error());
  try {
    const Json all = Json::parse(*text);
    if (all.at("format").get<int>() != kFormat) throw std::runtime_error("another format");
    const Json& rows = all.at("stations");
    for (config::Station& station : machine.stations)
      if (const auto row = rows.find(station.name); row != rows.end()) station.accepted = from_json(*row);
  } catch (const std::exception& error) {
    return fail(Fault::BadValue,
                fmt::format("what was accepted of the stations cannot be read ({}); `gantry commission --all --accept` "
                            "writes it anew",
                            config::shortened(error.what(), 200)),
                file);
  }
  return {};
}

Result<void> write_accepted(const std::string& file, const config::Machine& machine) {
  Json rows = Json::object();
  for (const config::Station& station : machine.stations)
    if (station.accepted) rows[station.name] = to_json(*station.accepted);
  return write_new_file(file, Json{{"format", kFormat}, {"stations", rows}}.dump(2) + "\n");
}

}  // namespace gantry::stations
