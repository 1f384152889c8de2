// gantry bus sdo read / write STATION INDEX[:SUB]: objects of a station, by its mailbox.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"
#include "app/cli/client.hpp"
#include "app/cli/terminal.hpp"
#include "app/desk/state_folder.hpp"
#include "app/stations/accepted.hpp"
#include "devices/ethercat/restart_note.hpp"
#include "devices/wire/bytes.hpp"

namespace gantry::cli {
namespace {

using devices::Bytes;

struct SdoOptions : BusOptions {
  std::string station, object, value, type, state;
  bool complete = false;
};

struct Type {
  std::string_view name;
  std::size_t bytes;
  bool is_signed;
};
constexpr Type kTypes[] = {{"u8", 1, false},     {"i8", 1, true},    {"u16", 2, false}, {"i16", 2, true},
                           {"u32", 4, false},    {"i32", 4, true},   {"u64", 8, false}, {"i64", 8, true},
                           {"string", 0, false}, {"bytes", 0, false}};

const Type* find_type(std::string_view name) {
  for (const auto& t : kTypes)
    if (t.name == name) return &t;
  return nullptr;
}

template <class T>
std::optional<T> number(std::string_view text, int base) {
  T value{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && problem == std::errc{} && end == text.data() + text.size() ? std::optional(value)
                                                                                     : std::nullopt;
}

/// "0x6064", "6064h", "6064", "1018:1", "0x1018:0x01": the index is hexadecimal in any case.
Result<config::ObjectAddress> parse_object(const std::string& text) {
  std::string index = text.substr(0, text.find(':')),
              sub = text.find(':') == std::string::npos ? "0" : text.substr(text.find(':') + 1);
  if (index.starts_with("0x") || index.starts_with("0X")) index.erase(0, 2);
  if (!index.empty() && (index.back() == 'h' || index.back() == 'H')) index.pop_back();
  const bool hex_sub = sub.starts_with("0x");
  const auto i = number<std::uint16_t>(index, 16);
  const auto s =
      number<std::uint8_t>(hex_sub ? std::string_view(sub).substr(2) : std::string_view(sub), hex_sub ? 16 : 10);
  if (!i || !s)
    return fail(Fault::Usage,
                fmt::format("'{}' is no object; write INDEX[:SUB], the index in hexadecimal: 0x1018:1", text));
  return config::ObjectAddress{*i, *s};
}

/// The type by --type, else as the machine file's profile has it; nullptr: it does not say.
const Type* type_of(const config::Station* station, config::ObjectAddress object, const std::string& asked) {
  if (!asked.empty()) return find_type(asked);
  if (station == nullptr) return nullptr;
  const auto& profile = station->profile;
  for (int slot = 0; slot < std::max(profile.slots, 1); ++slot)
    if (const auto* row = config::find_object(profile, config::first_slot(profile, object, slot))) {
      constexpr std::string_view kNames[] = {"u8", "i8", "u8", "i16", "u16", "i32", "u32", "string"};
      return find_type(kNames[static_cast<std::size_t>(row->type)]);
    }
  return nullptr;
}

/// The type that the station itself tells (SDO information, base types of ETG.1020), or by the length of what it holds:
/// then a number without sign, or with one where the value has it. nullptr: no number that we know.
const Type* type_by_station(devices::Survey& survey, int position, config::ObjectAddress object,
                            const std::string& value) {
  if (const auto entry = survey.describe_entry(position, object)) {
    struct Row {
      std::uint16_t data_type;
      std::string_view name;
    };
    constexpr Row kRows[] = {{0x01, "u8"},    {0x02, "i8"},  {0x03, "i16"}, {0x04, "i32"},
                             {0x05, "u8"},    {0x06, "u16"}, {0x07, "u32"}, {0x09, "string"},
                             {0x0A, "bytes"}, {0x15, "i64"}, {0x1B, "u64"}, {0x1E, "u8"},
                             {0x1F, "u16"},   {0x20, "u32"}, {0x30, "u8"},  {0x37, "u8"}};
    for (const auto& row : kRows)
      if (row.data_type == entry->data_type) return find_type(row.name);
  }
  const auto held = survey.read_object(position, object);
  if (!held) return nullptr;
  for (const auto& t : kTypes)
    if (t.bytes == held->size() && t.bytes != 0 && t.is_signed == value.starts_with('-')) return &t;
  return nullptr;
}

std::string hex(const Bytes& bytes) {
  std::string out;
  for (const auto b : bytes) out += fmt::format("{:02X}", std::to_integer<unsigned>(b));
  return out;
}

std::uint64_t little(const Bytes& bytes) {
  std::uint64_t v = 0;
  for (std::size_t i = 0; i < bytes.size() && i < 8; ++i) v |= std::to_integer<std::uint64_t>(bytes[i]) << 8 * i;
  return v;
}

nlohmann::ordered_json value_of(const Bytes& bytes, const Type* type) {
  if (type != nullptr && type->name == "string")
    return std::string(
        reinterpret_cast<const char*>(bytes.data()),
        std::min(bytes.size(), std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find('\0')));
  if ((type != nullptr && type->name == "bytes") || bytes.size() > 8 || bytes.empty()) return hex(bytes);
  const std::uint64_t raw = little(bytes);
  if (type == nullptr || !type->is_signed) return raw;
  const auto unused = static_cast<int>(64 - 8 * bytes.size());
  return static_cast<std::int64_t>(raw << unused) >> unused;
}

Result<Bytes> to_bytes(const std::string& text, const Type& type) {
  Bytes out;
  if (type.name == "string") {
    for (const char c : text) out.push_back(static_cast<std::byte>(c));
    return out;
  }
  if (type.name == "bytes") {
    for (std::size_t i = 0; i < text.size(); i += 2) {
      const auto b = number<std::uint8_t>(std::string_view(text).substr(i, 2), 16);
      if (!b || text.size() % 2 != 0)
        return fail(Fault::Usage, fmt::format("'{}' are no bytes; write two hexadecimal digits for each", text));
      out.push_back(static_cast<std::byte>(*b));
    }
    return out;
  }
  const bool minus = text.starts_with('-');
  std::string_view digits = std::string_view(text).substr(minus ? 1 : 0);
  const bool is_hex = digits.starts_with("0x");
  const auto magnitude = number<std::uint64_t>(is_hex ? digits.substr(2) : digits, is_hex ? 16 : 10);
  const std::uint64_t top = std::uint64_t{1} << (8 * type.bytes - 1);
  const std::uint64_t most = minus ? (type.is_signed ? top : 0) : (type.is_signed ? top - 1 : top - 1 + top);
  if (!magnitude) return fail(Fault::Usage, fmt::format("'{}' is no number", text));
  if (*magnitude > most) return fail(Fault::Usage, fmt::format("{} does not fit into {}", text, type.name));
  const std::uint64_t raw = minus ? 0 - *magnitude : *magnitude;
  for (std::size_t i = 0; i < type.bytes; ++i) out.push_back(static_cast<std::byte>(raw >> 8 * i & 0xFF));
  return out;
}

/// Errors name the station as successes do: with its name in the machine file.
Error named(Error error, const std::string& title) {
  if (error.where.starts_with("station ")) error.where = "station " + title;
  return error;
}

struct Target {
  int position = 0;
  std::string title;
  config::ObjectAddress object;
  const Type* type = nullptr;
  devices::FoundStation found;
};

Result<Target> aim(BusAccess& bus, devices::Survey& survey, const SdoOptions& options) {
  const auto object = parse_object(options.object);
  if (!object) return tl::unexpected(object.error());
  const auto stations = survey.scan();
  if (!stations) return tl::unexpected(stations.error());
  const auto position = bus.find(*stations, options.station);
  if (!position) return tl::unexpected(position.error());
  const auto& found = (*stations)[static_cast<std::size_t>(*position)];
  return Target{*position, title(bus, found), *object, type_of(bus.configured(found), *object, options.type), found};
}

void print(const Context& context, const Target& t, const Bytes& bytes) {
  const auto value = value_of(bytes, t.type);
  if (context.json) {
    return show_document("done",
                         {{"station", t.position},
                          {"index", t.object.index},
                          {"sub", t.object.sub},
                          {"type", t.type != nullptr ? nlohmann::ordered_json(t.type->name) : nlohmann::ordered_json()},
                          {"bytes", hex(bytes)},
                          {"value", value}});
  }
  const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  print_text("station {}  {:04X}h:{} = {}", t.title, t.object.index, t.object.sub, text);
  if (value.is_number()) print_text("  ({:#0{}x})", little(bytes), 2 * bytes.size() + 2);
  print_text("\n");
}

Result<void> read(Context& context, BusAccess& bus, const SdoOptions& options) {
  devices::Survey survey(bus.port(), bus.clock());
  const auto target = aim(bus, survey, options);
  if (!target) return tl::unexpected(target.error());
  const auto access = options.complete ? devices::SdoAccess::Complete : devices::SdoAccess::Single;
  const auto bytes = survey.read_object(target->position, target->object, access);
  if (!bytes) return tl::unexpected(named(bytes.error(), target->title));
  auto shown = *target;
  if (options.complete && options.type.empty()) shown.type = find_type("bytes");
  if (shown.type != nullptr && shown.type->bytes != 0 && shown.type->bytes != bytes->size()) {
    if (!options.type.empty())
      return fail(Fault::SdoSizeMismatch,
                  fmt::format("{:04X}h:{} has {} bytes, {} has {}", target->object.index, target->object.sub,
                              bytes->size(), options.type, shown.type->bytes),
                  "station " + target->title);
    shown.type = nullptr;  // the profile has it otherwise: shown as it came
  }
  print(context, shown, *bytes);
  return {};
}

/// Whether it is a parameter of the station that acts at power-up.
bool waits_for_supply(const config::StationProfile& profile, config::ObjectAddress object, bool complete) {
  for (int slot = 0; slot < std::max(profile.slots, 1); ++slot)
    for (const config::Parameter& p : profile.parameters) {
      const auto its = config::in_slot(profile, p.address, slot);
      if (p.acts == config::ActsAt::PowerUp && its.index == object.index && (complete || its.sub == object.sub))
        return true;
    }
  return false;
}

/// What the state folder says of a station of the machine file that gets a value which acts at power-up, whatever it
/// was found to be. Stations of the virtual segment in this process end with it.
class Waiting {
 public:
  Waiting(Context& context, const BusAccess& bus, const SdoOptions& options)
      : context_(context), options_(options), machine_(bus.machine()) {}

  /// `write`, under a note where the value acts at power-up.
  Result<void> under(devices::Survey& survey, const devices::FoundStation& found, config::ObjectAddress object,
                     const std::function<Result<void>()>& write) {
    const auto its = std::ranges::find_if(machine_.stations, [&](const config::Station& s) {
      return s.bus == config::BusKind::EtherCat && s.position == found.record.position &&
             waits_for_supply(s.profile, object, options_.complete);
    });
    if (options_.interface.empty() || its == machine_.stations.end()) return write();
    const auto folder = state_of(context_, options_.state);
    if (!folder) return fail(Fault::Usage, "without a state folder nobody would know that it acts at power-up");
    if (auto made = desk::open_state_folder(*folder); !made) return tl::unexpected(made.error());
    const std::string file = stations::accepted_file(*folder, "ethercat");
    if (auto read = stations::read_accepted(file, machine_); !read) return read;
    if (found.record.since_power_up) its->restart_pending = false;  // what it held before acts by now
    if (auto ok = survey.forget_restart(its->position); !ok) return ok;
    devices::RestartNote note(*its, [&] { return stations::write_accepted(file, machine_); });
    const auto written = note.under(write);
    needed_ = note.needed();
    if (auto kept = note.settle(); !kept) return kept;
    return written;
  }
  [[nodiscard]] bool needed() const { return needed_; }

 private:
  Context& context_;
  const SdoOptions& options_;
  config::Machine machine_;
  bool needed_ = false;
};

Result<void> write(Context& context, BusAccess& bus, const SdoOptions& options) {
  devices::Survey survey(bus.port(), bus.clock());
  auto target = aim(bus, survey, options);
  if (!target) return tl::unexpected(target.error());
  const auto access = options.complete ? devices::SdoAccess::Complete : devices::SdoAccess::Single;
  if (options.complete && options.type.empty()) target->type = find_type("bytes");
  if (target->type == nullptr) target->type = type_by_station(survey, target->position, target->object, options.value);
  if (target->type == nullptr)
    return fail(Fault::Usage, fmt::format("the type of {:04X}h:{} is not known here; name it with --type",
                                          target->object.index, target->object.sub));
  const auto bytes = to_bytes(options.value, *target->type);
  if (!bytes) return tl::unexpected(bytes.error());
  Waiting waiting(context, bus, options);
  const auto written = waiting.under(survey, target->found, target->object, [&] {
    return survey.write_object(target->position, target->object, *bytes, access);
  });
  if (!written) return tl::unexpected(named(written.error(), target->title));
  const auto back = survey.read_object(target->position, target->object, access);
  print(context, *target, back ? *back : *bytes);
  if (waiting.needed() && !context.json)
    print_text("It acts at power-up: the axes stay without torque until this station's supply was off and on.\n");
  return {};
}

template <class Action>
void add(CLI::App& sdo, Context& context, const char* name, const char* help, bool writes, Action action) {
  auto* verb = sdo.add_subcommand(name, help);
  auto options = std::make_shared<SdoOptions>();
  verb->add_option("STATION", options->station, "Position, alias:NNN, or a name of the machine file")->required();
  verb->add_option("INDEX[:SUB]", options->object, "The object, its index in hexadecimal: 0x6064, 1018:1")->required();
  if (writes)
    verb->add_option("VALUE", options->value, "A number (also 0x...), text, or bytes as hexadecimal digits")
        ->required();
  std::string types;
  for (const auto& t : kTypes) types += (types.empty() ? "" : ", ") + std::string(t.name);
  verb->add_option("--type", options->type, types + "; default: as the machine file's profile or the station has it")
      ->check([types](const std::string& t) { return find_type(t) != nullptr ? std::string() : "one of " + types; });
  verb->add_flag("--complete", options->complete,
                 writes ? "Complete access: VALUE is all sub-indices in one, sub-index 0 as two bytes, in hexadecimal"
                        : "Complete access: all sub-indices in one");
  add_bus_interface(*verb, *options);
  if (writes) verb->add_option("--state", options->state, kStateHelp);
  verb->footer(
      writes
          ? "The value that the station then has is read back and shown. 2xxxh objects of some drives wear an EEPROM.\n"
            "Example:  gantry bus sdo write x 0x6081 50000 --interface eth1"
          : "Example:  gantry bus sdo read x 0x6064\n"
            "          gantry bus sdo read 0 1018:1 --type u32 --interface eth1");
  verb->callback([&context, options, action] {
    const auto bus = BusAccess::open(context, *options);
    if (!bus) return;
    if (auto done = action(context, *bus, *options); !done) context.exit_code = show(done.error(), context.json);
  });
}

}  // namespace

void add_bus_sdo(CLI::App& bus, Context& context) {
  auto* sdo = bus.add_subcommand("sdo", "Reads and writes objects of a station (CoE)");
  sdo->require_subcommand(1);
  add(*sdo, context, "read", "Reads an object", false, read);
  add(*sdo, context, "write", "Writes an object and reads it back", true, write);
}

}  // namespace gantry::cli
