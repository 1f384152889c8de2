#include "config/drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "config/check_profile.hpp"
#include "config/formats.hpp"
#include "core/sha256.hpp"

namespace gantry::config {
namespace {

constexpr Range kU8{0, 0xFF}, kU16{0, 0xFFFF}, kU32{0, 0xFFFFFFFFu}, kI64{-9e15, 9e15};

Choices<ObjectType> object_types() {
  return {{"bool", ObjectType::Bool}, {"i8", ObjectType::I8},        {"u8", ObjectType::U8},
          {"i16", ObjectType::I16},   {"u16", ObjectType::U16},      {"i32", ObjectType::I32},
          {"u32", ObjectType::U32},   {"string", ObjectType::String}};
}

/// r, w or rw into the two flags of an object.
Field<ObjectRow> access() {
  ValueShape shape{ValueShape::Kind::Choice, {}, kAny, {"r", "w", "rw"}, {}, {}};
  return {{"access", kRequired, "what a master may do with it", shape},
          [shape](const Node& node, ObjectRow& to, Mistakes& mistakes) {
            const auto v = read_choice(node, shape, mistakes);
            if (!v) return;
            to.readable = *v != 1;
            to.writable = *v != 0;
          }};
}

const Fields<ObjectRow>& object_fields() {
  static const Fields<ObjectRow> kFields{
      address("object", &ObjectRow::address, kRequired, "index:sub of the first axis"),
      text("name", &ObjectRow::name, kRequired, "what the manual calls it"),
      choice("type", &ObjectRow::type, object_types(), kRequired, "its data type"),
      access(),
      flag("pdo", &ObjectRow::mappable, kOptional, "may stand in a PDO"),
      integer("initial", &ObjectRow::initial, kI64, kOptional, "value after power-up"),
      integer("min", &ObjectRow::min, kI64, kOptional, "least value"),
      integer("max", &ObjectRow::max, kI64, kOptional, "largest value"),
      text("unit", &ObjectRow::unit, kOptional, "the vendor's unit"),
      text("section", &ObjectRow::section, kOptional, "where the manual says so"),
      flag("assumed", &ObjectRow::assumed, kOptional, "no manual states it"),
  };
  return kFields;
}

const Fields<PdoRow>& pdo_fields() {
  static const Fields<PdoRow> kFields{
      integer("pdo", &PdoRow::index, kU16, kRequired, "its mapping object, 0x1600 or 0x1A00 and up"),
      integer("slot", &PdoRow::slot, {0, 7}, kOptional, "axis of the station that it serves"),
      {{"entries",
        kRequired,
        "what is mapped, in order; a slot's stride is in the address",
        {ValueShape::Kind::List, {}, {1, 32}, {}, {}, {{ValueShape::Kind::Address, {}, kAny, {}, {}, {}}}}},
       [](const Node& node, PdoRow& to, Mistakes& mistakes) {
         if (!expect_list(node, {1, 32}, mistakes)) return;
         for (const Node& item : node.items)
           if (const auto a = read_address(item, mistakes)) to.entries.push_back({{a->first, a->second}, 0});
       }},
  };
  return kFields;
}

const Fields<SyncManagerRow>& sync_manager_fields() {
  static const Fields<SyncManagerRow> kFields{
      choice("kind", &SyncManagerRow::kind,
             Choices<SyncManagerKind>{{"mailbox_out", SyncManagerKind::MailboxOut},
                                      {"mailbox_in", SyncManagerKind::MailboxIn},
                                      {"outputs", SyncManagerKind::ProcessOut},
                                      {"inputs", SyncManagerKind::ProcessIn}},
             kRequired, "what goes through it"),
      integer("start", &SyncManagerRow::start, kU16, kRequired, "physical address"),
      integer("length", &SyncManagerRow::length, {0, 1486}, kOptional,
              "bytes of a mailbox; of process data it is computed"),
  };
  return kFields;
}

const Fields<Parameter>& parameter_fields() {
  static const Fields<Parameter> kFields{
      name_of("name", &Parameter::name, kRequired, "by which a machine file states another value"),
      address("object", &Parameter::address, kRequired, "index:sub of the first axis; every axis has it"),
      choice("type", &Parameter::type, object_types(), kRequired, "its data type"),
      integer("value", &Parameter::value, kI64, kOptional, "what it shall hold; none: what the machine file states"),
      flag("must_be_stated", &Parameter::must_be_stated, kOptional, "by the machine file: a wrong one burns a motor"),
      text("unit", &Parameter::unit, kOptional, "in which a machine file writes it; none: a whole number"),
      number("per_unit", &Parameter::per_unit, Dimension::None, {1e-6, 1e9}, kOptional,
             "the object's value of one unit"),
      choice("rule", &Parameter::rule,
             Choices<ParameterRule>{{"write", ParameterRule::Write}, {"must_equal", ParameterRule::MustEqual}},
             kOptional, "must_equal: compared, never written"),
      choice("acts", &Parameter::acts,
             Choices<ActsAt>{
                 {"at_once", ActsAt::Once}, {"at_standstill", ActsAt::Standstill}, {"at_power_up", ActsAt::PowerUp}},
             kOptional, "at_power_up: start-up compares, `gantry commission` writes"),
      flag("assumed", &Parameter::assumed, kOptional, "no manual states it"),
      {{"means", kOptional, "facts of `drive` that the value stands for, where it is a code",
        object_shape(meaning_fields())},
       [](const Node& node, Parameter&, Mistakes& mistakes) {  // check_profile() compares them
         Meaning means;
         read_object(node, meaning_fields(), means, node.location, mistakes);
       }},
      text("why", &Parameter::why, kRequired, "what it is for"),
  };
  return kFields;
}

/// A list of values from 0 to 31, kept as a set: bit n for value n.
Field<DriveFacts> bits_listed(std::string key, std::uint32_t DriveFacts::*member, std::string doc) {
  const ValueShape value{ValueShape::Kind::Integer, {}, {0, 31}, {}, {}, {}};
  return {{std::move(key), kOptional, std::move(doc), {ValueShape::Kind::List, {}, {0, 32}, {}, {}, {value}}},
          [member, value](const Node& node, DriveFacts& to, Mistakes& mistakes) {
            if (!expect_list(node, {0, 32}, mistakes)) return;
            for (const Node& item : node.items)
              if (const auto v = read_integer(item, value, mistakes)) to.*member |= 1u << *v;
          }};
}

const Fields<DriveErrorRow>& error_fields() {
  static const Fields<DriveErrorRow> kFields{
      integer("code", &DriveErrorRow::code, kU32, kRequired, "as it stands in 603Fh"),
      choice("kind", &DriveErrorRow::kind,
             Choices<DriveErrorKind>{{"fault", DriveErrorKind::Fault},
                                     {"warning", DriveErrorKind::Warning},
                                     {"emergency_input", DriveErrorKind::EmergencyInput},
                                     {"limit", DriveErrorKind::Limit},
                                     {"undervoltage", DriveErrorKind::Undervoltage},
                                     {"power_cycle", DriveErrorKind::PowerCycle}},
             kRequired, "how it is met"),
      text("text", &DriveErrorRow::text, kRequired, "what the drive means"),
      text("remedy", &DriveErrorRow::remedy, kRequired, "what to do"),
      text("section", &DriveErrorRow::section, kOptional, "where the manual says so; absent: assumed"),
  };
  return kFields;
}

const Fields<AlarmBitRow>& alarm_bit_fields() {
  static const Fields<AlarmBitRow> kFields{
      address("object", &AlarmBitRow::address, kRequired, "the alarm word"),
      integer("bit", &AlarmBitRow::bit, {0, 31}, kRequired, "its bit, 0 the lowest"),
      integer("code", &AlarmBitRow::code, kU32, kOptional, "603Fh that stands beside it"),
      text("text", &AlarmBitRow::text, kRequired, "what the drive means"),
      text("remedy", &AlarmBitRow::remedy, kRequired, "what to do"),
      text("section", &AlarmBitRow::section, kOptional, "where the manual says so; absent: assumed"),
  };
  return kFields;
}

const Fields<StatuswordRow>& statusword_fields() {
  static const Fields<StatuswordRow> kFields{
      integer("mode", &StatuswordRow::mode, {-128, 127}, kRequired, "value of 6060h"),
      integer("ready", &StatuswordRow::ready, kU16, kRequired, "Ready to switch on"),
      integer("switched_on", &StatuswordRow::switched_on, kU16, kRequired, "Switched on"),
      integer("enabled", &StatuswordRow::enabled, kU16, kRequired, "Operation enabled, at rest"),
      integer("running", &StatuswordRow::running, kU16, kRequired, "moving"),
      integer("reached", &StatuswordRow::reached, kU16, kRequired, "move or homing done"),
      integer("fault", &StatuswordRow::fault, kU16, kRequired, "Fault"),
  };
  return kFields;
}

const Fields<Identity>& identity_fields() {
  static const Fields<Identity> kFields{
      integer("vendor", &Identity::vendor, kU32, kRequired, "1018h:1"),
      integer("product", &Identity::product, kU32, kRequired, "1018h:2"),
      integer("revision", &Identity::revision, kU32, kOptional, "1018h:3"),
      flag("assumed", &Identity::assumed, kOptional, "no manual states it; it asks instead of refusing"),
  };
  return kFields;
}

struct Inputs {
  std::int8_t negative_limit = -1, positive_limit = -1, home = -1;
};
const Fields<Inputs>& input_fields() {
  static const Fields<Inputs> kFields{
      integer("negative_limit", &Inputs::negative_limit, {0, 31}, kOptional, "bit of 60FDh"),
      integer("positive_limit", &Inputs::positive_limit, {0, 31}, kOptional, "bit of 60FDh"),
      integer("home", &Inputs::home, {0, 31}, kOptional, "bit of 60FDh"),
  };
  return kFields;
}

struct StatusBits {
  std::int8_t follows = -1, limit = -1;
};
const Fields<StatusBits>& status_bit_fields() {
  static const Fields<StatusBits> kFields{
      integer("follows", &StatusBits::follows, {8, 15}, kOptional, "of 6041h in CSP: the drive follows its targets"),
      integer("limit", &StatusBits::limit, {8, 15}, kOptional, "of 6041h: a limit is active"),
  };
  return kFields;
}

const Fields<ProbeInput>& probe_input_fields() {
  static const Fields<ProbeInput> kFields{
      text("parameter", &ProbeInput::parameter, kRequired, "of `parameters`: the function of that input"),
      integer("value", &ProbeInput::value, {-2147483648.0, 2147483647.0}, kRequired, "with which it is probe 1"),
  };
  return kFields;
}

const Fields<DriveFacts>& drive_fields() {
  static const Fields<DriveFacts> kFields{
      flag("closed_loop", &DriveFacts::closed_loop, kRequired, "false: 6064h is the command, no measurement"),
      integers("modes", &DriveFacts::modes, {-128, 127}, kRequired, "values of 6060h that work"),
      integers("cycle_times_us", &DriveFacts::cycle_times_us, {1, 1e6}, kOptional, "SYNC cycles that the manual lists"),
      integers("homing_methods", &DriveFacts::homing_methods, {0, 127}, kRequired, "values of 6098h that work"),
      integer("counts_per_rev", &DriveFacts::counts_per_rev, {100, 1e9}, kRequired,
              "pulses of one revolution as started up"),
      number("velocity_counts_s", &DriveFacts::velocity_counts_s, Dimension::None, {1e-6, 1e9}, kOptional,
             "counts/s in one unit of 6081h and 6099h"),
      number("acceleration_counts_s2", &DriveFacts::acceleration_counts_s2, Dimension::None, {1e-6, 1e9}, kOptional,
             "counts/s^2 in one unit of 6083h and 609Ah"),
      bits_listed("quick_stop_options", &DriveFacts::quick_stop_options, "values of 605Ah that the manual documents"),
      bits_listed("quick_stop_coasts", &DriveFacts::quick_stop_coasts,
                  "those of them that take the torque and brake nothing"),
      {{"inputs", kOptional, "bits of 60FDh", object_shape(input_fields())},
       [](const Node& node, DriveFacts& to, Mistakes& mistakes) {
         Inputs in;
         read_object(node, input_fields(), in, node.location, mistakes);
         to.input_neg_limit = in.negative_limit;
         to.input_pos_limit = in.positive_limit;
         to.input_home = in.home;
       }},
      {{"status_bits", kOptional, "bits of 6041h that the manual states; those left out are not believed",
        object_shape(status_bit_fields())},
       [](const Node& node, DriveFacts& to, Mistakes& mistakes) {
         StatusBits bits;
         read_object(node, status_bit_fields(), bits, node.location, mistakes);
         to.status_follows = bits.follows;
         to.status_limit = bits.limit;
       }},
      integer("probe_level_bit", &DriveFacts::probe_level_bit, {0, 15}, kOptional,
              "bit of 60B9h that is probe 1's level"),
      flag("probe_rearm_needs_zero", &DriveFacts::probe_rearm_needs_zero, kOptional,
           "60B8h = 0 before it is armed again"),
      {{"probe_input", kOptional, "what makes an input that of probe 1", object_shape(probe_input_fields())},
       [](const Node& node, DriveFacts& to, Mistakes& mistakes) {
         read_object(node, probe_input_fields(), to.probe_input, node.location, mistakes);
       }},
      flag("probe_takes_emergency_stop", &DriveFacts::probe_takes_emergency_stop, kOptional,
           "probe 1 has no other input than that of the emergency stop"),
      flag("quick_stop_needs_toggle", &DriveFacts::quick_stop_needs_toggle, kOptional,
           "the controlword must be switched back after a quick stop"),
      integer("deviation_code", &DriveFacts::deviation_code, kU16, kOptional, "603Fh when the motor cannot follow"),
      integer("bus_loss_code", &DriveFacts::bus_loss_code, kU16, kOptional, "603Fh when outputs stop while enabled"),
      integer("homing_code", &DriveFacts::homing_code, kU16, kOptional, "603Fh when homing fails"),
      list("statuswords", &DriveFacts::statuswords, statusword_fields(), {0, 20}, kRequired, "6041h in each mode"),
      list("errors", &DriveFacts::errors, error_fields(), {0, 200}, kRequired, "codes of 603Fh"),
      list("alarm_bits", &DriveFacts::alarm_bits, alarm_bit_fields(), {0, 200}, kOptional,
           "bits of the vendor's alarm words, for `gantry explain`"),
  };
  return kFields;
}

struct TerminalRow {
  std::string name;
  Location location;
  At<int> in, out;
  int bits = 1;
  bool unread = false;  ///< something of it is a mistake
};
const Fields<TerminalRow>& terminal_fields() {
  static const Fields<TerminalRow> kFields{
      integer("in", &TerminalRow::in, {0, 2047}, kOptional, "an input: its first bit of what the station sends"),
      integer("out", &TerminalRow::out, {0, 2047}, kOptional, "an output: its first bit of what goes to the station"),
      integer("bits", &TerminalRow::bits, {1, 64}, kOptional, "width of its value"),
  };
  return kFields;
}

void read_terminals(const Node& node, StationProfile& to, Mistakes& mistakes) {
  struct Rows {
    std::vector<TerminalRow> all;
  } rows;
  named("terminals", &Rows::all, terminal_fields(), {0, 256}, kOptional, "").read(node, rows, mistakes);
  for (const TerminalRow& row : rows.all) {
    if (!row.unread && row.in.given() == row.out.given())
      mistakes.add(Fault::BadValue, fmt::format("terminal '{}' needs exactly one of: in, out", row.name), row.location);
    to.terminals.push_back({row.name, row.out.given(), row.out.given() ? row.out.value : row.in.value, row.bits});
  }
}

const Fields<StationProfile>& profile_fields() {
  static const Fields<StationProfile> kFields{
      format_version<StationProfile>(1),
      text("title", &StationProfile::title, kRequired, "maker and type"),
      text("manual", &StationProfile::manual, kRequired, "what the sections below refer to"),
      choice("bus", &StationProfile::bus,
             Choices<BusKind>{{"ethercat", BusKind::EtherCat}, {"canopen", BusKind::CanOpen}}, kRequired, "its bus"),
      object("identity", &StationProfile::identity, identity_fields(), kRequired, "identity object 1018h"),
      integer("slots", &StationProfile::slots, {0, 8}, kRequired, "axes of the station; 0: no drive"),
      integer("slot_stride", &StationProfile::slot_stride, kU16, kOptional, "added to 6xxxh a slot"),
      integer("slot_stride_vendor", &StationProfile::slot_stride_vendor, kU16, kOptional, "added to 2xxxh a slot"),
      flag("dc", &StationProfile::dc, kOptional, "supports SYNC0"),
      integer("clock_bits", &StationProfile::clock_bits, {32, 64}, kOptional, "width of its clock: 32 or 64"),
      {{"watchdog",
        kOptional,
        "process-data watchdog that we set",
        {ValueShape::Kind::Number, {Dimension::Time}, {0.001, 60}, {}, {}, {}}},
       [](const Node& node, StationProfile& to, Mistakes& mistakes) {
         if (const auto v =
                 read_quantity(node, {ValueShape::Kind::Number, {Dimension::Time}, {0.001, 60}, {}, {}, {}}, mistakes))
           to.watchdog_ms = static_cast<std::uint16_t>(std::lround(v->value * 1e3));
       }},
      list("sync_managers", &StationProfile::sync_managers, sync_manager_fields(), {0, 8}, kOptional, "in their order"),
      integer("max_pdo_entries", &StationProfile::max_pdo_entries, {0, 254}, kOptional, "objects a PDO; 0: not stated"),
      integer("max_pdo_bytes", &StationProfile::max_pdo_bytes, {1, 1486}, kOptional, "bytes a PDO"),
      flag("pdo_fixed", &StationProfile::pdo_fixed, kOptional, "the mapping cannot be written"),
      list("rx_pdos", &StationProfile::rx_pdos, pdo_fields(), {0, 16}, kRequired, "to the station"),
      list("tx_pdos", &StationProfile::tx_pdos, pdo_fields(), {0, 16}, kRequired, "from the station"),
      {{"terminals",
        kOptional,
        "names that are printed on the station, for `outputs` and `inputs` of a machine file",
        {ValueShape::Kind::Named, {}, {0, 256}, {}, {}, {object_shape(terminal_fields())}}},
       read_terminals},
      list("objects", &StationProfile::objects, object_fields(), {1, 1000}, kRequired, "objects that we use or show"),
      list("parameters", &StationProfile::parameters, parameter_fields(), {0, 200}, kOptional,
           "read, compared, written and read back in PRE_OP, in order"),
      choice("storage", &StationProfile::storage,
             Choices<Storage>{{"none", Storage::None}, {"at_once", Storage::AtOnce}, {"on_save", Storage::OnSave}},
             kOptional, "how 2xxxh objects outlive the supply: each write, or \"save\" to 1010h"),
      object("drive", &StationProfile::drive, drive_fields(), kOptional, "absent: the station is no drive"),
      texts("assumptions", &StationProfile::assumptions, kOptional, "sentences that `check` shows"),
  };
  return kFields;
}

/// Widths of what is mapped come from the object table; a PDO over its limits or of unknown objects is a mistake.
void resolve_pdos(const StationProfile& profile, std::vector<PdoRow>& pdos, const Node& rows, Mistakes& mistakes) {
  for (std::size_t i = 0; i < pdos.size(); ++i) {
    PdoRow& pdo = pdos[i];
    const Location location = rows.items[i].location;
    int total = 0;
    for (PdoEntry& entry : pdo.entries) {
      const ObjectRow* object = find_object(profile, first_slot(profile, entry.address, pdo.slot));
      if (!object || !object->mappable || bits(object->type) == 0) {
        mistakes.add(Fault::UnknownReference,
                     fmt::format("PDO 0x{:04X} maps 0x{:04X}:{}, which is no mappable row of `objects`", pdo.index,
                                 entry.address.index, entry.address.sub),
                     location);
        continue;
      }
      entry.bit_length = static_cast<std::uint8_t>(bits(object->type));
      total += entry.bit_length;
    }
    const auto count = static_cast<int>(pdo.entries.size());
    if ((profile.max_pdo_entries > 0 && count > profile.max_pdo_entries) || total > 8 * profile.max_pdo_bytes)
      mistakes.add(Fault::Inconsistent,
                   fmt::format("PDO 0x{:04X} maps {} objects of {} bits; its limits are {} objects and {} bytes",
                               pdo.index, count, total, profile.max_pdo_entries, profile.max_pdo_bytes),
                   location);
  }
}

/// What a drive needs in every cycle or by SDO, where the profile has it and maps it nowhere: bring-up asks for it, and
/// where the station does not map it either SDO does it.
struct Wanted {
  ObjectAddress object;
  bool output;
  const char* name;
  const char* else_;  ///< what comes of it where the station does not map it
};
constexpr std::array kWanted{
    Wanted{{0x60FD, 0}, false, "digital inputs", "limit and home switches are read by SDO and seen late"},
    Wanted{{0x6060, 0}, true, "mode", "it is set by SDO, and a change of it takes longer"}};

void ask_for(StationProfile& profile, const Wanted& wanted) {
  const ObjectRow* object = find_object(profile, wanted.object);
  if (!profile.drive || profile.bus != BusKind::EtherCat || object == nullptr) return;
  if (wanted.output ? !object->writable : profile.pdo_fixed || !object->readable) return;
  std::vector<PdoRow>& pdos = wanted.output ? profile.rx_pdos : profile.tx_pdos;
  for (int slot = 0; slot < profile.slots; ++slot) {
    const ObjectAddress address = in_slot(profile, wanted.object, slot);
    const auto maps = [&](const PdoRow& pdo) {
      return std::ranges::count(pdo.entries, address, &PdoEntry::address) != 0;
    };
    const auto its = std::ranges::find_if(pdos, [&](const PdoRow& pdo) { return pdo.slot == slot; });
    if (its == pdos.end() || std::ranges::any_of(pdos, maps)) continue;
    its->entries.push_back({address, static_cast<std::uint8_t>(bits(object->type))});
    profile.assumptions.push_back(fmt::format(
        "{} ({} of axis {}) is in no PDO of the profile: the station is asked to map it, and where it does not, {}",
        to_text(address), wanted.name, slot, wanted.else_));
  }
}

/// A terminal that reaches beyond the process image is a mistake.
void check_terminals(const StationProfile& profile, const Node& rows, Mistakes& mistakes) {
  for (const Terminal& t : profile.terminals) {
    const int width = image_bits(profile, t.output);
    if (t.bit + t.bits <= width) continue;
    const auto key = std::find_if(rows.keys.begin(), rows.keys.end(), [&](const auto& k) { return k.text == t.name; });
    mistakes.add(Fault::OutOfRange,
                 fmt::format("terminal '{}' ends at bit {}; the station's {} have {} bits", t.name, t.bit + t.bits - 1,
                             t.output ? "outputs" : "inputs", width),
                 key->location);
  }
}

}  // namespace

std::string to_text(ObjectAddress a) {
  return a.sub == 0 ? fmt::format("{:04X}h", a.index) : fmt::format("{:04X}h:{}", a.index, a.sub);
}

int bits(ObjectType type) {
  switch (type) {
    case ObjectType::Bool: return 1;
    case ObjectType::I8:
    case ObjectType::U8: return 8;
    case ObjectType::I16:
    case ObjectType::U16: return 16;
    case ObjectType::I32:
    case ObjectType::U32: return 32;
    case ObjectType::String: return 0;
  }
  return 0;
}

namespace {
int stride(const StationProfile& profile, std::uint16_t index) {
  if (index >= 0x6000) return profile.slot_stride;
  return index >= 0x2000 ? profile.slot_stride_vendor : 0;
}
}  // namespace

ObjectAddress in_slot(const StationProfile& profile, ObjectAddress address, int slot) {
  address.index = static_cast<std::uint16_t>(address.index + slot * stride(profile, address.index));
  return address;
}
ObjectAddress first_slot(const StationProfile& profile, ObjectAddress address, int slot) {
  address.index = static_cast<std::uint16_t>(address.index - slot * stride(profile, address.index));
  return address;
}

const ObjectRow* find_object(const StationProfile& profile, ObjectAddress address) {
  for (const ObjectRow& row : profile.objects)
    if (row.address == address) return &row;
  return nullptr;
}

int image_bits(const StationProfile& profile, bool outputs) {
  int bits = 0;
  for (const PdoRow& pdo : outputs ? profile.rx_pdos : profile.tx_pdos)
    for (const PdoEntry& entry : pdo.entries) bits += entry.bit_length;
  return bits;
}

const std::vector<FieldShape>& profile_format() {
  static const std::vector<FieldShape> kFormat = object_shape(profile_fields()).fields;
  return kFormat;
}

std::string profiles_beside(const std::string& machine_folder, const char* kind) {
  return (std::filesystem::path(machine_folder) / ".." / kind).lexically_normal().string();
}

Checked<StationProfile> load_profile(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return tl::unexpected(std::vector{text.error()});
  Mistakes mistakes(path);
  std::optional<Node> root;
  auto read = read_fields(*text, profile_fields(), mistakes, "the profile of a station", &root);
  if (!read || !mistakes.none()) return tl::unexpected(mistakes.errors());
  StationProfile profile = std::move(*read);
  profile.name = std::filesystem::path(path).stem().string();
  resolve_pdos(profile, profile.rx_pdos, *root->find("rx_pdos"), mistakes);
  resolve_pdos(profile, profile.tx_pdos, *root->find("tx_pdos"), mistakes);
  if (const Node* rows = root->find("terminals")) check_terminals(profile, *rows, mistakes);
  if (mistakes.none()) check_profile(profile, *root, mistakes);
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());
  for (const Wanted& wanted : kWanted) ask_for(profile, wanted);
  profile.file = path;
  profile.sha256 = sha256_hex(*text);
  return profile;
}

}  // namespace gantry::config
