#include "config/profile_rules.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <fmt/format.h>
#include <string>
#include <utility>

#include "config/standard_objects.hpp"

namespace gantry::config {
namespace {

/// What a rule looks at, and where it tells.
struct Look {
  const StationProfile& p;
  const Node& root;
  Mistakes& mistakes;

  void say(std::string_view why, Location location) const { mistakes.add(Fault::Inconsistent, why, location); }
  [[nodiscard]] const Node& row(std::string_view key, std::size_t i) const { return root.find(key)->items[i]; }
  [[nodiscard]] Location at(std::string_view list, std::size_t i, std::string_view key) const {
    return location_of_key(row(list, i), key);
  }
  [[nodiscard]] Location of_drive(std::string_view key) const { return location_of_key(*root.find("drive"), key); }
  [[nodiscard]] Location in_drive(std::string_view list, std::size_t i, std::string_view key) const {
    return location_of_key(root.find("drive")->find(list)->items[i], key);
  }
  [[nodiscard]] Location of(std::string_view key) const { return location_of_key(root, key); }
};
/// Rows of a list that say who they are: each that says the same as an earlier one, with that one's number.
template <class Rows, class Same, class Say>
void each_twin(const Rows& rows, Same same, Say say) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (same(rows[k], rows[i])) {
        say(i, k);
        break;
      }
}

// ---- objects ----

void no_object_twice(const Look& l) {
  const auto same = [&](const ObjectRow& a, const ObjectRow& b) {
    for (int slot = 0; slot < std::max(l.p.slots, 1); ++slot)
      if (in_slot(l.p, a.address, slot) == b.address || in_slot(l.p, b.address, slot) == a.address) return true;
    return false;
  };
  each_twin(l.p.objects, same, [&](std::size_t i, std::size_t k) {
    if (l.p.objects[i].address < l.p.objects[k].address) std::swap(i, k);  // the first axis has the lower one
    const ObjectRow &one = l.p.objects[k], &other = l.p.objects[i];
    l.say(one.address == other.address
              ? fmt::format("{} is in `objects` already, as '{}'; leave one of the two rows out", to_text(one.address),
                            one.name)
              : fmt::format("{} is {} of another axis of the station, by `slot_stride`; each axis has every object of "
                            "the first, so leave this row out",
                            to_text(other.address), to_text(one.address)),
          l.at("objects", i, "object"));
  });
}

void types_of_the_standard(const Look& l) {
  if (!l.p.drive) return;
  for (std::size_t i = 0; i < l.p.objects.size(); ++i)
    if (const auto why = against_standard(l.p.objects[i].address, l.p.objects[i].type); !why.empty())
      l.say(why, l.at("objects", i, "type"));
}

void values_of_the_type(const Look& l) {
  for (std::size_t i = 0; i < l.p.objects.size(); ++i) {
    const ObjectRow& o = l.p.objects[i];
    struct Value {
      const char* key;
      const std::optional<std::int64_t>& is;
    };
    const std::array values{Value{"initial", o.initial}, Value{"min", o.min}, Value{"max", o.max}};
    const auto range = range_of(o.type);
    bool of_type = true;
    for (const Value& v : values) {
      if (!v.is || (range && *v.is >= range->low && *v.is <= range->high)) continue;
      of_type = false;
      l.say(range ? fmt::format("{} of {} is not within its type, {} ({} to {}); correct one of the two", *v.is,
                                to_text(o.address), to_text(o.type), range->low, range->high)
                  : fmt::format("{} is a text and has no number; leave `{}` out", to_text(o.address), v.key),
            l.at("objects", i, v.key));
    }
    if (!of_type) continue;
    if (o.min && o.max && *o.min > *o.max)
      l.say(fmt::format("`min` of {} is {}, more than its `max` of {}; exchange or correct them", to_text(o.address),
                        *o.min, *o.max),
            l.at("objects", i, "min"));
    else if (o.initial && ((o.min && *o.initial < *o.min) || (o.max && *o.initial > *o.max)))
      l.say(fmt::format("`initial` of {} is {}, outside its own range ({} to {}); correct one of them",
                        to_text(o.address), *o.initial, o.min ? std::to_string(*o.min) : "any",
                        o.max ? std::to_string(*o.max) : "any"),
            l.at("objects", i, "initial"));
  }
}

// ---- process data ----

/// rx_pdos and tx_pdos in turn.
template <class Say>
void each_direction(const Look& l, Say say) {
  say("rx_pdos", l.p.rx_pdos, true);
  say("tx_pdos", l.p.tx_pdos, false);
}
Location location_of_entry(const Look& l, const char* key, std::size_t pdo, std::size_t entry) {
  return l.row(key, pdo).find("entries")->items[entry].location;
}

void mapped_as_access_lets(const Look& l) {
  each_direction(l, [&](const char* key, const std::vector<PdoRow>& pdos, bool outputs) {
    for (std::size_t i = 0; i < pdos.size(); ++i)
      for (std::size_t k = 0; k < pdos[i].entries.size(); ++k) {
        const ObjectAddress address = pdos[i].entries[k].address;
        const ObjectRow* object = find_object(l.p, first_slot(l.p, address, pdos[i].slot));
        if (object == nullptr || (outputs ? object->writable : object->readable)) continue;
        l.say(outputs ? fmt::format("{} goes to the station here, and `objects` says access: r; correct its access, or "
                                    "map it in tx_pdos",
                                    to_text(address))
                      : fmt::format("{} comes from the station here, and `objects` says access: w; correct its access, "
                                    "or map it in rx_pdos",
                                    to_text(address)),
              location_of_entry(l, key, i, k));
      }
  });
}

void no_object_mapped_twice(const Look& l) {
  each_direction(l, [&](const char* key, const std::vector<PdoRow>& pdos, bool) {
    std::vector<ObjectAddress> known;
    for (std::size_t i = 0; i < pdos.size(); ++i)
      for (std::size_t k = 0; k < pdos[i].entries.size(); ++k) {
        const ObjectAddress address = pdos[i].entries[k].address;
        if (std::ranges::count(known, address) != 0)
          l.say(fmt::format("{} is mapped in `{}` already: two values of one object go over the wire; map it once",
                            to_text(address), key),
                location_of_entry(l, key, i, k));
        known.push_back(address);
      }
  });
}

void mapping_objects_of_their_own(const Look& l) {
  each_direction(l, [&](const char* key, const std::vector<PdoRow>& pdos, bool outputs) {
    const int first = outputs ? 0x1600 : 0x1A00, last = first + 0x1FF;  // ETG.1000.6, table 67
    for (std::size_t i = 0; i < pdos.size(); ++i)
      if (pdos[i].index < first || pdos[i].index > last)
        l.say(fmt::format("0x{:04X} is no mapping object of `{}`; they are 0x{:04X} to 0x{:04X}", pdos[i].index, key,
                          first, last),
              l.at(key, i, "pdo"));
    each_twin(
        pdos, [](const PdoRow& a, const PdoRow& b) { return a.index == b.index; },
        [&](std::size_t i, std::size_t) {
          l.say(fmt::format("0x{:04X} is in `{}` already; give this PDO its own mapping object, or join the two",
                            pdos[i].index, key),
                l.at(key, i, "pdo"));
        });
    for (std::size_t i = 0; i < pdos.size(); ++i)
      if (pdos[i].slot >= std::max(l.p.slots, 1))
        l.say(fmt::format("axis {} is none of the station, whose `slots` are {}; correct one of the two", pdos[i].slot,
                          l.p.slots),
              l.at(key, i, "slot"));
  });
}

// ---- parameters ----

void no_parameter_twice(const Look& l) {
  each_twin(
      l.p.parameters, [](const Parameter& a, const Parameter& b) { return a.name == b.name; },
      [&](std::size_t i, std::size_t) {
        l.say(fmt::format("parameter '{}' is there already; give this one another name", l.p.parameters[i].name),
              l.at("parameters", i, "name"));
      });
  each_twin(
      l.p.parameters, [](const Parameter& a, const Parameter& b) { return a.address == b.address; },
      [&](std::size_t i, std::size_t k) {
        l.say(fmt::format("'{}' is {}, as '{}' is: the object would be written twice; leave one of the two out",
                          l.p.parameters[i].name, to_text(l.p.parameters[i].address), l.p.parameters[k].name),
              l.at("parameters", i, "object"));
      });
}

void parameters_that_can_be_held(const Look& l) {
  for (std::size_t i = 0; i < l.p.parameters.size(); ++i) {
    const Parameter& p = l.p.parameters[i];
    const auto range = range_of(p.type);
    if (p.value && (!range || *p.value < range->low || *p.value > range->high))
      l.say(range ? fmt::format("{} of '{}' is not within its type, {} ({} to {}); correct one of the two", *p.value,
                                p.name, to_text(p.type), range->low, range->high)
                  : fmt::format("'{}' is a text and holds no number; leave `value` out", p.name),
            l.at("parameters", i, "value"));
    const ObjectRow* object = find_object(l.p, p.address);
    if (object != nullptr && !object->writable && p.rule == ParameterRule::Write)
      l.say(fmt::format("'{}' is to be written, and `objects` says access: r of {}; correct its access, or write "
                        "`rule: must_equal`",
                        p.name, to_text(p.address)),
            l.at("parameters", i, "object"));
    const auto maps = [&](const PdoRow& pdo) {
      return std::ranges::any_of(pdo.entries,
                                 [&](const PdoEntry& e) { return first_slot(l.p, e.address, pdo.slot) == p.address; });
    };
    if (std::ranges::any_of(l.p.rx_pdos, maps))
      l.say(fmt::format("'{}' is to hold a value, and {} is in `rx_pdos`, which write it anew in every cycle; take it "
                        "out of one of the two",
                        p.name, to_text(p.address)),
            l.at("parameters", i, "object"));
  }
}

// ---- the station ----

void terminals_of_their_own(const Look& l) {
  const auto& all = l.p.terminals;
  each_twin(
      all,
      [](const Terminal& a, const Terminal& b) {
        return a.output == b.output && a.bit < b.bit + b.bits && b.bit < a.bit + a.bits;
      },
      [&](std::size_t i, std::size_t k) {
        const Node& rows = *l.root.find("terminals");
        l.say(fmt::format("terminal '{}' shares bit {} of the {} with '{}'; give it a bit of its own", all[i].name,
                          std::max(all[i].bit, all[k].bit), all[i].output ? "outputs" : "inputs", all[k].name),
              rows.keys[i].location);
      });
}

void sync_managers_that_go_together(const Look& l) {
  const auto& all = l.p.sync_managers;
  if (all.empty()) return;
  if (l.p.bus != BusKind::EtherCat)
    return l.say("only a station on EtherCAT has SyncManagers; leave them out", l.of("sync_managers"));
  each_twin(
      all, [](const SyncManagerRow& a, const SyncManagerRow& b) { return a.kind == b.kind; },
      [&](std::size_t i, std::size_t) {
        l.say("another SyncManager is for the same; leave one of the two out", l.at("sync_managers", i, "kind"));
      });
  const auto find = [&](SyncManagerKind kind) { return std::ranges::find(all, kind, &SyncManagerRow::kind); };
  const auto out = find(SyncManagerKind::MailboxOut), in = find(SyncManagerKind::MailboxIn);
  if ((out == all.end()) != (in == all.end()))
    l.say(fmt::format("a mailbox goes both ways, and {} is missing; add it",
                      out == all.end() ? "mailbox_out" : "mailbox_in"),
          l.of("sync_managers"));
  else if (out == all.end() && !l.p.parameters.empty())
    l.say(
        "parameters are read and written through a mailbox, and `sync_managers` have none; add mailbox_out and "
        "mailbox_in",
        l.of("parameters"));
  constexpr int kLeast = 16;  // a mailbox header and an expedited SDO (ETG.1000.6, 5.6)
  for (const auto& mailbox : {out, in})
    if (mailbox != all.end() && mailbox->length < kLeast)
      l.say(fmt::format("a mailbox of {} bytes holds no SDO; write its length, at least {}", mailbox->length, kLeast),
            l.at("sync_managers", static_cast<std::size_t>(mailbox - all.begin()), "length"));
}

void clock_of_one_width(const Look& l) {
  if (l.p.clock_bits != 32 && l.p.clock_bits != 64)
    l.say(fmt::format("a clock has 32 or 64 bits, and not {}; write which", l.p.clock_bits), l.of("clock_bits"));
}

void axes_are_of_a_drive(const Look& l) {
  if (l.p.drive && l.p.slots == 0)
    l.say("`drive` tells of axes, and `slots` says that there are none; write how many", l.of("slots"));
  if (!l.p.drive && l.p.slots > 0)
    l.say(fmt::format("`slots` says that there are axes ({}), and `drive` is missing; add it, or write slots: 0",
                      l.p.slots),
          l.of("slots"));
  if (l.p.slots > 1 && l.p.slot_stride == 0)
    l.say("axes of one station stand `slot_stride` apart, and it is 0; write the manual's", l.of("slot_stride"));
}

// ---- the drive ----

constexpr ObjectAddress kMode{0x6060, 0}, kMethod{0x6098, 0}, kDigitalInputs{0x60FD, 0}, kProbe{0x60B9, 0},
    kModes{0x6502, 0};

int width_of(const Look& l, ObjectAddress address, int otherwise) {
  const ObjectRow* object = find_object(l.p, address);
  return object != nullptr ? bits(object->type) : otherwise;
}

/// Those of a drive's values that its object does not take.
void say_outside(const Look& l, std::string_view what, const std::vector<std::int8_t>& values, const ObjectRow& object,
                 std::string_view key) {
  if (object.min && object.max && *object.min > *object.max) return;  // that is told as such
  std::string outside;
  for (const std::int8_t v : values)
    if ((object.min && v < *object.min) || (object.max && v > *object.max))
      outside += fmt::format("{}{}", outside.empty() ? "" : ", ", v);
  if (!outside.empty())
    l.say(fmt::format("{} {} is not within what `objects` gives {}; correct one of the two", what, outside,
                      to_text(object.address)),
          l.of_drive(key));
}

void modes_that_can_be_set(const Look& l) {
  if (!l.p.drive || l.p.drive->modes.empty()) return;
  const ObjectRow* mode = find_object(l.p, kMode);
  if (mode == nullptr) {
    l.say("a mode is chosen by 6060h, mapped or by SDO, and it is no row of `objects`; add it", l.of_drive("modes"));
  } else if (!mode->writable) {
    l.say("a mode is chosen by 6060h, and `objects` says access: r of it; write rw or w",
          l.at("objects", static_cast<std::size_t>(mode - l.p.objects.data()), "access"));
  } else {
    say_outside(l, "mode", l.p.drive->modes, *mode, "modes");
  }
}

void modes_that_it_shows(const Look& l) {
  const ObjectRow* shown = find_object(l.p, kModes);
  if (!l.p.drive || shown == nullptr || !shown->initial) return;
  for (const std::int8_t m : l.p.drive->modes)
    if (m >= 1 && m <= 32 && (*shown->initial >> (m - 1) & 1) == 0)  // CiA 402: bit m - 1; above are the vendor's
      l.say(
          fmt::format("mode {} is in `modes`, and bit {} of 6502h (supported modes) is 0 in `objects`; correct one of "
                      "the two",
                      m, m - 1),
          l.of_drive("modes"));
}

void homing_methods_that_can_be_set(const Look& l) {
  if (!l.p.drive || l.p.drive->homing_methods.empty()) return;
  const ObjectRow* method = find_object(l.p, kMethod);
  if (method == nullptr)
    return l.say(
        "a homing method is chosen by 6098h, and it is no row of `objects`; add it, or leave the methods out: "
        "[]",
        l.of_drive("homing_methods"));
  if (!method->writable)
    l.say("a homing method is chosen by 6098h, and `objects` says access: r of it; write rw or w",
          l.at("objects", static_cast<std::size_t>(method - l.p.objects.data()), "access"));
  say_outside(l, "homing method", l.p.drive->homing_methods, *method, "homing_methods");
}

void inputs_of_their_own(const Look& l) {
  if (!l.p.drive) return;
  const DriveFacts& d = *l.p.drive;
  struct Switch {
    const char* key;
    int bit;
  };
  const std::array all{Switch{"negative_limit", d.input_neg_limit}, Switch{"positive_limit", d.input_pos_limit},
                       Switch{"home", d.input_home}};
  const auto location = [&](std::size_t i) {
    return location_of_key(*l.root.find("drive")->find("inputs"), all[i].key);
  };
  each_twin(
      all, [](const Switch& a, const Switch& b) { return a.bit >= 0 && a.bit == b.bit; },
      [&](std::size_t i, std::size_t k) {
        l.say(fmt::format("{} is bit {} of 60FDh, as {} is; give it the bit that the manual says", all[i].key,
                          all[i].bit, all[k].key),
              location(i));
      });
  const int width = width_of(l, kDigitalInputs, 32);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].bit >= width)
      l.say(fmt::format("{} is bit {} of 60FDh, which has {} bits in `objects`; correct one of the two", all[i].key,
                        all[i].bit, width),
            location(i));
}

void status_bits_of_their_own(const Look& l) {
  if (!l.p.drive || l.p.drive->status_follows < 0 || l.p.drive->status_follows != l.p.drive->status_limit) return;
  l.say(
      fmt::format("bit {} of 6041h cannot be both; leave out what the manual does not state", l.p.drive->status_limit),
      location_of_key(*l.root.find("drive")->find("status_bits"), "limit"));
}

void probe_bit_of_its_own(const Look& l) {
  if (!l.p.drive || l.root.find("drive")->find("probe_level_bit") == nullptr) return;
  constexpr int kLatches = 3;  // bits 0 to 2 of 60B9h are probe 1's latches (CiA 402-2, 60B9h)
  const int bit = l.p.drive->probe_level_bit, width = width_of(l, kProbe, 16);
  if (bit >= kLatches && bit < width) return;
  l.say(fmt::format("bit {} of 60B9h is {}; write the one that shows the level of probe 1", bit,
                    bit < kLatches ? "one of probe 1's latches" : fmt::format("beyond its {} bits", width)),
        l.of_drive("probe_level_bit"));
}

void probe_input_that_it_has(const Look& l) {
  if (!l.p.drive || l.p.drive->probe_input.parameter.empty()) return;
  const std::string& name = l.p.drive->probe_input.parameter;
  if (std::ranges::find(l.p.parameters, name, &Parameter::name) == l.p.parameters.end())
    l.say(fmt::format(
              "there is no parameter '{}' in `parameters`; write the one that is the function of the probe's input",
              name),
          location_of_key(*l.root.find("drive")->find("probe_input"), "parameter"));
}

void quick_stops_that_it_has(const Look& l) {
  if (!l.p.drive) return;
  const DriveFacts& d = *l.p.drive;
  if (const std::uint32_t more = d.quick_stop_coasts & ~d.quick_stop_options; more != 0)
    l.say(fmt::format("{} is not in `quick_stop_options`; add it there, or leave it out here", std::countr_zero(more)),
          l.of_drive("quick_stop_coasts"));
  for (std::size_t i = 0; i < l.p.parameters.size(); ++i) {
    const Parameter& p = l.p.parameters[i];
    if (p.address != ObjectAddress{0x605A, 0} || !p.value || d.quick_stop_options == 0) continue;
    if (*p.value >= 0 && *p.value < 32 && (d.quick_stop_options >> *p.value & 1) != 0) continue;
    const ObjectRow* object = find_object(l.p, p.address);
    if (object != nullptr && ((object->min && *p.value < *object->min) || (object->max && *p.value > *object->max)))
      continue;  // that is told as such
    l.say(fmt::format("605Ah is to hold {}, which is not in `quick_stop_options`; correct one of the two", *p.value),
          l.at("parameters", i, "value"));
  }
}

constexpr std::int8_t kHoming = 6;  // of a drive with homing methods, its absence from `modes` is told as such

void statuswords_that_mean_their_state(const Look& l) {
  if (!l.p.drive) return;
  const DriveFacts& d = *l.p.drive;
  each_twin(
      d.statuswords, [](const StatuswordRow& a, const StatuswordRow& b) { return a.mode == b.mode; },
      [&](std::size_t i, std::size_t) {
        l.say(fmt::format("mode {} has its row already; leave one of the two out", d.statuswords[i].mode),
              l.in_drive("statuswords", i, "mode"));
      });
  struct State {
    const char* key;
    std::uint16_t StatuswordRow::*word;
    std::uint16_t mask, value;  // CiA 402-2, 6041h
  };
  constexpr std::array kStates{State{"ready", &StatuswordRow::ready, 0x6F, 0x21},
                               State{"switched_on", &StatuswordRow::switched_on, 0x6F, 0x23},
                               State{"enabled", &StatuswordRow::enabled, 0x6F, 0x27},
                               State{"running", &StatuswordRow::running, 0x6F, 0x27},
                               State{"reached", &StatuswordRow::reached, 0x6F, 0x27},
                               State{"fault", &StatuswordRow::fault, 0x4F, 0x08}};
  for (std::size_t i = 0; i < d.statuswords.size(); ++i) {
    const StatuswordRow& row = d.statuswords[i];
    if (std::ranges::count(d.modes, row.mode) == 0 && (row.mode != kHoming || d.homing_methods.empty()))
      l.say(fmt::format("mode {} is not in `modes`; add it there, or leave this row out", row.mode),
            l.in_drive("statuswords", i, "mode"));
    for (const State& s : kStates)
      if ((row.*s.word & s.mask) != s.value)
        l.say(fmt::format("0x{:04X} is not `{}` by CiA 402: its bits 0x{:02X} are 0x{:02X}, and that state's are "
                          "0x{:02X}; correct it",
                          row.*s.word, s.key, s.mask, row.*s.word & s.mask, s.value),
              l.in_drive("statuswords", i, s.key));
  }
}

void codes_that_are_listed_once(const Look& l) {
  if (!l.p.drive) return;
  const DriveFacts& d = *l.p.drive;
  each_twin(
      d.errors, [](const DriveErrorRow& a, const DriveErrorRow& b) { return a.code == b.code; },
      [&](std::size_t i, std::size_t k) {
        l.say(fmt::format("0x{:04X} is listed already, as '{}'; leave one of the two out", d.errors[i].code,
                          d.errors[k].text),
              l.in_drive("errors", i, "code"));
      });
  each_twin(
      d.alarm_bits, [](const AlarmBitRow& a, const AlarmBitRow& b) { return a.address == b.address && a.bit == b.bit; },
      [&](std::size_t i, std::size_t k) {
        l.say(fmt::format("bit {} of {} is listed already, as '{}'; leave one of the two out", d.alarm_bits[i].bit,
                          to_text(d.alarm_bits[i].address), d.alarm_bits[k].text),
              l.in_drive("alarm_bits", i, "bit"));
      });
  for (std::size_t i = 0; i < d.alarm_bits.size(); ++i)
    if (const int width = width_of(l, d.alarm_bits[i].address, 32); d.alarm_bits[i].bit >= width)
      l.say(fmt::format("{} has {} bits in `objects`, and none of them is bit {}; correct one of the two",
                        to_text(d.alarm_bits[i].address), width, d.alarm_bits[i].bit),
            l.in_drive("alarm_bits", i, "bit"));
  struct Code {
    const char* key;
    std::uint16_t is;
  };
  for (const Code& c : {Code{"deviation_code", d.deviation_code}, Code{"bus_loss_code", d.bus_loss_code},
                        Code{"homing_code", d.homing_code}})
    if (c.is != 0 && std::ranges::count(d.errors, c.is, &DriveErrorRow::code) == 0)
      l.say(fmt::format("0x{:04X} is not in `errors`; add it there, or correct it here", c.is), l.of_drive(c.key));
}

constexpr std::array kRules{
    no_object_twice,
    types_of_the_standard,
    values_of_the_type,
    mapped_as_access_lets,
    no_object_mapped_twice,
    mapping_objects_of_their_own,
    no_parameter_twice,
    parameters_that_can_be_held,
    terminals_of_their_own,
    sync_managers_that_go_together,
    clock_of_one_width,
    axes_are_of_a_drive,
    modes_that_can_be_set,
    modes_that_it_shows,
    homing_methods_that_can_be_set,
    inputs_of_their_own,
    status_bits_of_their_own,
    probe_bit_of_its_own,
    probe_input_that_it_has,
    quick_stops_that_it_has,
    statuswords_that_mean_their_state,
    codes_that_are_listed_once,
};

}  // namespace

Location location_of_key(const Node& row, std::string_view key) {
  const Node* node = row.find(key);
  return node != nullptr ? node->location : row.location;
}

void keep_profile_rules(const StationProfile& profile, const Node& root, Mistakes& mistakes) {
  const Look look{profile, root, mistakes};
  for (const auto rule : kRules) rule(look);
}

}  // namespace gantry::config
