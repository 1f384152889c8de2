// How the run thread lets time pass while it waits for the machine. In virtual time the waiting thread steps the loop
// itself, so that a dry run has one thread and is a pure function of its inputs; in real time the loop has its own
// thread and the waiting one sleeps a little.
#pragma once
#include "app/cycle/loop.hpp"
#include "app/cycle/pacer.hpp"
#include "core/clock.hpp"

namespace gantry::run {

class Pump {
 public:
  virtual ~Pump() = default;
  /// Lets about one bus cycle pass.
  virtual void step() = 0;
};

class VirtualPump final : public Pump {
 public:
  VirtualPump(cycle::Loop& loop, Clock& clock, Time first) : loop_(loop), clock_(clock), pacer_(first, loop.period()) {}
  void step() override { pacer_.shift(loop_.tick(pacer_.wait(clock_))); }

 private:
  cycle::Loop& loop_;
  Clock& clock_;
  cycle::Pacer pacer_;
};

class RealPump final : public Pump {
 public:
  RealPump(Clock& clock, Time period) : clock_(clock), period_(period) {}
  void step() override { clock_.sleep_until(clock_.now() + period_); }

 private:
  Clock& clock_;
  Time period_;
};

}  // namespace gantry::run
