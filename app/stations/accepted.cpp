#include "app/stations/accepted.hpp"

#include "app/stations/kept_file.hpp"

namespace gantry::stations {
namespace {

using Json = KeptFile::Json;
constexpr KeptFile kFile{.stem = "accepted",
                         .rows = "stations",
                         .unreadable = "what was accepted of the stations",
                         .remedy = "`gantry commission --all --accept` writes it anew"};

Json to_json(const config::Accepted& a) {
  return {{"vendor", a.vendor}, {"product", a.product},    {"revision", a.revision},
          {"serial", a.serial}, {"date", a.date},          {"restart_pending", a.restart_pending},
          {"walked", a.walked}, {"walked_as", a.walked_as}};
}

config::Accepted from_json(const Json& j) {
  return {.vendor = j.at("vendor").get<std::uint32_t>(),
          .product = j.at("product").get<std::uint32_t>(),
          .revision = j.at("revision").get<std::uint32_t>(),
          .serial = j.at("serial").get<std::uint32_t>(),
          .date = j.at("date").get<std::string>(),
          .restart_pending = j.at("restart_pending").get<bool>(),
          .walked = j.value("walked", ""),
          .walked_as = j.value("walked_as", "")};
}

}  // namespace

std::string accepted_file(const std::string& state, const std::string& bus) { return kFile.path(state, bus); }

Result<void> read_accepted(const std::string& file, config::Machine& machine) {
  return kFile.read(file, [&](const Json& rows) {
    for (config::Station& station : machine.stations)
      if (const auto row = rows.find(station.name); row != rows.end()) station.accepted = from_json(*row);
  });
}

Result<void> write_accepted(const std::string& file, const config::Machine& machine) {
  Json rows = Json::object();
  for (const config::Station& station : machine.stations)
    if (station.accepted) rows[station.name] = to_json(*station.accepted);
  return kFile.write(file, rows);
}

}  // namespace gantry::stations
