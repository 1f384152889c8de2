#include "app/job/cut_bead.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

// A stop of slow axes takes longer than all that is kept up to the cut.
TEST(CutWatch, where_the_valve_has_shut_does_not_depend_on_how_long_the_stop_takes) {
  const config::Machine machine = test::reference();
  const auto shut_after = [&](CycleIndex stop_cycles) {
    constexpr CycleIndex kCut = 6000;
    CutWatch watch(machine);
    watch.begin();
    double mm = 0;
    for (CycleIndex n = 0; n < kCut + stop_cycles; ++n)
      watch.see({n, mm += n < kCut ? 0.05 : 0.05 * std::exp(-static_cast<double>(n - kCut) / 2000), n >= kCut});
    return watch.shut_at(0.012).value();
  };
  const ShutAt soon = shut_after(100);
  EXPECT_NEAR(soon.along_block_mm, 300, 1);
  for (const CycleIndex cycles : {4000, 5000, 12000}) {
    EXPECT_EQ(shut_after(cycles).along_block_mm, soon.along_block_mm) << cycles;
    EXPECT_EQ(shut_after(cycles).stood_s, soon.stood_s) << cycles;
  }
}

}  // namespace
}  // namespace gantry::job
