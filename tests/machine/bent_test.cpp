// A whole machine whose stations have other mappings and sizes than their profiles say: it does its job as well, and
// what that costs is told.
#include "tests/altered.hpp"
#include "tests/machine/deposits.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::object;
using test::Rig;
using test::station;

using test::kDemo;
constexpr const char* kPlacement = "dx=0.7 mm, dy=0.4 mm, rot=-0.3 deg";

struct Bent {
  const char* what;
  std::function<void(config::Machine&)> wired;
  std::vector<std::pair<const char*, const char*>> told;  ///< station and object
};

void unmappable(config::Machine& m, std::initializer_list<const char*> names,
                std::initializer_list<std::uint16_t> indices) {
  for (const char* name : names)
    for (const std::uint16_t index : indices) object(m, name, {index, 0}).mappable = false;
}

/// The hash of the job on the machine as it is.
std::uint64_t as_usual() {
  static const std::uint64_t kHash = [] {
    Rig plain({.placement = kPlacement});
    const record::JobResult result = plain.run(test::load_recipe(kDemo));
    test::expect_done(result);
    return result.setpoint_hash;
  }();
  return kHash;
}

TEST(Bent, a_machine_of_bent_stations_does_its_job_as_well_and_tells_what_it_costs) {
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  const Bent all[] = {
      {"modes by SDO",
       [](auto& m) {
         unmappable(m, {"x", "y1", "y2", "z", "cu"}, {0x6060, 0x6061});
       },
       {{"'x'", "6060h"}, {"'y2'", "6061h"}}},
      {"switches and error codes by SDO",
       [](auto& m) {
         unmappable(m, {"x", "y1", "y2", "z"}, {0x60FD, 0x603F});
       },
       {{"'z'", "60FDh"}, {"'y1'", "603Fh"}}},
      {"other sizes",
       [](auto& m) {
         object(m, "z", {0x60B9, 0}).type = config::ObjectType::U32;
         object(m, "x", {0x6060, 0}).type = config::ObjectType::I16;
         object(m, "x", {0x6098, 0}).type = config::ObjectType::I16;
         test::remove_object(station(m, "y1").profile, 0x609A);
       },
       {{"'y1'", "609Ah"}}},
      {"room for four entries on the drive with the probe",
       [](auto& m) { station(m, "z").profile.max_pdo_entries = 4; },
       {{"'z'", "603Fh"}, {"'z'", "60FDh"}}},
  };
  for (const Bent& bent : all) {
    SCOPED_TRACE(bent.what);
    test::Said said;
    Rig rig({.placement = kPlacement, .wired = bent.wired});
    const record::JobResult result = rig.run(recipe);
    test::expect_done(result);
    test::expect_deposits(recipe, result);
    EXPECT_TRUE(result.collisions.empty());
    EXPECT_EQ(result.setpoint_hash, as_usual());
    for (const auto& [name, index] : bent.told) {
      EXPECT_EQ(said.count({name, index}), 1) << said.all();
      const auto in_report = std::ranges::count_if(result.events, [&](const std::string& event) {
        return event.find(name) != std::string::npos && event.find(index) != std::string::npos;
      });
      EXPECT_EQ(in_report, 1) << name << " " << index;
    }
  }
}

/// Where profile and station agree on other sizes than the standard's, nothing is bent and nothing is lost.
TEST(Bent, a_profile_with_other_sizes_does_its_job_as_well) {
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  using config::ObjectType;
  const auto resize = [](config::Machine& m, const char* name, std::uint16_t index, ObjectType type) {
    config::StationProfile& p = station(m, name).profile;
    test::object(p, index).type = type;
    for (auto* pdos : {&p.rx_pdos, &p.tx_pdos})
      for (config::PdoRow& row : *pdos)
        for (config::PdoEntry& e : row.entries)
          if (config::first_slot(p, e.address, row.slot) == config::ObjectAddress{index, 0})
            e.bit_length = static_cast<std::uint8_t>(config::bits(type));
  };
  test::Said said;
  Rig rig({.placement = kPlacement, .change = [&](auto& m) {
             resize(m, "z", 0x60B9, ObjectType::U32);
             resize(m, "z", 0x6098, ObjectType::I16);
             resize(m, "x", 0x6060, ObjectType::I16);
             resize(m, "x", 0x6061, ObjectType::I16);
             resize(m, "cu", 0x603F, ObjectType::U32);
             resize(m, "y1", 0x60FD, ObjectType::U16);
           }});
  const record::JobResult result = rig.run(recipe);
  test::expect_done(result);
  test::expect_deposits(recipe, result);
  EXPECT_EQ(result.setpoint_hash, as_usual());
  EXPECT_EQ(said.count({"mapping"}), 0) << said.all();
}

}  // namespace
}  // namespace gantry
