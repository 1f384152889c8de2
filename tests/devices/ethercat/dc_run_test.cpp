// Clocks of a whole line in virtual time: how far the stations' system times lie apart, and how well the master's cycle
// stays locked to them, with every clock off, frames that are lost and a host that wakes late. The truth is read in the
// virtual stations, not by the master.
#include <algorithm>
#include <random>

#include "sim/station/station.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

struct Figures {
  std::int64_t spread_ns = 0;  ///< largest distance of two system times at one instant
  double phase_p99_us = 0;     ///< of the wake-up asked for against the reference clock
};

/// `ppm`: of the reference clock; the others' are anywhere within 100 ppm of the host's.
Figures run(double ppm, unsigned seed) {
  std::mt19937_64 random(seed);
  BusBench b;
  std::vector<StationId> clocks;
  for (const auto& s : b.machine.stations)
    if (s.bus == config::BusKind::EtherCat && s.profile.dc) clocks.push_back(s.id);
  for (const StationId id : clocks) {
    b.segment.set_clock_drift(id, id == clocks.front() ? ppm : std::uniform_real_distribution(-100.0, 100.0)(random));
    b.segment.set_clock_jitter(id, 40);
  }
  b.operate();
  b.segment.faults().set_noise({.loss = 0.01, .seed = seed});

  Figures out;
  std::vector<double> phases;
  for (int i = 0; i < 23'000; ++i) {
    // A host that wakes up to 30 us late, and in one cycle of a hundred 0.1 to 0.4 ms.
    const bool late = std::uniform_int_distribution(0, 99)(random) == 0;
    const int delay_us = late ? std::uniform_int_distribution(100, 400)(random)
                              : std::min(30, static_cast<int>(std::exponential_distribution(0.2)(random)));
    const Time asked = b.due;
    b.clock.sleep_until(asked + microseconds(delay_us));
    const Time began = b.clock.now();
    b.cycle();
    if (i < 3000) continue;
    const Time now = b.clock.now();
    std::int64_t low = INT64_MAX, high = INT64_MIN;
    for (int p = 0; p < b.segment.station_count(); ++p) {
      if (!b.machine.stations[static_cast<std::size_t>(p)].profile.dc) continue;
      const auto t = static_cast<std::int64_t>(b.segment.station(p).esc().dc().system(now));
      low = std::min(low, t), high = std::max(high, t);
    }
    out.spread_ns = std::max(out.spread_ns, high - low);
    const auto reference =
        static_cast<std::int64_t>(b.segment.station(0).esc().dc().system(began)) - (began - asked).count();
    phases.push_back(std::abs(static_cast<double>((reference % 1'000'000) - 500'000)) / 1000);
  }
  std::sort(phases.begin(), phases.end());
  out.phase_p99_us = phases[phases.size() * 99 / 100];
  return out;
}

TEST(DcRun, clocks_stay_within_a_microsecond_and_the_master_within_twenty) {
  for (const double ppm : {-100.0, 0.0, 100.0}) {
    const unsigned seed = 4711;
    SCOPED_TRACE(ppm);
    const Figures f = run(ppm, seed);
    RecordProperty("spread_ns_at_" + std::to_string(static_cast<int>(ppm)) + "_ppm", static_cast<int>(f.spread_ns));
    RecordProperty("phase_p99_ns_at_" + std::to_string(static_cast<int>(ppm)) + "_ppm",
                   static_cast<int>(1000 * f.phase_p99_us));
    EXPECT_LT(f.spread_ns, 1000);
    EXPECT_LT(f.phase_p99_us, 20);
  }
}

}  // namespace
}  // namespace gantry::devices
