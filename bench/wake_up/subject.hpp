// What is measured beside cyclictest: a loop with nothing in it, or the program itself with a whole job.
#pragma once
#include <string>

#include "bench/wake_up/figures.hpp"
#include "core/error.hpp"

namespace gantry::bench {

/// Our loop at its least, for `seconds`: absolute sleeps on the monotonic clock, nothing to do when awake.
Result<Figures> run_empty_loop(int cpu, int priority, int seconds);

/// `gantry run RECIPE` on the simulated machine in real time, all its threads on one CPU; read from its summary.json.
Result<Figures> run_job(int cpu, const std::string& program, const std::string& recipe);

/// The figures in a summary.json.
Result<Figures> parse_summary(const std::string& text);

}  // namespace gantry::bench
