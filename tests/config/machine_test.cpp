#include "config/machine.hpp"

#include <gtest/gtest.h>

namespace gantry::config {
namespace {

TEST(Machine, the_reference_machine_reads_without_a_mistake) {
  const auto m = load_machine("config/machines/dispenser.yaml");
  if (!m)
    for (const Error& e : m.error()) ADD_FAILURE() << to_text(e);
  ASSERT_TRUE(m);
}

}  // namespace
}  // namespace gantry::config
