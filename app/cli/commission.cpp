// gantry commission: what the stations say they are and which values they hold, beside what the machine file asks for;
// accepts identities, and writes what acts at power-up.
#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"
#include "app/cli/client.hpp"
#include "app/cli/commission_axis.hpp"
#include "app/cli/commission_walk.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/today.hpp"
#include "app/desk/state_folder.hpp"
#include "app/run/compose.hpp"
#include "app/stations/accepted.hpp"
#include "config/held_limits.hpp"
#include "config/look_alikes.hpp"
#include "config/same_device.hpp"
#include "core/near_word.hpp"
#include "devices/ethercat/parameters.hpp"
#include "devices/ethercat/restart_note.hpp"
#include "devices/ethercat/scan.hpp"

namespace gantry::cli {
namespace {

using nlohmann::ordered_json;

struct CommissionOptions : BusOptions {
  std::string station, state, speed;
  bool all = false, accept = false, write = false, walk = false;
};

constexpr std::string_view kDiffers = "DIFFERS";  // in the table; an error says it by both values
constexpr int kNotReady = 5;                      // as G130 and G108 have it

std::string device(std::uint32_t vendor, std::uint32_t product) {
  return fmt::format("vendor {:08X}h, product {:08X}h", vendor, product);
}

std::string_view acts_text(config::ActsAt acts) {
  switch (acts) {
    case config::ActsAt::Once: return "at once";
    case config::ActsAt::Standstill: return "at standstill";
    case config::ActsAt::PowerUp: return "at power-up";
  }
  return "";
}

/// One station, read and, as asked, accepted and written.
class Commissioning {
 public:
  /// `keep` writes what is accepted, and which stations wait for their supply, into the state folder.
  Commissioning(const CommissionOptions& options, const config::Machine& machine, devices::Survey& survey, bool json,
                std::function<Result<void>()> keep)
      : options_(options), machine_(machine), survey_(survey), json_(json), keep_(std::move(keep)) {}

  Result<ordered_json> visit(config::Station& station, const devices::FoundStation& found) {
    const devices::StationSii& sii = found.record.sii;
    if (station.restart_pending && found.record.since_power_up) station.restart_pending = false, changed_ = true;
    const auto object = survey_.read_identity_object(found.record.position);
    const config::ObjectIdentity said = object.value_or(config::ObjectIdentity{});
    const bool agrees = object && config::agrees(said, config::expected_object(station.accepted, sii));
    const bool eeprom_same = config::as_expected(station, sii), same = eeprom_same && agrees;
    ordered_json out{
        {"station", station.name},      {"position", station.position},
        {"vendor", sii.vendor},         {"product", sii.product},
        {"revision", sii.revision},     {"serial", sii.serial},
        {"object_vendor", said.vendor}, {"object_product", said.product},
        {"alias", found.record.alias},  {"as_expected", same && config::alias_fits(station, found.record.alias)}};
    if (!json_) show_identity(station, found, eeprom_same);
    if (!json_) show_object(station, found, object);
    const Error unreadable{Fault::SiiInvalid, "its EEPROM cannot be read: " + sii.damage, devices::where(station)};
    if (options_.accept) {
      if (!sii.read) return tl::unexpected(unreadable);
      if (!object) return tl::unexpected(object.error());
      take(station, sii, said);
      out["accepted"] = station.accepted->date;
      if (!json_) print_text("    accepted {}\n", station.accepted->date);
    }
    if (!sii.read)
      refused_.push_back(unreadable);
    else if (auto taken = survey_.confirm(found.record.position, machine_, station); !taken) {
      if (taken.error().fault != Fault::IdentityMismatch) return tl::unexpected(taken.error());
      refused_.push_back(taken.error());
    }
    out["restart_pending"] = station.restart_pending;
    if (station.profile.startup.empty()) return out;
    // A device of another kind has other objects under these numbers.
    if (!same && !options_.accept) {
      out["parameters"] = "not read: another device than expected";
      if (!json_) print_text("    parameters not read: it is another device than expected\n");
      return out;
    }
    auto parameters = visit_parameters(station, found.record.position);
    if (!parameters) return tl::unexpected(parameters.error());
    out["parameters"] = std::move(*parameters);
    out["restart_pending"] = station.restart_pending;
    constexpr bool kRestarted = false;  // else nothing would be pending, or something was just written
    if (auto waits = devices::needs_restart(station, kRestarted, devices::where(station)))
      refused_.push_back(*std::move(waits));
    return out;
  }

  [[nodiscard]] std::ptrdiff_t differing() const {
    return std::ranges::count(refused_, Fault::ParameterDiffers, &Error::fault);
  }
  /// Why no start would give these stations torque.
  [[nodiscard]] std::vector<Error> refused(const std::vector<devices::FoundStation>& found) const {
    std::vector<Error> out = refused_;
    const auto read = [&](StationId id, config::ObjectAddress object) -> std::optional<std::int64_t> {
      const auto at =
          std::ranges::find_if(held_, [&](const Held& held) { return held.station == id && held.object == object; });
      return at == held_.end() ? std::nullopt : std::optional(at->value);
    };
    for (const config::HeldDoubt& doubt : config::held_limit_doubts(machine_, read))
      if (doubt.refuses)
        out.push_back({Fault::ParameterDiffers, doubt.text, devices::where(machine_.stations[doubt.station.value])});
    if (auto counted = devices::check_count(machine_, found.size()); !counted) out.push_back(counted.error());
    if (options_.interface.empty()) return out;
    for (std::string& wanted : config::wanted_on_steel(machine_))
      out.push_back({Fault::MissingKey, std::move(wanted), machine_.file});
    const auto serial = [&](const config::Station& s) -> std::optional<std::uint32_t> {
      const auto at = static_cast<std::size_t>(s.position);
      if (s.bus != config::BusKind::EtherCat || at >= found.size()) return std::nullopt;
      return found[at].record.sii.serial;
    };
    for (const config::Alike& alike : config::not_told_apart(machine_, serial))
      out.push_back({Fault::IdentityMismatch, alike.text, devices::where(machine_.stations[alike.station.value])});
    return out;
  }
  /// What is accepted is no longer what the file says.
  [[nodiscard]] bool changed() const { return changed_; }

 private:
  struct Held {
    StationId station;
    config::ObjectAddress object;
    std::int64_t value = 0;
  };

  static Error difference(const config::Station& station, const config::StartupRow& row,
                          const Result<devices::HeldObject>& held, const std::string& remark) {
    const std::string object = fmt::format("{} ({})", row.name, config::to_text(row.address));
    return {Fault::ParameterDiffers,
            held ? fmt::format("{} is {} instead of {}{}", object, held->value, row.value,
                               remark.starts_with(kDiffers) ? remark.substr(kDiffers.size()) : ": " + remark)
                 : fmt::format("{} {}", object, remark),
            devices::where(station)};
  }

  void take(config::Station& station, const devices::StationSii& sii, const config::ObjectIdentity& said) {
    station.accepted = config::kept_of(station, sii, today());
    station.accepted->object = said;
    station.accepted->compared = true;
    changed_ = true;
  }

  static void show_identity(const config::Station& station, const devices::FoundStation& found, bool same) {
    const devices::StationSii& sii = found.record.sii;
    const auto& id = station.profile.identity;
    print_text("{} '{}' ({})\n    {}, revision {:08X}h, serial {}, alias {}: ", station.position, station.name,
               station.profile.title, device(sii.vendor, sii.product), sii.revision, sii.serial,
               config::alias_fits(station, found.record.alias)
                   ? fmt::format("{}", found.record.alias)
                   : fmt::format("{} (the machine file says {})", found.record.alias, station.alias));
    if (station.accepted)
      print_text("{} {} {}{}\n", same ? "as" : "another than was",
                 station.accepted->compared ? "accepted" : "found by the walk of", station.accepted->date,
                 same && !station.accepted->compared ? "; `--accept` confirms it" : "");
    else if (same)
      print_text("{}\n", id.assumed ? "as assumed; `--accept` confirms it" : "as the profile says");
    else
      print_text("expected is {}{}\n", device(id.vendor, id.product), id.assumed ? ", which is assumed" : "");
  }

  /// What its firmware says, where that is not what its EEPROM says.
  static void show_object(const config::Station& station, const devices::FoundStation& found,
                          const Result<config::ObjectIdentity>& said) {
    const devices::StationSii& sii = found.record.sii;
    if (!said) return print_text("    its firmware (1018h): {}\n", said.error().message);
    if (config::agrees(*said, {sii.vendor, sii.product})) return;
    const config::ObjectIdentity expected = config::expected_object(station.accepted, sii);
    print_text("    its firmware (1018h) says {}: {}\n", device(said->vendor, said->product),
               config::agrees(*said, expected) ? "as accepted"
               : station.accepted && config::says_something(station.accepted->object)
                   ? "another one than was accepted"
                   : "another device than its EEPROM; look at its type plate before `--accept`");
  }

  Result<ordered_json> visit_parameters(config::Station& station, int position) {
    ordered_json rows = ordered_json::array();
    std::vector<config::ObjectAddress> written;
    devices::RestartNote note(station, keep_);
    // What an earlier try has written and could not save is saved with the rest.
    const bool waits = station.restart_pending;
    std::vector<std::string> notes;
    const auto asked = survey_.asked_of(position, station, notes);
    if (!asked) return tl::unexpected(asked.error());
    for (const config::StartupRow& row : *asked) {
      auto held = survey_.read_held(position, row);
      if (!held && held.error().fault != Fault::SdoAbort && held.error().fault != Fault::SdoSizeMismatch)
        return tl::unexpected(held.error());
      bool differs = held && held->value != row.value;
      std::string remark;
      if (held && !differs && waits && options_.write && row.rule == config::ParameterRule::Write &&
          row.acts == config::ActsAt::PowerUp)
        written.push_back(row.address);
      if (differs && options_.write && row.rule == config::ParameterRule::Write) {
        const auto write = [&] { return survey_.write_held(position, row, held->bytes); };
        if (auto ok = row.acts == config::ActsAt::PowerUp ? note.under(write) : write(); !ok) {
          if (!devices::is_refusal(ok.error())) return tl::unexpected(ok.error());
          remark = "refused: " + ok.error().message;
        } else {
          written.push_back(row.address);
          held = survey_.read_held(position, row);
          if (!held) return tl::unexpected(held.error());
          differs = held->value != row.value;
          remark = differs ? "the station ignores it" : "written";
        }
      }
      if (held) held_.push_back({station.id, row.address, held->value});
      if (!held) remark = row.declared ? "declared" : "cannot be read: " + held.error().message;
      const bool by_start = row.rule == config::ParameterRule::Write && row.acts != config::ActsAt::PowerUp;
      if (differs && remark.empty())
        remark = by_start                                       ? "written at every start"
                 : row.rule == config::ParameterRule::MustEqual ? std::string(kDiffers) + ", and is never written"
                                                                : std::string(kDiffers);
      if ((differs && (!by_start || options_.write)) || (!held && !row.declared))
        refused_.push_back(difference(station, row, held, remark));
      ordered_json one{{"name", row.name}, {"object", config::to_text(row.address)}, {"asked", row.value}};
      one["held"] = held ? ordered_json(held->value) : ordered_json();
      one["acts"] = acts_text(row.acts);
      one["remark"] = remark;
      rows.push_back(std::move(one));
      if (!json_)
        print_text("    {:<24} {:<9} asked {:>9}  holds {:>9}  {:<13} {}\n", row.name, config::to_text(row.address),
                   row.value, held ? fmt::format("{}", held->value) : "-", acts_text(row.acts), remark);
    }
    for (const std::string& left_out : notes)
      if (!json_) print_text("    {}\n", left_out);
    if (auto rest = show_not_pinned(station, position, rows); !rest) return tl::unexpected(rest.error());
    if (auto saved = survey_.save_parameters(position, station.profile, written); !saved)
      return tl::unexpected(saved.error());
    if (auto settled = note.settle(); !settled) return tl::unexpected(settled.error());
    return rows;
  }

  /// Parameters that nobody states: what the station holds of them, and what its manual has for a default.
  Result<void> show_not_pinned(const config::Station& station, int position, ordered_json& rows) {
    for (const config::StartupRow& row : config::not_pinned(station.profile)) {
      const auto held = survey_.read_held(position, row);
      if (!held && held.error().fault != Fault::SdoAbort && held.error().fault != Fault::SdoSizeMismatch)
        return tl::unexpected(held.error());
      if (held) held_.push_back({station.id, row.address, held->value});
      std::optional<std::int64_t> usual;
      for (int slot = 0; slot < std::max(station.profile.slots, 1) && !usual; ++slot)
        if (const auto* object =
                config::find_object(station.profile, config::first_slot(station.profile, row.address, slot)))
          usual = object->initial;
      const std::string of_manual = !usual                          ? "the manual has no default"
                                    : held && *usual == held->value ? "the manual's default"
                                                                    : fmt::format("the manual's default is {}", *usual);
      const std::string remark =
          held ? "not stated, " + of_manual : "not stated, and cannot be read: " + held.error().message;
      ordered_json one{{"name", row.name}, {"object", config::to_text(row.address)}, {"asked", nullptr}};
      one["held"] = held ? ordered_json(held->value) : ordered_json();
      one["default"] = usual ? ordered_json(*usual) : ordered_json();
      one["acts"] = acts_text(row.acts);
      one["remark"] = remark;
      rows.push_back(std::move(one));
      if (!json_)
        print_text("    {:<24} {:<9} asked {:>9}  holds {:>9}  {:<13} {}\n", row.name, config::to_text(row.address),
                   "-", held ? fmt::format("{}", held->value) : "-", acts_text(row.acts), remark);
    }
    return {};
  }

  const CommissionOptions& options_;
  const config::Machine& machine_;
  devices::Survey& survey_;
  bool json_, changed_ = false;
  std::function<Result<void>()> keep_;
  std::vector<Error> refused_;
  std::vector<Held> held_;  ///< as it was read last
};

/// The file of what was accepted is lost, and with it which stations wait for their supply: all of them may.
void take_all_for_waiting(config::Machine& machine) {
  for (config::Station& station : machine.stations) {
    station.accepted.reset();
    station.restart_pending =
        station.bus == config::BusKind::EtherCat &&
        std::ranges::count(station.profile.parameters, config::ActsAt::PowerUp, &config::Parameter::acts) > 0;
  }
}

struct Commissioned {
  ordered_json document;
  std::vector<Error> refused;  ///< what keeps stations from torque
};

Result<Commissioned> commission(BusAccess& bus, config::Machine& machine, const CommissionOptions& options, bool json,
                                const std::function<Result<void>()>& keep) {
  devices::Survey survey(bus.port(), bus.clock());
  const auto found = survey.scan();
  if (!found) return tl::unexpected(found.error());
  Commissioning one(options, machine, survey, json, keep);
  ordered_json rows = ordered_json::array();
  for (config::Station& station : machine.stations) {
    if (station.bus != config::BusKind::EtherCat || !(options.all || station.name == options.station)) continue;
    const auto at = static_cast<std::size_t>(station.position);
    if (at >= found->size())
      return fail(
          Fault::StationMissing,
          fmt::format("{} stations answer, the machine file has it at position {}", found->size(), station.position),
          "station " + station.name);
    auto row = one.visit(station, (*found)[at]);
    if (!row) {
      if (one.changed()) static_cast<void>(keep());  // what was found of the stations before it
      return tl::unexpected(row.error());
    }
    rows.push_back(std::move(*row));
  }
  const std::vector<Error> refused = one.refused(*found);
  const bool waiting = std::ranges::count(refused, Fault::RestartNeeded, &Error::fault) > 0;
  return Commissioned{
      ordered_json{
          {"stations", rows}, {"differing", one.differing()}, {"restart", waiting}, {"changed", one.changed()}},
      refused};
}

std::string no_such(const config::Machine& machine, const std::string& name) {
  std::vector<std::string_view> known;
  for (const config::Station& s : machine.stations) {
    if (s.bus == config::BusKind::EtherCat) known.emplace_back(s.name);
    if (s.name == name) return fmt::format("station '{}' is not on EtherCAT; only those are commissioned so far", name);
  }
  std::string axes;
  for (const config::Axis& axis : machine.axes) axes += (axes.empty() ? "" : ", ") + axis.name;
  return fmt::format("there is no station or axis '{}'; {}; axes: {}", name, did_you_mean(name, known), axes);
}

/// What keeps these stations from torque.
void show_refused(const std::vector<Error>& refused, bool wrote) {
  if (refused.empty()) return;
  print_text("No start gives these stations torque as they are:\n");
  for (const Error& e : refused) print_text("    {}\n", to_text(e));
  if (!wrote && std::ranges::count(refused, Fault::ParameterDiffers, &Error::fault) > 0)
    print_text("`--write` writes what may be written.\n");
}

}  // namespace

void add_commission(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand(
      "commission",
      "Stations: confirm what they are, compare and write their parameters; axes: see which way they move, "
      "measure their delay");
  auto options = std::make_shared<CommissionOptions>();
  verb->add_option("STATION", options->station, "Station of the machine file, or an axis");
  verb->add_flag("--all", options->all, "Every station");
  verb->add_flag("--accept", options->accept, "Take what was found for what belongs there, with the date");
  verb->add_flag("--write", options->write,
                 "Write parameters that differ, also those that act at power-up, and save them");
  verb->add_flag("--walk", options->walk,
                 "Each axis goes a short distance and back; you say which one moved, and which way");
  verb->add_option("--speed", options->speed, "Of an axis that is measured: \"50 mm/s\"");
  add_bus_interface(*verb, *options);
  verb->add_option("--state", options->state, kStateHelp);
  verb->footer(
      "Shows identity and parameters; changes nothing without --accept or --write. Nothing moves. With --walk each "
      "axis\n"
      "goes by at most 1 mm or 3 degrees and back in setup, not homed; you answer with what you have seen (\"X+\"), "
      "and only "
      "when\n"
      "all of it is as the machine file says, it is kept. With the name of an\n"
      "axis it homes the machine, moves that axis there and back, and measures how far it lags its command\n"
      "(response_delay). What was accepted and measured lies in the state folder. Not beside `gantry up` on the same "
      "interface: `gantry down` first.\n"
      "Example:  gantry commission --all --interface eth1");
  verb->callback([&context, options] {
    const auto stop_with = [&](const Error& error) { context.exit_code = show(error, context.json); };
    const bool alone =
        options->station.empty() && !options->all && !options->accept && !options->write && options->speed.empty();
    if (options->walk && !alone)
      return stop_with({Fault::Usage, "--walk is for all axes, and stands alone", "commission"});
    if (!options->walk && options->all != options->station.empty())
      return stop_with({Fault::Usage, "name one station, or write --all", "commission"});
    auto machine = load_machine(context);
    if (!machine) return;
    if (options->walk) return commission_walk(context, std::move(*machine), options->interface, options->state);
    const bool of_axis =
        !options->all && config::find_axis(*machine, options->station) != nullptr &&
        std::ranges::none_of(machine->stations, [&](const auto& s) { return s.name == options->station; });
    if (of_axis && (options->accept || options->write))
      return stop_with({Fault::Usage, "an axis is measured; --accept and --write are for stations", "commission"});
    if (of_axis)
      return commission_axis(context, std::move(*machine),
                             {options->station, options->interface, options->speed, options->state});
    if (!options->speed.empty())
      return stop_with({Fault::Usage, "--speed is for an axis that is measured", "commission"});
    if (!options->all && std::ranges::none_of(machine->stations, [&](const auto& s) {
          return s.name == options->station && s.bus == config::BusKind::EtherCat;
        }))
      return stop_with({Fault::Usage, no_such(*machine, options->station), machine->file});
    const auto folder = state_of(context, options->state);
    if (!folder) return;
    const std::string file = stations::accepted_file(*folder, options->interface.empty() ? "sim" : "ethercat");
    if (auto composed = run::compose_startup(*machine); !composed) return stop_with(composed.error());
    if (auto read = stations::read_accepted(file, *machine); !read) {
      if (!options->accept || !options->all) return stop_with(read.error());
      take_all_for_waiting(*machine);
      if (!context.json)
        print_text(
            "{} could not be read: walks are void, and stations whose values act at power-up wait for their supply to "
            "be "
            "switched off and on\n",
            file);
    }
    const auto access = BusAccess::open(context, *options);
    if (!access) return;
    const auto keep = [&]() -> Result<void> {
      if (auto made = desk::open_state_folder(*folder); !made) return tl::unexpected(made.error());
      return stations::write_accepted(file, *machine);
    };
    const auto done = commission(*access, *machine, *options, context.json, keep);
    if (!done) return stop_with(done.error());
    if (done->document["changed"].get<bool>())
      if (auto kept = keep(); !kept) return stop_with(kept.error());
    const bool ready = done->refused.empty();
    if (!ready) context.exit_code = kNotReady;
    if (context.json)
      show_document(ready ? "done" : "failed", done->document, context.exit_code, done->refused);
    else
      show_refused(done->refused, options->write);
  });
}

}  // namespace gantry::cli
