#include "devices/rt/dc_lock.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace gantry::devices {
namespace {

/// Two clocks: the master's cycle and a reference clock that runs `ppm` faster; frames pass after a jittering delay.
std::vector<double> run(double ppm, double start_ns, double jitter_ns, double loss, int cycles, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, jitter_ns);
  std::bernoulli_distribution lost(loss);
  DcLock lock;
  double master_ns = start_ns;
  std::vector<double> errors;
  for (int i = 0; i < cycles; ++i) {
    const double passes = (master_ns + std::abs(noise(random))) * (1 + ppm * 1e-6) + 1e9;
    const auto dc = static_cast<std::uint64_t>(passes);
    master_ns += 1e6 + static_cast<double>(lock.step(lost(random) ? 0 : dc).count());
    const double phase = std::fmod(master_ns * (1 + ppm * 1e-6), 1e6) - 500'000;
    errors.push_back(std::abs(phase));
  }
  return errors;
}

double quantile(std::vector<double> v, double q) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

TEST(DcLock, locks_from_any_phase_against_100_ppm) {
  for (const double ppm : {-100.0, 0.0, 100.0})
    for (const double start : {0.0, 100'000.0, 499'000.0, 501'000.0, 999'000.0}) {
      const auto errors = run(ppm, start, 0, 0, 3000, 1);
      EXPECT_LT(*std::max_element(errors.begin() + 1500, errors.end()), 100) << ppm << " ppm from " << start;
    }
}

TEST(DcLock, holds_under_jitter_and_loss) {
  const unsigned seed = 910;
  SCOPED_TRACE(seed);
  for (const double ppm : {-100.0, 100.0}) {
    auto errors = run(ppm, 0, 10'000, 0.01, 20'000, seed);
    errors.erase(errors.begin(), errors.begin() + 3000);
    EXPECT_LT(quantile(errors, 0.99), 20'000);
  }
}

TEST(DcLock, a_frame_that_the_host_sent_late_moves_nothing) {
  DcLock lock;
  for (std::uint64_t k = 1; k < 100; ++k) lock.step(k * 1'000'000 + 500'000);
  for (std::uint64_t k = 100; k < 1000; ++k) {
    const bool late = k % 17 == 0;
    EXPECT_EQ(lock.step(k * 1'000'000 + (late ? 900'000 : 500'000)).count(), 0) << k;
  }
  EXPECT_EQ(lock.error().count(), 0);
}

TEST(DcLock, a_phase_that_has_really_changed_is_believed_and_followed) {
  DcLock lock;
  std::int64_t dc = 1'000'500'000;
  for (int i = 0; i < 100; ++i) dc += 1'000'000 + lock.step(static_cast<std::uint64_t>(dc)).count();
  dc += 200'000;
  for (int i = 0; i < 400; ++i) dc += 1'000'000 + lock.step(static_cast<std::uint64_t>(dc)).count();
  EXPECT_NEAR(static_cast<double>(dc % 1'000'000), 500'000, 100);
}

TEST(DcLock, without_samples_the_learnt_rate_goes_on) {
  DcLock lock;
  std::uint64_t dc = 1'000'500'000;
  for (int i = 0; i < 3000; ++i) {  // reference 100 ppm fast: 100 ns a cycle
    const auto correction = lock.step(dc).count();
    dc += static_cast<std::uint64_t>(1'000'000 + correction + 100);
  }
  std::int64_t sum = 0;
  for (int i = 0; i < 1000; ++i) sum += lock.step(0).count();
  EXPECT_NEAR(static_cast<double>(sum), -100'000, 1000);
}

TEST(DcLock, a_locked_clock_gets_no_correction) {
  DcLock lock;
  for (std::uint64_t k = 1; k < 1000; ++k) EXPECT_EQ(lock.step(k * 1'000'000 + 500'000).count(), 0);
}

}  // namespace
}  // namespace gantry::devices
