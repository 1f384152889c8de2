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

// ---- locked() ----

std::uint64_t at(std::int64_t cycle, std::int64_t error_ns) {
  return static_cast<std::uint64_t>(1'000'000'000 + cycle * 1'000'000 + 500'000 + error_ns);
}

TEST(DcLock, is_locked_only_after_it_has_kept_the_phase_for_a_while) {
  DcLock lock;
  EXPECT_FALSE(lock.locked());
  for (int i = 0; i < 99; ++i) lock.step(at(i, 30'000));
  EXPECT_FALSE(lock.locked());
  lock.step(at(99, 30'000));
  EXPECT_TRUE(lock.locked());
}

TEST(DcLock, that_only_passes_through_the_phase_is_not_locked) {
  DcLock lock;
  std::int64_t error = -400'000;
  for (int i = 0; i < 160; ++i, error += 5000) {  // 20 samples within the bound
    lock.step(at(i, error));
    EXPECT_FALSE(lock.locked()) << error;
  }
}

TEST(DcLock, between_the_bounds_the_answer_stays_what_it_was) {
  DcLock locked, not_locked;
  for (int i = 0; i < 200; ++i) locked.step(at(i, 0));
  for (int i = 200; i < 2000; ++i) {
    locked.step(at(i, 95'000 - (i % 2) * 30'000));
    not_locked.step(at(i, 95'000 - (i % 2) * 30'000));
    ASSERT_TRUE(locked.locked()) << i;
    ASSERT_FALSE(not_locked.locked()) << i;
  }
}

TEST(DcLock, is_lost_when_the_phase_is_and_is_locked_again_when_it_is_back) {
  DcLock lock;
  for (int i = 0; i < 200; ++i) lock.step(at(i, 0));
  int i = 200;
  for (std::int64_t error = 0; error <= 100'000; error += 1000, ++i) lock.step(at(i, error));
  EXPECT_TRUE(lock.locked());
  for (int n = 0; n < 9; ++n, ++i) lock.step(at(i, 101'000));
  EXPECT_TRUE(lock.locked());
  lock.step(at(i++, 101'000));
  EXPECT_FALSE(lock.locked());
  for (std::int64_t error = 100'000; error > 0; error -= 1000, ++i) lock.step(at(i, error));
  for (int n = 0; n < 100; ++n, ++i) lock.step(at(i, 0));
  EXPECT_TRUE(lock.locked());
}

TEST(DcLock, frames_that_the_host_sent_late_do_not_unlock_it_and_a_second_without_any_sample_does) {
  DcLock lock;
  for (int i = 0; i < 200; ++i) lock.step(at(i, 0));
  for (int i = 200; i < 2200; ++i) {
    lock.step(i % 3 == 0 ? at(i, 0) : at(i, 300'000));
    ASSERT_TRUE(lock.locked()) << i;
  }
  lock.step(at(2200, 0));
  for (int i = 0; i < 999; ++i) lock.step(0);
  EXPECT_TRUE(lock.locked());
  lock.step(0);
  EXPECT_FALSE(lock.locked());
}

TEST(DcLock, locks_at_every_cycle_time_that_a_machine_may_have) {
  for (const Time cycle : std::initializer_list<Time>{microseconds(250), microseconds(500), milliseconds(1),
                                                      milliseconds(4), milliseconds(10)})
    for (const double ppm : {-100.0, 100.0}) {
      SCOPED_TRACE(cycle.count());
      DcLock lock(dc_lock_options(cycle));
      const auto period = static_cast<double>(cycle.count());
      double master_ns = 0.9 * period, error = 0;
      for (int i = 0; i < 3000; ++i) {
        const double dc = master_ns * (1 + ppm * 1e-6) + 1000 * period;
        error = std::abs(std::fmod(dc, period) - period / 2);
        master_ns += period + static_cast<double>(lock.step(static_cast<std::uint64_t>(dc)).count());
      }
      EXPECT_TRUE(lock.locked());
      EXPECT_LT(error, 1e-4 * period + 2);
    }
}

TEST(DcLock, options_for_a_millisecond_are_the_defaults) {
  const DcLockOptions a = dc_lock_options(milliseconds(1)), b;
  EXPECT_EQ(a.phase, b.phase);
  EXPECT_EQ(a.correction_max, b.correction_max);
  EXPECT_EQ(a.rate_max, b.rate_max);
  EXPECT_EQ(a.outlier, b.outlier);
  EXPECT_EQ(a.lock_below, b.lock_below);
  EXPECT_EQ(a.unlock_beyond, b.unlock_beyond);
}

}  // namespace
}  // namespace gantry::devices
