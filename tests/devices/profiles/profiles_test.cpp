#include <gtest/gtest.h>

#include "devices/profiles/fault_text.hpp"
#include "devices/profiles/homing_objects.hpp"
#include "devices/profiles/map_pdos.hpp"
#include "devices/profiles/object_value.hpp"

namespace gantry::devices {
namespace {

config::StationProfile profile(const std::string& name) {
  auto p = config::load_profile(std::string(GANTRY_SOURCE_DIR "/config/") + name);
  EXPECT_TRUE(p) << (p ? "" : to_text(p.error().front()));
  return p ? *p : config::StationProfile{};
}

TEST(Profiles, every_shipped_ethercat_drive_maps_what_the_loop_needs) {
  for (const char* name : {"drives/id286.yaml", "drives/amd530b.yaml", "drives/std402ec.yaml"}) {
    const auto p = profile(name);
    for (int slot = 0; slot < p.slots; ++slot) {
      const auto l = map_drive(p, slot);
      ASSERT_TRUE(l) << to_text(l.error());
      EXPECT_TRUE(l->controlword.mapped() && l->target.mapped() && l->mode.mapped()) << name;
      EXPECT_TRUE(l->statusword.mapped() && l->position.mapped() && l->mode_display.mapped()) << name;
      EXPECT_TRUE(l->probe_function.mapped() && l->probe_status.mapped() && l->probe_rising.mapped()) << name;
      EXPECT_FALSE(l->codes.empty()) << name;
    }
    EXPECT_FALSE(map_drive(p, p.slots)) << name;
  }
}

TEST(Profiles, the_second_axis_lies_behind_the_first) {
  const auto p = profile("drives/std402ec.yaml");
  const auto first = map_drive(p, 0), second = map_drive(p, 1);
  ASSERT_TRUE(first && second);
  const auto bytes = static_cast<int>(image_bytes(std::span(p.rx_pdos).first(1)));
  EXPECT_EQ(second->controlword.offset, first->controlword.offset + bytes);
  EXPECT_EQ(image_bytes(p.rx_pdos), 2u * static_cast<unsigned>(bytes));
  EXPECT_EQ(find_mapped(p.rx_pdos, {0x6840, 0}), static_cast<std::size_t>(8 * bytes));
}

TEST(Profiles, a_field_of_another_size_is_refused_by_name) {
  auto p = profile("drives/amd530b.yaml");
  p.rx_pdos[0].entries[0].bit_length = 32;
  const auto l = map_drive(p, 0);
  ASSERT_FALSE(l);
  EXPECT_NE(l.error().message.find("6040h"), std::string::npos) << l.error().message;
}

TEST(Profiles, an_error_code_becomes_the_manuals_text) {
  const auto p = profile("drives/amd530b.yaml");
  const auto known = fault_text(p, 0x3210);
  EXPECT_NE(known.text.find("over-voltage"), std::string::npos) << known.text;
  EXPECT_NE(known.text.find("3210h"), std::string::npos);
  EXPECT_FALSE(known.remedy.empty());
  EXPECT_NE(fault_text(p, 0x1234).text.find("does not list"), std::string::npos);
  EXPECT_NE(fault_text(p, 0).text.find("no error code"), std::string::npos);
}

TEST(Profiles, homing_speaks_the_vendors_units) {
  config::Axis axis;
  axis.name = "C";
  axis.unit_per_rev = 5;
  axis.counts_per_unit = 2000;
  axis.homing = config::Homing{.order = 1, .method = 21, .fast = 25, .slow = 5, .acceleration = 500};
  const auto value = [](const auto& rows, std::uint16_t index, std::uint8_t sub) {
    for (const auto& r : rows)
      if (r.address == config::ObjectAddress{index, sub}) return r.value;
    return std::int64_t{-1};
  };
  const auto pulses = homing_objects(profile("drives/amd530b.yaml"), 0, axis);  // P/S
  ASSERT_TRUE(pulses) << to_text(pulses.error());
  EXPECT_EQ(value(*pulses, 0x6099, 1), 50'000);
  EXPECT_EQ(value(*pulses, 0x609A, 0), 1'000'000);
  const auto rpm = homing_objects(profile("drives/std402ec.yaml"), 1, axis);  // rpm, second axis
  ASSERT_TRUE(rpm) << to_text(rpm.error());
  EXPECT_EQ(value(*rpm, 0x6899, 1), 300);
  EXPECT_EQ(value(*rpm, 0x6899, 2), 60);
  EXPECT_EQ(value(*rpm, 0x6898, 0), 21);
  // Each row has a name by which a machine file may declare that the station lacks it.
  auto lacking = profile("drives/id286.yaml");
  lacking.declared = {"homing_slow"};
  const auto rows = homing_objects(lacking, 0, axis);
  ASSERT_TRUE(rows) << to_text(rows.error());
  ASSERT_EQ(rows->size(), 5u);
  for (const auto& row : *rows) {
    EXPECT_FALSE(row.name.empty()) << row.why;
    EXPECT_EQ(row.declared, row.address == (config::ObjectAddress{0x6099, 2})) << row.name;
  }
  axis.homing->fast = 1000;  // 12000 rpm
  const auto too_fast = homing_objects(profile("drives/std402ec.yaml"), 1, axis);
  ASSERT_FALSE(too_fast);
  EXPECT_EQ(too_fast.error().fault, Fault::OutOfRange);
}

TEST(Profiles, numbers_become_bytes_and_back) {
  using config::ObjectType;
  for (const auto& [type, value] : {std::pair{ObjectType::I8, std::int64_t{-3}},
                                    {ObjectType::U16, 65535},
                                    {ObjectType::I32, -2'000'000'000},
                                    {ObjectType::U32, 4'000'000'000}}) {
    const auto bytes = to_bytes(type, value);
    EXPECT_EQ(to_number(type, bytes), value);
    EXPECT_EQ(to_number(type, std::span<const std::byte>(bytes).first(bytes.size() - 1)), std::nullopt);
  }
}

}  // namespace
}  // namespace gantry::devices
