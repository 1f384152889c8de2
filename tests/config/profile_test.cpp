// Profiles against the manuals. The numbers here are copied from the manuals' tables, not from the profiles.
#include <algorithm>
#include <gtest/gtest.h>
#include <map>

#include "config/drive.hpp"
#include "config/yaml.hpp"

namespace gantry::config {
namespace {

const StationProfile& profile(const std::string& name) {
  static std::map<std::string, StationProfile> read;
  if (const auto known = read.find(name); known != read.end()) return known->second;
  auto p = load_profile("config/" + name + ".yaml");
  if (!p)
    for (const Error& e : p.error()) ADD_FAILURE() << to_text(e);
  return read[name] = p ? *p : StationProfile{};
}
const char* const kAll[] = {"drives/id286", "drives/amd530b", "drives/std402ec",
                            "drives/iss57", "devices/dio16",  "devices/aio4"};
const char* const kEtherCatDrives[] = {"drives/id286", "drives/amd530b", "drives/std402ec"};

TEST(Profile, shipped_profiles_read_without_a_mistake) {
  for (const char* name : kAll) EXPECT_FALSE(profile(name).objects.empty()) << name;
  EXPECT_EQ(profile("drives/amd530b").name, "amd530b");
}

TEST(Profile, every_row_is_cited_or_assumed) {
  for (const char* name : kAll)
    for (const ObjectRow& row : profile(name).objects)
      EXPECT_TRUE(!row.section.empty() || row.assumed) << name << ' ' << row.name;
}

TEST(Profile, no_object_stands_twice) {
  for (const char* name : kAll) {
    std::map<ObjectAddress, int> seen;
    for (const ObjectRow& row : profile(name).objects) EXPECT_EQ(++seen[row.address], 1) << name << ' ' << row.name;
  }
}

TEST(Profile, identities_that_no_manual_states_are_assumed) {
  for (const char* name : kEtherCatDrives) EXPECT_TRUE(profile(name).identity.assumed) << name;
  // 1.2.1 of the ISS manual prints an identity of zeros.
  EXPECT_FALSE(profile("drives/iss57").identity.assumed);
}

TEST(Profile, pdos_keep_the_limits_of_the_amd530b_manual) {
  for (const char* name : kEtherCatDrives) {
    const StationProfile& p = profile(name);
    for (const auto* pdos : {&p.rx_pdos, &p.tx_pdos})
      for (const PdoRow& pdo : *pdos) {
        int bits_of_all = 0;
        for (const PdoEntry& e : pdo.entries) bits_of_all += e.bit_length;
        EXPECT_LE(pdo.entries.size(), 8u) << name;  // 5.6.2
        EXPECT_LE(bits_of_all, 32 * 8) << name;
      }
  }
}

TEST(Profile, what_csp_must_map_is_mapped_in_every_slot) {
  // iD286 10.1, AMD530B 6.5.3, STD402EC 11.1: 6040h, 607Ah / 6041h, 6064h.
  for (const char* name : kEtherCatDrives) {
    const StationProfile& p = profile(name);
    ASSERT_EQ(p.rx_pdos.size(), static_cast<std::size_t>(p.slots)) << name;
    for (int slot = 0; slot < p.slots; ++slot) {
      const auto mapped = [&](const std::vector<PdoRow>& pdos, int index) {
        const auto want = static_cast<std::uint16_t>(index + 0x800 * slot);
        const auto& entries = pdos[static_cast<std::size_t>(slot)].entries;
        return std::any_of(entries.begin(), entries.end(), [&](const PdoEntry& e) { return e.address.index == want; });
      };
      for (const int index : {0x6040, 0x607A, 0x6060, 0x60B8}) EXPECT_TRUE(mapped(p.rx_pdos, index)) << name;
      for (const int index : {0x6041, 0x6064, 0x6061, 0x603F, 0x60B9, 0x60BA, 0x60FD})
        EXPECT_TRUE(mapped(p.tx_pdos, index)) << name;
    }
  }
}

TEST(Profile, slots_stand_their_strides_apart) {
  // STD402EC 10.1, 10.2: current 22F1h, controlword 6840h, probe 68B8h of the second axis.
  const StationProfile& p = profile("drives/std402ec");
  EXPECT_EQ(in_slot(p, {0x20F1, 0}, 1).index, 0x22F1);
  EXPECT_EQ(in_slot(p, {0x6040, 0}, 1).index, 0x6840);
  EXPECT_EQ(in_slot(p, {0x60B8, 0}, 1).index, 0x68B8);
  EXPECT_EQ(in_slot(p, {0x1018, 1}, 1).index, 0x1018);
  EXPECT_EQ(first_slot(p, {0x6899, 2}, 1), (ObjectAddress{0x6099, 2}));
  for (const Parameter& row : p.parameters)
    EXPECT_NE(find_object(p, row.address), nullptr) << std::hex << row.address.index;
}

TEST(Profile, start_up_writes_known_objects_within_their_ranges) {
  for (const char* name : {"drives/id286", "drives/amd530b", "drives/iss57"}) {
    const StationProfile& p = profile(name);
    for (const Parameter& row : p.parameters) {
      const ObjectRow* object = find_object(p, row.address);
      ASSERT_NE(object, nullptr) << name << std::hex << row.address.index;
      EXPECT_TRUE(object->writable) << object->name;
      EXPECT_EQ(object->type, row.type) << object->name;
      if (!row.value) continue;
      EXPECT_GE(*row.value, object->min.value_or(*row.value)) << object->name;
      EXPECT_LE(*row.value, object->max.value_or(*row.value)) << object->name;
    }
  }
}

TEST(Profile, what_scales_motion_or_burns_a_motor_acts_at_power_up) {
  // STD402EC note 6: parameters 201, 241, 242 (20C9h, 20F1h, 20F2h), and the motor's type (5.1).
  for (const int index : {0x20C9, 0x20F1, 0x20F2, 0x20DA}) {
    const auto& rows = profile("drives/std402ec").parameters;
    const auto row = std::ranges::find_if(rows, [&](const Parameter& p) { return p.address.index == index; });
    ASSERT_NE(row, rows.end()) << std::hex << index;
    EXPECT_EQ(row->acts, ActsAt::PowerUp) << row->name;
    EXPECT_EQ(row->rule == ParameterRule::MustEqual, index == 0x20DA) << row->name;
  }
  for (const char* name : {"drives/id286", "drives/amd530b", "drives/std402ec", "drives/iss57"})
    EXPECT_TRUE(std::ranges::any_of(profile(name).parameters, &Parameter::must_be_stated)) << name;
}

TEST(Profile, what_the_manuals_do_not_say_is_marked_as_assumed) {
  struct Row {
    const char* profile;
    ObjectAddress object;
  };
  // STD402EC: 20F2h and 20DAh are in no table (5.1 has parameters 242 and 218); from where soft limits count, in none
  // either.
  for (const Row& r :
       {Row{"drives/std402ec", {0x20F2, 0}}, Row{"drives/std402ec", {0x20DA, 0}}, Row{"drives/std402ec", {0x213F, 0}},
        Row{"drives/std402ec", {0x213D, 0}}, Row{"drives/id286", {0x607D, 1}}, Row{"drives/id286", {0x607D, 2}}}) {
    const auto& rows = profile(r.profile).parameters;
    const auto row = std::ranges::find(rows, r.object, &Parameter::address);
    ASSERT_NE(row, rows.end()) << r.profile << to_text(r.object);
    EXPECT_TRUE(row->assumed) << r.profile << to_text(r.object);
  }
}

TEST(Profile, an_identity_is_the_default_that_the_manual_prints) {
  // AMD530B 8.2: product code 1, revision 1. ISS42/57-C 1.2.1: all zero.
  for (const auto& [name, product, revision] : {std::tuple{"drives/amd530b", 1u, 1u}, {"drives/iss57", 0u, 0u}}) {
    EXPECT_EQ(profile(name).identity.product, product) << name;
    EXPECT_EQ(profile(name).identity.revision, revision) << name;
  }
}

TEST(Profile, currents_of_the_iss57_have_the_ranges_of_its_manual) {
  struct Printed {
    int index;
    std::int64_t low, high;
    std::optional<std::int64_t> usual;
  };
  for (const Printed& r :
       {Printed{0x21FB, 10, 100, {}}, {0x21FC, 0, 100, 60}, {0x21FD, 0, 100, 100}, {0x21FE, 0, 100, 40}}) {  // 4.2
    const ObjectRow* row = find_object(profile("drives/iss57"), {static_cast<std::uint16_t>(r.index), 0});
    ASSERT_NE(row, nullptr) << std::hex << r.index;
    EXPECT_EQ(row->min, r.low);
    EXPECT_EQ(row->max, r.high);
    EXPECT_EQ(row->initial, r.usual);
  }
}

struct Printed {
  const char* drive;
  int mode;
  std::uint16_t enabled, running, fault;
};
TEST(Profile, statuswords_are_those_that_the_manuals_print) {
  // iD286 10.1 and STD402EC 11.1, "typical values"; AMD530B 6.2.
  const Printed table[] = {
      {"drives/id286", 8, 0x1237, 0x1237, 0x0238},    {"drives/id286", 1, 0x8237, 0x1237, 0x1238},
      {"drives/id286", 3, 0x1637, 0x1637, 0x1638},    {"drives/id286", 6, 0x8337, 0x0237, 0x0238},
      {"drives/std402ec", 8, 0x1237, 0x1237, 0x0238}, {"drives/std402ec", 1, 0x8237, 0x1237, 0x1238},
      {"drives/std402ec", 6, 0x8337, 0x0237, 0x0238}, {"drives/amd530b", 8, 0x1637, 0x1237, 0x0218},
      {"drives/amd530b", 1, 0x8637, 0x1237, 0x0638},  {"drives/amd530b", 6, 0x8737, 0x0237, 0x0638}};
  for (const Printed& want : table) {
    const auto& drive = profile(want.drive).drive;
    const auto row = std::find_if(drive->statuswords.begin(), drive->statuswords.end(),
                                  [&](const StatuswordRow& r) { return r.mode == want.mode; });
    ASSERT_NE(row, drive->statuswords.end()) << want.drive << ' ' << want.mode;
    EXPECT_EQ(row->enabled, want.enabled) << want.drive << ' ' << want.mode;
    EXPECT_EQ(row->running, want.running) << want.drive << ' ' << want.mode;
    EXPECT_EQ(row->fault, want.fault) << want.drive << ' ' << want.mode;
  }
}

TEST(Profile, every_printed_statusword_decodes_to_its_state) {
  // CiA 402: masks 6Fh and 4Fh.
  for (const char* name : {"drives/id286", "drives/amd530b", "drives/std402ec", "drives/iss57"})
    for (const StatuswordRow& row : profile(name).drive->statuswords) {
      EXPECT_EQ(row.ready & 0x6F, 0x21) << name;
      EXPECT_EQ(row.switched_on & 0x6F, 0x23) << name;
      for (const std::uint16_t on : {row.enabled, row.running, row.reached}) EXPECT_EQ(on & 0x6F, 0x27) << name;
      EXPECT_EQ(row.fault & 0x4F, 0x08) << name;
    }
}

TEST(Profile, error_codes_are_those_that_the_manuals_list) {
  const auto has = [](const char* name, std::uint32_t code, DriveErrorKind kind) {
    const auto& drive = profile(name).drive;
    return std::any_of(drive->errors.begin(), drive->errors.end(),
                       [&](const DriveErrorRow& r) { return r.code == code && r.kind == kind; });
  };
  // iD286 3.8.3: these four are warnings and may not set the fault bit.
  EXPECT_TRUE(has("drives/id286", 0x400, DriveErrorKind::EmergencyInput));
  EXPECT_TRUE(has("drives/id286", 0x800, DriveErrorKind::Limit));
  EXPECT_TRUE(has("drives/id286", 0x1000, DriveErrorKind::Limit));
  EXPECT_TRUE(has("drives/id286", 0x2000, DriveErrorKind::Warning));
  for (const std::uint32_t code : {0x2211, 0x7120, 0x3210, 0x8611, 0xFF19, 0xFF18, 0xFF32})
    EXPECT_TRUE(has("drives/std402ec", code, DriveErrorKind::Fault)) << std::hex << code;  // 11.5
  EXPECT_TRUE(has("drives/std402ec", 0x3220, DriveErrorKind::Undervoltage));
  for (const std::uint32_t code : {0x2212, 0x3211, 0x4201, 0x8611})
    EXPECT_TRUE(has("drives/iss57", code, DriveErrorKind::Fault)) << std::hex << code;  // 1.2.2
  EXPECT_TRUE(has("drives/amd530b", 0x3210, DriveErrorKind::Fault));                    // 3.8
}

TEST(Profile, facts_of_the_manuals) {
  const auto &id286 = *profile("drives/id286").drive, &amd = *profile("drives/amd530b").drive,
             &std402 = *profile("drives/std402ec").drive, &iss = *profile("drives/iss57").drive;
  using Cycles = std::vector<std::uint32_t>;
  EXPECT_EQ(id286.cycle_times_us, (Cycles{500, 750, 1000, 2000, 4000}));             // 10.1
  EXPECT_EQ(amd.cycle_times_us, (Cycles{250, 500, 1000, 2000, 4000, 8000, 10000}));  // 5.2
  EXPECT_EQ(std402.cycle_times_us, (Cycles{1000, 2000, 4000}));                      // 11.1
  EXPECT_FALSE(std402.closed_loop);
  EXPECT_EQ(amd.probe_level_bit, 7);  // 7.2: bit 7 is DI4, bit 6 the source
  EXPECT_TRUE(amd.probe_rearm_needs_zero);
  EXPECT_FALSE(id286.probe_rearm_needs_zero);
  EXPECT_EQ(id286.probe_level_bit, 6);              // 10.2
  EXPECT_EQ(iss.quick_stop_options, 0b1100111u);    // 1.2.2: 0, 1, 2, 5, 6
  EXPECT_EQ(amd.quick_stop_options, 0b111111111u);  // 8.4: 0 .. 8
  EXPECT_EQ(std::count(iss.modes.begin(), iss.modes.end(), 8), 0) << "no CSP";
  EXPECT_EQ(iss.homing_methods, (std::vector<std::int8_t>{17, 18, 24, 29}));  // 3.1
  const StationProfile& a = profile("drives/amd530b");
  EXPECT_EQ(*find_object(a, {0x6502, 0})->initial, 421);                        // 8.4
  EXPECT_EQ(*find_object(a, {0x60FD, 0})->initial, 0x01E00000);                 // 8.4
  EXPECT_EQ(*find_object(a, {0x6098, 0})->initial, 1);                          // 8.4
  EXPECT_EQ(*find_object(profile("drives/id286"), {0x6502, 0})->initial, 165);  // 9.1.2
}

TEST(Profile, a_pdo_over_its_limits_or_of_unknown_objects_is_a_mistake) {
  const std::string path = testing::TempDir() + "gantry_profile.yaml";
  std::string text = *read_text_file("config/drives/amd530b.yaml");
  const auto swap = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
  };
  swap("entries: [0x6040, 0x6060, 0x607A, 0x60B8]", "entries: [0x6040, 0x6666, 0x2001]");
  swap("0x60BA, 0x60FD]", "0x60BA, 0x60FD, 0x6062, 0x606C]");
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
  const auto p = load_profile(path);
  ASSERT_FALSE(p);
  ASSERT_EQ(p.error().size(), 3u);
  EXPECT_NE(p.error()[0].message.find("6666"), std::string::npos) << to_text(p.error()[0]);
  EXPECT_NE(p.error()[1].message.find("2001"), std::string::npos) << "not mappable";
  EXPECT_NE(p.error()[2].message.find("9 objects"), std::string::npos) << to_text(p.error()[2]);
  EXPECT_NE(p.error()[0].where.find(":24:5"), std::string::npos) << p.error()[0].where;
}

/// The mistake stands at the line of the text in which these words come first.
void expect_at_line_of(std::string_view words, const std::string& text, const Error& mistake) {
  const auto at = text.find(words);
  ASSERT_NE(at, std::string::npos) << words;
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  EXPECT_NE(mistake.where.find(":" + std::to_string(line) + ":"), std::string::npos)
      << to_text(mistake) << ", not line " << line;
}

/// The mistakes of a shipped profile in which one thing is another.
std::vector<Error> mistakes_of(const std::string& name, const std::string& from, const std::string& to,
                               std::string* text_of = nullptr) {
  const std::string path = testing::TempDir() + "gantry_changed_profile.yaml";
  std::string text = *read_text_file("config/" + name + ".yaml");
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at == std::string::npos) return {};
  text.replace(at, from.size(), to);
  if (text_of != nullptr) *text_of = text;
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
  const auto p = load_profile(path);
  return p ? std::vector<Error>{} : p.error();
}

TEST(Profile, what_it_says_against_itself_is_one_mistake_at_its_place) {
  const struct {
    const char *name, *from, *to, *at, *says;  ///< `at`: text in whose line the mistake is told
  } cases[] = {
      {"drives/std402ec", "\n  counts_per_rev: 10000", "\n  counts_per_rev: 8000", "name: counts_per_rev",
       "'counts_per_rev' = 10000 stands for `counts_per_rev: 10000`, and `drive` says 8000"},
      {"drives/id286", "type: u32, value: 10000, acts", "type: u32, value: 8000, acts", "name: counts_per_rev",
       "`drive` says 10000"},
      {"drives/iss57", "means: {counts_per_rev: 10000}", "means: {counts_per_rev: 4000}", "name: counts_per_rev",
       "'counts_per_rev' = 13 stands for `counts_per_rev: 4000`"},
      {"drives/iss57", "means: {counts_per_rev: 10000}, ", "", "name: counts_per_rev",
       "`means: {counts_per_rev: 10000}`"},
      {"drives/amd530b", "closed_loop: true\n", "closed_loop: false\n", "name: loop_mode", "`closed_loop: true`"},
      {"drives/amd530b", "means: {closed_loop: true}, ", "", "name: loop_mode", "`means: {closed_loop: true}`"},
      {"drives/amd530b", "type: i16, value: 2, why", "type: i16, value: 9, why", "name: quick_stop_option",
       "not within what `objects` gives 605Ah"},
      {"drives/amd530b", "object: 0x2024, type: u16, value", "object: 0x2024, type: u32, value", "name: loop_mode",
       "another type"},
      {"drives/id286", "[0x6040, 0x6060, 0x607A, 0x60B8]", "[0x6040, 0x6060, 0x60B8]", "{pdo: 0x1600", "607Ah"},
      {"drives/amd530b", "[0x6040, 0x6060,", "[0x6060,", "{pdo: 0x1600", "6040h"},
      {"drives/amd530b", "[0x6041, 0x6061,", "[0x6061,", "{pdo: 0x1A00", "6041h"},
      {"drives/std402ec", "0x6861, 0x6864,", "0x6861,", "{pdo: 0x1A01", "6864h (actual position of axis 1)"},
      {"drives/amd530b", "modes: [1, 3, 6, 8, 9]", "modes: [1, 3, 8, 9]", "  modes:", "6 (homing)"},
      {"drives/amd530b", "{kind: inputs,      start: 0x1400}", "{kind: inputs,      start: 0x1110}", "start: 0x1110",
       "lie over"},
      {"drives/amd530b", "{kind: outputs,     start: 0x1100}", "{kind: outputs,     start: 0x10FF}", "start: 0x10FF",
       "lie over"},
  };
  for (const auto& c : cases) {
    std::string text;
    const auto errors = mistakes_of(c.name, c.from, c.to, &text);
    ASSERT_EQ(errors.size(), 1u) << c.name << ' ' << c.to;
    EXPECT_NE(errors[0].message.find(c.says), std::string::npos) << to_text(errors[0]);
    expect_at_line_of(c.at, text, errors[0]);
  }
}

/// One row for each rule of config/profile_rules.cpp, and for each way to break it. Types are those of CiA 402's object
/// dictionary (IEC 61800-7-201), bits of 6041h, 60B9h and 6502h those of its tables.
TEST(Profile, what_no_station_can_have_is_one_mistake_at_its_place) {
  const struct {
    const char *name, *from, *to, *at, *says;
  } cases[] = {
      // Objects.
      {"drives/amd530b", "  - {object: 0x6041, ",
       "  - {object: 0x6040,   name: again, type: u16, access: rw, section: x}\n  - {object: 0x6041, ", "name: again",
       "6040h is in `objects` already, as 'controlword'"},
      {"drives/std402ec", "  - {object: 0x603F, ",
       "  - {object: 0x6840,   name: again, type: u16, access: rw, section: x}\n  - {object: 0x603F, ",
       "object: 0x6840", "6040h of another axis"},
      {"drives/amd530b", "name: controlword,             type: u16", "name: controlword,             type: u8",
       "object: 0x6040,", "is u16 in CiA 402, and u8 here"},
      {"drives/id286", "name: statusword,               type: u16", "name: statusword,               type: u32",
       "object: 0x6041,", "is u16 in CiA 402"},
      {"drives/amd530b", "name: target position,         type: i32", "name: target position,         type: u32",
       "object: 0x607A,", "is i32 in CiA 402, and u32 here"},
      {"drives/amd530b", "name: position feedback,       type: i32", "name: position feedback,       type: i16",
       "object: 0x6064,", "is i32 in CiA 402"},
      {"drives/amd530b", "name: probe 1 rising edge,     type: i32", "name: probe 1 rising edge,     type: u32",
       "object: 0x60BA,", "is i32 in CiA 402"},
      {"drives/amd530b", "name: error code,              type: u16", "name: error code,              type: i16",
       "object: 0x603F,", "without a sign"},
      {"drives/amd530b", "name: home offset,             type: i32", "name: home offset,             type: u32",
       "object: 0x607C,", "with a sign"},
      {"drives/amd530b", "name: profile velocity,        type: u32", "name: profile velocity,        type: bool",
       "object: 0x6081,", "a whole number"},
      {"drives/amd530b", "access: rw, initial: 1, min: 0, max: 35", "access: rw, initial: 1, min: 36, max: 35",
       "object: 0x6098,", "`min` of 6098h is 36, more than its `max` of 35"},
      {"drives/amd530b", "type: i8,     access: rw, initial: 8", "type: i8,     access: rw, initial: 300",
       "object: 0x6060,", "300 of 6060h is not within its type, i8 (-128 to 127)"},
      {"drives/amd530b", "initial: 20, min: 4, max: 50", "initial: 20, min: 4, max: 70000", "object: 0x2010,",
       "70000 of 2010h is not within its type"},
      {"drives/amd530b", "initial: 20, min: 4, max: 50", "initial: 51, min: 4, max: 50", "object: 0x2010,",
       "`initial` of 2010h is 51, outside its own range (4 to 50)"},
      {"drives/amd530b", "type: string, access: r,  pdo: false,", "type: string, access: r,  pdo: false, initial: 3,",
       "object: 0x1008,", "no number"},
      // Process data.
      {"drives/amd530b", "type: i32,    access: rw, initial: 0, unit: P, section: \"8.4\"}\n  - {object: 0x607C",
       "type: i32,    access: r,  initial: 0, unit: P, section: \"8.4\"}\n  - {object: 0x607C", "{pdo: 0x1600",
       "607Ah goes to the station here"},
      {"drives/amd530b", "name: statusword,              type: u16,    access: r, ",
       "name: statusword,              type: u16,    access: w, ", "{pdo: 0x1A00", "6041h comes from the station"},
      {"drives/amd530b", "0x607A, 0x60B8]", "0x607A, 0x60B8, 0x607A]", "{pdo: 0x1600", "607Ah is mapped in `rx_pdos`"},
      {"drives/amd530b", "0x60B9, 0x60BA, 0x60FD]}", "0x60B9, 0x60BA, 0x60FD]}\n  - {pdo: 0x1A01, entries: [0x6064]}",
       "{pdo: 0x1A01", "6064h is mapped in `tx_pdos`"},
      {"drives/std402ec", "{pdo: 0x1601, slot: 1", "{pdo: 0x1600, slot: 1", "slot: 1, entries: [0x6840",
       "0x1600 is in `rx_pdos` already"},
      {"drives/amd530b", "{pdo: 0x1600", "{pdo: 0x1A01", "{pdo: 0x1A01", "0x1600 to 0x17FF"},
      {"drives/amd530b", "0x607A, 0x60B8]}", "0x607A, 0x60B8]}\n  - {pdo: 0x1602, slot: 3, entries: [0x78FF]}",
       "{pdo: 0x1602", "axis 3 is none"},
      // Parameters.
      {"drives/amd530b", "name: input_5, object: 0x2152:5", "name: input_4, object: 0x2152:5",
       "object: 0x2152:5, type: u16, why", "parameter 'input_4' is there already"},
      {"drives/amd530b", "name: input_5, object: 0x2152:5", "name: input_5, object: 0x2152:4", "name: input_5",
       "'input_5' is 2152h:4, as 'input_4' is"},
      {"drives/amd530b", "type: u16, value: 0x1F", "type: u16, value: 0x1001F", "name: input_polarity",
       "65567 of 'input_polarity' is not within its type"},
      {"drives/amd530b", "initial: 0x1F,", "initial: 0x1F, unit: x,", "", ""},
      {"drives/amd530b", "name: DI logic,                type: u16,    access: rw",
       "name: DI logic,                type: u16,    access: r ", "name: input_polarity", "access: r of 2154h"},
      {"drives/amd530b", "{name: input_5, object: 0x2152:5, type: u16", "{name: mode, object: 0x6060, type: i8",
       "name: mode,", "in `rx_pdos`, which write it anew"},
      // The station.
      {"devices/dio16", "DI9:  {in: 9}", "DI9:  {in: 8}", "DI9:", "shares bit 8 of the inputs with 'DI8'"},
      {"devices/aio4", "AO2: {out: 16, bits: 16}", "AO2: {out: 8, bits: 16}", "AO2:", "shares bit 8 of the outputs"},
      {"drives/amd530b", "  - {kind: mailbox_in,  start: 0x1080, length: 128}\n", "", "{kind: mailbox_out",
       "mailbox_in is missing"},
      {"drives/amd530b", "{kind: inputs,      start: 0x1400}",
       "{kind: inputs,      start: 0x1400}\n  - {kind: inputs, start: 0x1800}", "start: 0x1800",
       "another SyncManager is for the same"},
      {"drives/amd530b", "start: 0x1080, length: 128", "start: 0x1080", "start: 0x1080", "holds no SDO"},
      {"drives/amd530b",
       "  - {kind: mailbox_out, start: 0x1000, length: 128}\n  - {kind: mailbox_in,  start: 0x1080, length: 128}\n", "",
       "{name: run_current", "through a mailbox"},
      {"drives/iss57", "dc: false", "dc: false\nsync_managers: [{kind: outputs, start: 0x1100}]",
       "sync_managers:", "only a station on EtherCAT"},
      {"drives/amd530b", "slots: 1", "slots: 1\nclock_bits: 48", "clock_bits:", "32 or 64 bits, and not 48"},
      {"devices/dio16", "slots: 0", "slots: 1", "slots: 1", "`drive` is missing"},
      // The drive.
      {"drives/amd530b", "modes: [1, 3, 6, 8, 9]", "modes: [1, 3, 6, 7, 8, 9]", "  modes:", "bit 6 of 6502h"},
      {"drives/iss57", "initial: 0, min: 0, max: 6, section", "initial: 0, min: 0, max: 5, section",
       "  modes:", "mode 6 is not within what `objects` gives 6060h"},
      {"drives/amd530b", "initial: 1, min: 0, max: 35", "initial: 1, min: 0, max: 34",
       "  homing_methods:", "homing method 35 is not within"},
      {"drives/amd530b", "name: homing method,           type: i8,     access: rw",
       "name: homing method,           type: i8,     access: r ", "object: 0x6098,", "access: r of it"},
      {"drives/amd530b", "positive_limit: 1, home: 2", "positive_limit: 0, home: 2",
       "  inputs:", "positive_limit is bit 0 of 60FDh, as negative_limit is"},
      {"drives/amd530b", "positive_limit: 1, home: 2", "positive_limit: 1, home: 1", "  inputs:", "home is bit 1"},
      {"drives/id286", "name: digital inputs,           type: u32", "name: digital inputs,           type: u8", "", ""},
      {"drives/id286", "{follows: 12, limit: 11}", "{follows: 11, limit: 11}", "  status_bits:", "cannot be both"},
      {"drives/amd530b", "probe_level_bit: 7", "probe_level_bit: 1", "probe_level_bit:", "latches"},
      {"drives/iss57", "quick_stop_coasts: [0]", "quick_stop_coasts: [0, 4]", "quick_stop_coasts:", "4 is not in"},
      {"drives/iss57", "quick_stop_options: [0, 1, 2, 5, 6]", "quick_stop_options: [0, 1, 2, 5]",
       "name: quick_stop_option", "605Ah is to hold 6"},
      {"drives/amd530b", "mode: 9, ready", "mode: 8, ready",
       "mode: 8, ready: 0x0631, switched_on: 0x0633, enabled: 0x0237", "mode 8 has its row already"},
      {"drives/amd530b", "mode: 9, ready", "mode: 10, ready", "mode: 10,", "mode 10 is not in `modes`"},
      {"drives/amd530b", "fault: 0x0218", "fault: 0x0237", "fault: 0x0237", "is not `fault` by CiA 402"},
      {"drives/amd530b", "code: 0x3220, kind", "code: 0x3210, kind", "kind: undervoltage", "listed already"},
      {"drives/amd530b", "homing_code: 0xFF00", "homing_code: 0xFF01", "homing_code:", "0xFF01 is not in `errors`"},
      {"drives/amd530b", "bit: 1,  code", "bit: 0,  code", "bit: 0,  code: 0x3210", "bit 0 of 213Fh is listed already"},
  };
  for (const auto& c : cases) {
    std::string text;
    const auto errors = mistakes_of(c.name, c.from, c.to, &text);
    if (*c.says == '\0') {  // the rule next to it, not broken
      EXPECT_TRUE(errors.empty()) << c.to << ": " << to_text(errors.front());
      continue;
    }
    ASSERT_EQ(errors.size(), 1u) << c.name << ' ' << c.to << (errors.empty() ? "" : ": " + to_text(errors.back()));
    EXPECT_NE(errors[0].message.find(c.says), std::string::npos) << to_text(errors[0]);
    expect_at_line_of(c.at, text, errors[0]);
  }
}

TEST(Profile, without_a_row_for_what_chooses_a_mode_nothing_can_choose_it) {
  std::string text = *read_text_file("config/drives/amd530b.yaml");
  const auto cut = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, text.find('\n', at) - at, to);
  };
  const auto read = [&] {
    const std::string path = testing::TempDir() + "gantry_no_mode.yaml";
    std::FILE* file = std::fopen(path.c_str(), "w");
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
    return load_profile(path);
  };
  cut("  - {pdo: 0x1600", "  - {pdo: 0x1600, entries: [0x6040, 0x607A, 0x60B8]}");
  const auto by_sdo = read();
  ASSERT_TRUE(by_sdo) << "it is set by SDO";
  EXPECT_TRUE(std::ranges::any_of(by_sdo->rx_pdos.front().entries, [](const PdoEntry& e) {
    return e.address.index == 0x6060;
  })) << "where the station does not take it into a PDO after all";
  cut("  - {object: 0x6060, ", "");
  const auto p = read();
  ASSERT_FALSE(p);
  ASSERT_EQ(p.error().size(), 1u);
  EXPECT_NE(p.error()[0].message.find("6060h"), std::string::npos) << to_text(p.error()[0]);
  EXPECT_NE(p.error()[0].message.find("add it"), std::string::npos) << to_text(p.error()[0]);
}

/// Real stations have them: the issue names 60B9h of 32 bits and 6098h of 16; ISS57-C has 6060h without a sign.
TEST(Profile, sizes_in_which_vendors_differ_are_no_mistake) {
  for (const auto& [from, to] :
       {std::pair{"name: probe status,            type: u16", "name: probe status,            type: u32"},
        {"name: homing method,           type: i8, ", "name: homing method,           type: i16,"},
        {"name: mode display,            type: i8, ", "name: mode display,            type: i16,"},
        {"name: digital inputs,          type: u32", "name: digital inputs,          type: u32"},
        {"name: probe function,          type: u16", "name: probe function,          type: u32"}}) {
    const auto errors = mistakes_of("drives/amd530b", from, to);
    EXPECT_TRUE(errors.empty()) << to << ": " << to_text(errors.front());
  }
}

TEST(Profile, digital_inputs_that_it_has_and_maps_nowhere_are_asked_for) {
  const std::string path = testing::TempDir() + "gantry_changed_profile.yaml";
  EXPECT_TRUE(mistakes_of("drives/amd530b", "0x60BA, 0x60FD]", "0x60BA]").empty());
  const auto p = load_profile(path);
  ASSERT_TRUE(p);
  EXPECT_EQ(p->tx_pdos[0].entries.back().address, (ObjectAddress{0x60FD, 0}));
  EXPECT_EQ(p->tx_pdos[0].entries.back().bit_length, 32);
  EXPECT_TRUE(std::ranges::any_of(p->assumptions, [](const std::string& s) { return s.starts_with("60FDh"); }));
}

TEST(Profile, terminals_name_bits_of_the_image) {
  const auto at = [](const char* of, std::string_view name) {
    for (const Terminal& t : profile(of).terminals)
      if (t.name == name) return t;
    ADD_FAILURE() << name;
    return Terminal{};
  };
  EXPECT_EQ(profile("devices/dio16").terminals.size(), 32u);
  EXPECT_EQ(at("devices/dio16", "DI7").bit, 7);
  EXPECT_FALSE(at("devices/dio16", "DI7").output);
  EXPECT_EQ(at("devices/dio16", "DO15").bit, 15);
  EXPECT_TRUE(at("devices/dio16", "DO15").output);
  EXPECT_EQ(at("devices/aio4", "AI3").bit, 32);
  EXPECT_EQ(at("devices/aio4", "AI3").bits, 16);
}

TEST(Profile, a_terminal_beyond_the_image_or_of_both_directions_is_a_mistake_at_its_place) {
  const std::string path = testing::TempDir() + "gantry_terminals.yaml";
  for (const auto& [row, says] : {std::pair{"  DI16: {in: 16}\n", "ends at bit 16"},
                                  {"  DI16: {in: 1, out: 1}\n", "exactly one of: in, out"},
                                  {"  DI16: {}\n", "exactly one of: in, out"}}) {
    std::string text = *read_text_file("config/devices/dio16.yaml");
    const auto at = text.find("terminals:\n") + 11;
    text.insert(at, row);
    std::FILE* file = std::fopen(path.c_str(), "w");
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
    const auto p = load_profile(path);
    ASSERT_FALSE(p) << row;
    EXPECT_EQ(p.error().size(), 1u);
    EXPECT_NE(p.error()[0].message.find(says), std::string::npos) << to_text(p.error()[0]);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    EXPECT_NE(p.error()[0].where.find(":" + std::to_string(line) + ":3"), std::string::npos) << p.error()[0].where;
  }
}

/// Cells of the table row of a page whose second cell names this object, and where among others.
std::optional<std::pair<std::vector<std::string>, std::size_t>> page_row(const std::string& page,
                                                                         const std::string& object) {
  const auto parts = [](const std::string& text, char by) {
    std::vector<std::string> out{""};
    for (const char c : text)
      if (c == by)
        out.emplace_back();
      else
        out.back() += c;
    for (std::string& part : out) {
      part.erase(0, part.find_first_not_of(' '));
      part.erase(part.find_last_not_of(' ') + 1);
    }
    return out;
  };
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const auto cells = parts(line, '|');
    const auto objects = parts(cells.at(2), ',');
    if (const auto at = std::ranges::find(objects, object); at != objects.end())
      return std::pair{parts(cells.at(3), ','), static_cast<std::size_t>(at - objects.begin())};
  }
  return std::nullopt;
}

// AMD530B 4.1, 8.3, 8.4, 6.4.2; iD286 9.1.1, 9.1.2 and its appendix; STD402EC 10.1, 11.1: by hand, beside the profiles,
// of which the virtual drives are made, too.
TEST(Profile, inputs_and_status_bits_are_those_of_the_manuals) {
  struct Inputs {
    const char* drive;
    int negative, positive, home;  // the values that IN1, IN2, IN3 get, in the order in which they are wired
    std::int8_t follows, limit;
  };
  // AMD530B: DI1 is the positive limit (1), DI2 the negative (2). The others: IN1 negative (10), IN2 positive (9).
  for (const Inputs& want : {Inputs{"amd530b", 2, 1, 3, -1, 11}, Inputs{"id286", 10, 9, 11, 12, 11},
                             Inputs{"std402ec", 10, 9, 11, 12, 11}}) {
    const StationProfile p = *load_profile(std::string("config/drives/") + want.drive + ".yaml");
    const auto value = [&](const char* name) {
      return std::ranges::find(p.parameters, std::string(name), &Parameter::name)->value;
    };
    const bool amd = std::string(want.drive) == "amd530b";
    EXPECT_EQ(value(amd ? "input_2" : "input_1"), want.negative) << want.drive;
    EXPECT_EQ(value(amd ? "input_1" : "input_2"), want.positive) << want.drive;
    EXPECT_EQ(value("input_3"), want.home) << want.drive;
    EXPECT_EQ(p.drive->input_neg_limit, 0) << want.drive;  // CiA 402-2, 60FDh
    EXPECT_EQ(p.drive->input_pos_limit, 1) << want.drive;
    EXPECT_EQ(p.drive->input_home, 2) << want.drive;
    EXPECT_EQ(p.drive->status_follows, want.follows) << want.drive;
    EXPECT_EQ(p.drive->status_limit, want.limit) << want.drive;
  }
}

TEST(Profile, each_drive_has_a_page_that_names_every_object_of_its_parameters) {
  for (const char* name : {"id286", "amd530b", "std402ec", "iss57"}) {
    const auto profile = load_profile(std::string("config/drives/") + name + ".yaml");
    ASSERT_TRUE(profile) << name;
    const auto page = read_text_file(std::string("docs/drives/") + name + ".md");
    ASSERT_TRUE(page) << name;
    ASSERT_FALSE(profile->parameters.empty());
    for (const Parameter& p : profile->parameters) {
      // 2190h must not be taken for a part of 2190h:1.
      const std::string object = to_text(p.address);
      bool named = false;
      for (auto at = page->find(object); at != std::string::npos && !named; at = page->find(object, at + 1))
        named = at + object.size() >= page->size() || (*page)[at + object.size()] != ':';
      EXPECT_TRUE(named) << "docs/drives/" << name << ".md does not name " << object << " (" << p.name << ")";
      const auto row = page_row(*page, object);
      ASSERT_TRUE(row) << name << " " << object;
      ASSERT_GT(row->first.size(), row->second) << name << " " << object;
      EXPECT_EQ(row->first[row->second], p.value ? std::to_string(*p.value) : "-") << name << " " << object;
    }
    for (const char* part : {"## Wiring", "## Parameters", "## How it stops", "## Assumed", "## To verify"})
      EXPECT_NE(page->find(part), std::string::npos) << name << ": " << part;
  }
}

}  // namespace
}  // namespace gantry::config
