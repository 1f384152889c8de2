// A client that asks for what its owner has not is refused, and told so; what the user did not write is not compared.
#include "app/desk/identity.hpp"

#include <fstream>
#include <gtest/gtest.h>

namespace gantry::desk {
namespace {

constexpr const char* kMachine = "config/machines/dispenser.yaml";

TEST(Identity, each_option_that_an_owner_is_started_with_is_compared) {
  const auto owner = identity_of(kMachine, {});
  const std::vector<std::pair<std::string, void (*)(run::OwnerOptions&)>> others{
      {"--bus", [](auto& o) { o.bus = "ethercat:eth0"; }},
      {"--world", [](auto& o) { o.world_socket = "w"; }},
      {"--sim-seed", [](auto& o) { o.sim.seed = 77; }},
      {"--loop-cpu", [](auto& o) { o.loop_cpu = 1; }},
      {"--domain", [](auto& o) { o.network.domain = 7; }},
      {"--interface", [](auto& o) { o.network.interface = "eth0"; }},
      {"--peer", [](auto& o) { o.network.peers = {"10.0.2.2"}; }},
      {"--name", [](auto& o) { o.name = "another"; }}};
  for (const auto& [option, change] : others) {
    SCOPED_TRACE(option);
    run::OwnerOptions wanted;
    EXPECT_TRUE(same(owner, identity_of(kMachine, wanted), {option}));
    change(wanted);
    const auto refused = same(owner, identity_of(kMachine, wanted), {option});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::Usage);
    EXPECT_EQ(refused.error().where, option);
    EXPECT_TRUE(same(owner, identity_of(kMachine, wanted), {"--out"}));
  }
}

TEST(Identity, a_machine_file_that_was_changed_where_it_lies_is_the_owners_for_orders_that_need_none) {
  const std::string file = testing::TempDir() + "identity_machine.yaml",
                    other = testing::TempDir() + "identity_other.yaml";
  std::ofstream(file) << "machine: a\n";
  const auto owner = identity_of(file, {});
  std::ofstream(file) << "machine: a  # and more\n";
  EXPECT_FALSE(same(owner, identity_of(file, {}), {"--machine"}));
  EXPECT_TRUE(same(owner, identity_of(file, {}), {"--machine"}, MachineFile::SamePath));
  std::ofstream(other) << "machine: b\n";
  EXPECT_FALSE(same(owner, identity_of(other, {}), {"--machine"}, MachineFile::SamePath));
}

}  // namespace
}  // namespace gantry::desk
