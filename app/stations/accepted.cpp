#include "app/stations/accepted.hpp"

#include <limits>
#include <stdexcept>

#include "app/stations/kept_file.hpp"
#include "config/same_device.hpp"

namespace gantry::stations {
namespace {

using Json = KeptFile::Json;
constexpr KeptFile kFile{.stem = "accepted",
                         .rows = "stations",
                         .unreadable = "what was accepted of the stations",
                         .remedy = "`gantry commission --all --accept` writes it anew"};

/// A station that only waits for its supply has nothing else in its row.
Json to_json(const config::Station& s) {
  Json row = Json::object();
  if (s.accepted) {
    const config::Accepted& a = *s.accepted;
    row = {{"vendor", a.vendor}, {"product", a.product},   {"revision", a.revision}, {"serial", a.serial},
           {"date", a.date},     {"compared", a.compared}, {"walked", a.walked},     {"walked_as", a.walked_as}};
    if (config::says_something(a.object))
      row["object_vendor"] = a.object.vendor, row["object_product"] = a.object.product;
  }
  row["restart_pending"] = s.restart_pending;
  return row;
}

/// A number that fits in no 32 bits is no station's, and the file is not what was written.
std::uint32_t number_of(const Json& j, const char* key) {
  const Json& value = j.at(key);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error(std::string("'") + key + "' is no number of 32 bits");
  return value.get<std::uint32_t>();
}

config::Accepted accepted_of(const Json& j) {
  const auto if_there = [&](const char* key) { return j.contains(key) ? number_of(j, key) : 0u; };
  return {.vendor = number_of(j, "vendor"),
          .product = number_of(j, "product"),
          .revision = number_of(j, "revision"),
          .serial = number_of(j, "serial"),
          .date = j.at("date").get<std::string>(),
          .compared =
              j.value("compared", j.value("walked", "").empty()),  // before there was the word, a walk accepted, too
          .walked = j.value("walked", ""),
          .walked_as = j.value("walked_as", ""),
          .object = {.vendor = if_there("object_vendor"), .product = if_there("object_product")}};
}

void take_row(const Json& row, config::Station& station) {
  station.restart_pending = row.at("restart_pending").get<bool>();
  if (row.size() > 1) station.accepted = accepted_of(row);
}

}  // namespace

std::string accepted_file(const std::string& state, const std::string& bus) { return kFile.path(state, bus); }

Result<void> read_accepted(const std::string& file, config::Machine& machine) {
  return kFile.read(file, [&](const Json& rows) {
    for (config::Station& station : machine.stations)
      if (const auto row = rows.find(station.name); row != rows.end()) take_row(*row, station);
  });
}

Result<void> write_accepted(const std::string& file, const config::Machine& machine) {
  Json rows = Json::object();
  for (const config::Station& station : machine.stations)
    if (station.accepted || station.restart_pending) rows[station.name] = to_json(station);
  return kFile.write(file, rows);
}

}  // namespace gantry::stations
