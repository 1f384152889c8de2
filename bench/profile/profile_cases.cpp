// Any planner beside ours: cases of state-to-state motion in as CSV, what we make of them out as CSV.
//   profile_cases < cases.csv > results.csv            columns: see case_table.hpp
//   profile_cases --profiles phases.csv < cases.csv    also: id,axis,p0,v0,a0, then duration,jerk of every phase
// Output: id,result,duration,end_error,limit_excess,ns. result 0: solved, else the reason's number. end_error and
// limit_excess are relative, found by integrating the profile again in long double; ns: the least of --runs runs.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "bench/profile/case_table.hpp"
#include "bench/profile/reintegrated.hpp"

namespace gantry::bench {
namespace {

motion::Joint planned(const Case& c, Kind kind, motion::Outside outside) {
  const motion::Together how{.min_duration_s = c.min_duration_s, .outside = outside};
  if (kind == Kind::Velocity && (c.axes.size() > 1 || c.min_duration_s > 0))
    return motion::change_speeds_together(c.axes, how);
  if (kind == Kind::Position && (c.axes.size() > 1 || c.min_duration_s > 0)) return motion::move_together(c.axes, how);
  const motion::AxisMove& m = c.axes.front();
  const motion::Plan plan = kind == Kind::Velocity ? motion::change_speed(m.from, m.to.v, m.bounds, m.to.a)
                                                   : motion::move(m.from, m.to, m.bounds, outside);
  motion::Joint joint;
  joint.reason = plan.reason;
  joint.duration_s = motion::duration(plan.profile);
  joint.profiles.push_back(plan.profile);
  return joint;
}

/// The call alone, as a caller makes it.
template <class Call>
double fastest_ns(int runs, Call&& call) {
  using Clock = std::chrono::steady_clock;
  double best = 1e300;
  for (int i = 0; i < runs; ++i) {
    const auto begin = Clock::now();
    call();
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - begin).count());
  }
  return best;
}

double timed_ns(const Case& c, Kind kind, motion::Outside outside, int runs) {
  if (c.axes.size() > 1 || c.min_duration_s > 0)
    return fastest_ns(runs, [&] {
      const auto joint = planned(c, kind, outside);
      asm volatile("" : : "r"(&joint) : "memory");
    });
  const motion::AxisMove& m = c.axes.front();
  return fastest_ns(runs, [&] {
    const auto plan = kind == Kind::Velocity ? motion::change_speed(m.from, m.to.v, m.bounds, m.to.a)
                                             : motion::move(m.from, m.to, m.bounds, outside);
    asm volatile("" : : "r"(&plan) : "memory");
  });
}

void write_profile(std::ostream& out, const Case& c, const motion::Joint& joint) {
  char cell[64];
  const auto number = [&](double x) {
    std::snprintf(cell, sizeof cell, ",%.17g", x);
    out << cell;
  };
  for (std::size_t axis = 0; axis < joint.profiles.size(); ++axis) {
    const motion::Profile& p = joint.profiles[axis];
    out << quoted(c.id) << ',' << axis;
    number(p.from.p), number(p.from.v), number(p.from.a);
    for (const motion::Phase& phase : p.phases) number(phase.duration_s), number(phase.jerk);
    out << '\n';
  }
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  namespace bench = gantry::bench;
  namespace motion = gantry::motion;
  CLI::App app{"State-to-state motion: CSV cases on stdin, CSV results on stdout"};
  std::string profiles, outside = "soonest";
  int runs = 5;
  app.add_option("--profiles", profiles, "file for the phases of every case and axis");
  app.add_option("--outside", outside, "starts outside of the bounds: soonest or ease")
      ->check(CLI::IsMember({"soonest", "ease"}))
      ->capture_default_str();
  app.add_option("--runs", runs, "of which the fastest is told")->check(CLI::Range(1, 1000))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::ios::sync_with_stdio(false);

  std::string error;
  auto table = bench::CaseTable::open(std::cin, error);
  std::ofstream phases;
  if (!profiles.empty()) phases.open(profiles);
  if (table && !profiles.empty() && !phases) error = "cannot write " + profiles;
  if (!error.empty()) {
    std::fprintf(stderr, "profile_cases: %s\n", error.c_str());
    return 2;
  }
  const auto policy = outside == "ease" ? motion::Outside::Ease : motion::Outside::Soonest;
  std::printf("id,result,duration,end_error,limit_excess,ns\n");
  while (const auto c = table->next(error)) {
    if (!error.empty()) break;
    const motion::Joint joint = bench::planned(*c, table->kind(), policy);
    bench::Excess worst;
    for (std::size_t i = 0; joint && i < c->axes.size(); ++i) {
      const bool position = table->kind() == bench::Kind::Position;
      const auto e = bench::reintegrate(joint.profiles[i], c->axes[i].to, c->axes[i].bounds, position, position);
      worst = {std::max(worst.end, e.end), std::max(worst.limit, e.limit)};
    }
    const double ns = bench::timed_ns(*c, table->kind(), policy, runs);
    std::printf("%s,%d,%.17g,%.3g,%.3g,%.0f\n", bench::quoted(c->id).c_str(), static_cast<int>(joint.reason),
                joint ? joint.duration_s : std::nan(""), worst.end, worst.limit, ns);
    if (phases.is_open() && joint) bench::write_profile(phases, *c, joint);
  }
  if (!error.empty()) {
    std::fprintf(stderr, "profile_cases: %s\n", error.c_str());
    return 3;
  }
  return 0;
}
