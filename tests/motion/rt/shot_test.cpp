// Shots and beads behind stops and overrides on the way to them: the valve is told to open its lead before the needle
// is there, and is open as long as planned. Judged by the ticks at which the setpoints show it.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <random>

#include "tests/motion/rt/play.hpp"

namespace gantry::motion::test {
namespace {

constexpr std::uint32_t kFeature = 7;

struct Draw {
  std::mt19937_64 random;
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  double power(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  bool chance(double p) { return uniform(0, 1) < p; }
};

/// Travel as between features: over something, or three moves from rest to rest, or straight.
std::vector<Segment> way(const Limits& m, Draw& draw, const AxisVec& from, const AxisVec& to) {
  if (draw.chance(0.15)) return line_move(m, from, to);
  const double top = std::max(from[2], to[2]) + draw.uniform(0.5, 8);
  if (draw.chance(0.7)) {
    return arch(m, {.from = from,
                    .to = to,
                    .up = 2,
                    .top = top,
                    .leave_mm = draw.uniform(0.2, 0.9) * (top - from[2]),
                    .arrive_mm = draw.uniform(0.2, 0.9) * (top - to[2])})
        .segments;
  }
  AxisVec above = from, over = to;
  above[2] = over[2] = top;
  std::vector<Segment> out;
  for (const auto& [a, b] : {std::pair{from, above}, std::pair{above, over}, std::pair{over, to}})
    for (const Segment& s : line_move(m, a, b)) out.push_back(s);
  return out;
}

struct Case {
  std::vector<Segment> block;
  double lead_s = 0;                       ///< of the command to open
  long open_ticks = 0;                     ///< of a dot, between the commands
  double settle_s = 0;                     ///< of a dot, before its place in time
  double close_lead_s = 0, length_mm = 0;  ///< of a bead
  bool from_rest = false;                  ///< of a bead: without a run-up
  AxisVec from{}, along{};                 ///< of a bead: its first point and its direction
};

AxisVec home() { return {200, 200, -40, 0, 12}; }
AxisVec anywhere(Draw& draw) {
  AxisVec to = home();
  const double far = draw.power(0, 2), turn = draw.uniform(0, 6.3);
  to[0] += far * std::cos(turn), to[1] += far * std::sin(turn), to[2] += draw.uniform(-0.2, 0.2);
  return to;
}
void finish(Case& c) {
  for (Segment& s : c.block) s.block = 1;
  c.block.back().ends_block = true;
}

/// At an override of 200 % the way may take half as long.
double lead(Draw& draw, const std::vector<Segment>& way) {
  return 1e-3 * std::floor(std::min(draw.power(0, 2.4), 1e3 * duration(way) / 2 - 2));
}

Case dot(const Limits& m, Draw& draw) {
  Case out;
  const AxisVec to = anywhere(draw);
  out.block = way(m, draw, home(), to);
  const double time_s = 1e-3 * std::floor(draw.uniform(8, 90));
  if (draw.chance(0.4)) out.settle_s = 1e-3 * std::floor(draw.uniform(1, 60));
  out.lead_s = lead(draw, out.block);
  // It may be told to shut before the needle is there.
  const double close_lead_s =
      1e-3 * std::floor(draw.chance(0.3) ? draw.uniform(0, 1e3 * (out.lead_s + time_s) - 2) : draw.uniform(0, 8));
  out.open_ticks = std::lround((out.lead_s + time_s - close_lead_s) / m.tick_s);
  const std::array events{OutputEvent{out.settle_s, out.lead_s, kValve, kValve, true},
                          OutputEvent{out.settle_s + time_s, close_lead_s, kValve, 0, false}};
  out.block.push_back(dwell(m, to, out.settle_s + time_s, events));
  out.block.back().feature = kFeature;
  AxisVec up = to;
  up[2] += 4;
  for (const Segment& s : line_move(m, to, up)) out.block.push_back(s);
  finish(out);
  return out;
}

/// A straight bead, come to with its run-up.
Case bead(const Limits& m, Draw& draw) {
  Case out;
  BeadSpec spec;
  AxisVec to = out.from = anywhere(draw);
  const double turn = draw.uniform(0, 6.3), length = draw.uniform(5, 40);
  to[0] += length * std::cos(turn), to[1] += length * std::sin(turn);
  out.length_mm = length;
  out.from_rest = draw.chance(0.2);
  if (out.from_rest) spec.entry_mm_s = 0;
  spec.points = {out.from, to};
  spec.speed_mm_s = draw.power(0.7, 2);
  for (std::size_t i = 0; i < 2; ++i) out.along[i] = (to[i] - out.from[i]) / length;
  spec.valve = kValve;
  spec.feature = kFeature;
  BeadMotion planned = *plan_bead(m, spec);
  out.block = way(m, draw, home(), planned.start);
  spec.open_lead_s = out.lead_s = lead(draw, out.block);
  spec.close_lead_s = out.close_lead_s =
      1e-3 * std::floor(draw.uniform(0, std::min(200 * length / spec.speed_mm_s, 60.0)));
  planned = *plan_bead(m, spec);
  for (const Segment& s : planned.segments) out.block.push_back(s);
  finish(out);
  return out;
}

/// Ticks since the tool was at the place of the command to open, of a bead so far from its first point; below 0: it is
/// not there yet.
double ticks_beyond(const Limits& m, const Case& c, const Setpoint& x, double mm = 0) {
  if (x.feature != kFeature || x.block == 0) return -1;
  if (c.open_ticks > 0) return (x.s - c.settle_s) / m.tick_s;
  double gone_mm = -mm;
  for (std::size_t i = 0; i < 2; ++i) gone_mm += (x.q[i] - c.from[i]) * c.along[i];
  return gone_mm < 0 ? -1 : gone_mm / x.s_dot / m.tick_s;
}

struct Trouble {
  long holds = 0;
  bool overrides = false, hasty = false;  ///< resumed while it brakes still
};
struct Seen {
  bool wrong = false;           ///< never ended, never opened, more than once, or while held
  bool in_run_up = false;       ///< a stop came in that of a bead
  bool passed = false;          ///< a stop went over the place itself: not asked here
  double ends_early_ticks = 0;  ///< by which the command to shut of a bead came before its lead
  double early_ticks = 0;       ///< by which the command to open came before its lead
  long open_ticks = 0;
};

/// Stops it at random instants up to its place, and changes the override as a machine does, not while the valve is
/// open.
Seen play(const Limits& m, Draw& draw, const Case& c, Trouble trouble) {
  Player p(m, home());
  p.push(c.block);
  p.play.begin_block(1);
  const auto soon = [&] { return 1 + std::lround(draw.uniform(0, duration(c.block) / m.tick_s)); };
  Seen out;
  long tick = 0, opened = 0, shut = 0, next = soon(), stood = 0, openings = 0;
  double there = 0, ended = 0, factor = trouble.overrides ? draw.power(-1, 0.3) : 1;
  bool open = false, stops = false;
  while (!p.play.idle() && tick < 400000) {
    if (p.play.held()) {
      if ((p.play.at_rest() && ++stood > 5) || (trouble.hasty && draw.chance(0.05)))
        p.play.resume(), stops = !p.play.at_rest(), stood = 0, next = tick + soon();
    } else if (trouble.holds > 0 && there == 0 && !p.play.lays_its_last() &&
               (tick >= next || (open && p.play.at_rest() && draw.chance(0.1)))) {
      p.play.hold(), --trouble.holds, stops = true;
      out.in_run_up |= c.open_ticks == 0 && p.last.feature == kFeature;
      if (open) --openings;
    } else if (trouble.overrides && !open && draw.chance(0.05)) {
      factor = draw.power(-1, 0.3);
    }
    const Setpoint x = p.step(factor);
    ++tick;
    if (p.play.at_rest()) stops = p.play.held();
    const double beyond = ticks_beyond(m, c, x);
    if (there == 0 && beyond >= -1e-6) {
      there = static_cast<double>(tick) - beyond;
      out.passed = stops;
    }
    if (ended == 0 && c.length_mm > 0 && ticks_beyond(m, c, x, c.length_mm) >= -1e-6)
      ended = static_cast<double>(tick) - ticks_beyond(m, c, x, c.length_mm);
    const bool now = (x.outputs & kValve) != 0;
    if (now && !open) opened = tick, ++openings;
    if (!now && open) shut = tick;
    open = now;
    out.wrong |= open && stops;
  }
  out.wrong |= !p.play.idle() || openings != 1;
  out.early_ticks = there - static_cast<double>(opened) - c.lead_s / m.tick_s;
  out.ends_early_ticks = c.length_mm > 0 ? ended - static_cast<double>(shut) - c.close_lead_s / m.tick_s : 0;
  out.open_ticks = shut - opened;
  return out;
}

constexpr std::array kTroubles{Trouble{},
                               Trouble{.holds = 1},
                               Trouble{.holds = 3},
                               Trouble{.holds = 2, .hasty = true},
                               Trouble{.overrides = true},
                               Trouble{.holds = 2, .overrides = true},
                               Trouble{.holds = 2, .overrides = true, .hasty = true}};
// What comes behind travel begins with a tick; a run-up that is slowed or stopped may end within one,
// and its speed changes in that.
constexpr double kExact_ticks = 1e-3, kWithin_ticks = 0.65;

void expect_as_planned(Case (*draw_case)(const Limits&, Draw&)) {
  const Limits m = machine();
  long asked = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
    for (const Trouble& trouble : kTroubles) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", trouble " + std::to_string(&trouble - kTroubles.data()));
      Draw draw{std::mt19937_64(seed)};
      const Case c = draw_case(m, draw);
      const Seen seen = play(m, draw, c, trouble);
      if (seen.passed) continue;
      ++asked;
      ASSERT_FALSE(seen.wrong);
      const bool exact = c.open_ticks > 0 || !(trouble.overrides || seen.in_run_up);
      EXPECT_LE(std::abs(seen.ends_early_ticks), kWithin_ticks);
      if (c.from_rest) continue;  // how long it has gone is not to be told from its speed
      EXPECT_LE(std::abs(seen.early_ticks), exact ? kExact_ticks : kWithin_ticks);
      EXPECT_LE(c.open_ticks > 0 ? std::abs(seen.open_ticks - c.open_ticks) : 0, 0);
    }
  EXPECT_GT(asked, 2000);
}

TEST(Shot, of_a_dot_is_as_planned_behind_stops_and_overrides) { expect_as_planned(dot); }
TEST(Shot, of_a_bead_begins_where_it_does_behind_stops_and_overrides) { expect_as_planned(bead); }

/// 20 mm to a dot, as block 1.
std::vector<Segment> way_to_dot(const Limits& m, double time_s, double open_lead_s, double close_lead_s) {
  AxisVec to = home();
  to[0] += 20;
  std::vector<Segment> block = line_move(m, home(), to);
  const std::array events{OutputEvent{0, open_lead_s, kValve, kValve, true},
                          OutputEvent{time_s, close_lead_s, kValve, 0, false}};
  block.push_back(dwell(m, to, time_s, events));
  for (const Segment& s : line_move(m, to, home())) block.push_back(s);
  for (Segment& s : block) s.block = 1;
  block.back().ends_block = true;
  return block;
}

// Both commands come ahead of the dot: whoever stops there at once, the second one is given behind the first.
TEST(Shot, of_a_dot_that_a_stop_begins_anew_ends) {
  const Limits m = machine();
  const std::vector<Segment> block = way_to_dot(m, 0.012, 0.04, 0.03);
  for (long first = 1; first <= std::lround(duration(block) / m.tick_s); ++first) {
    Player p(m, home());
    p.push(block);
    p.play.begin_block(1);
    for (long n = 0; n < first; ++n) p.step();
    p.play.hold();
    for (int n = 0; n < 200; ++n) ASSERT_EQ(p.step().outputs & kValve, 0u) << first;
    p.play.resume();
    long open = 0;
    while (!p.play.idle()) open += (p.step().outputs & kValve) != 0;
    EXPECT_EQ(p.last.outputs & kValve, 0u) << first;
    EXPECT_LE(open, 22) << first;
  }
}

// The path does not come in time: the tool stands before the dot, and goes on when it is there.
TEST(Shot, of_a_dot_that_comes_late_is_as_planned) {
  const Limits m = machine();
  const std::vector<Segment> block = way_to_dot(m, 0.06, 0.05, 0.01);
  for (std::size_t known = 0; known < block.size(); ++known) {
    Player p(m, home());
    p.play.begin_block(1);
    for (std::size_t k = 0; k < known; ++k) p.push(block[k]);
    long open = 0;
    for (int n = 0; n < 1000; ++n) open += (p.step().outputs & kValve) != 0;
    for (std::size_t k = known; k < block.size(); ++k) p.push(block[k]);
    while (!p.play.idle()) open += (p.step().outputs & kValve) != 0;
    EXPECT_EQ(open, 100) << known;
  }
}

// The stop ends where the dot is, and the next one comes while its lead is waited for there.
TEST(Shot, that_is_waited_for_at_its_place_is_not_lost_by_another_hold) {
  const Limits m = machine();
  const std::vector<Segment> block = way_to_dot(m, 0.06, 0.05, 0.01);
  const long arrives = std::lround(duration(std::span(block).first(1)) / m.tick_s);
  for (long first = arrives - 20; first <= arrives; ++first)
    for (const int waited : {1, 20, 50, 51}) {  // 51 ticks: the command's own, and the lead
      SCOPED_TRACE(fmt::format("{} ticks before it, {} waited", arrives - first, waited));
      Player p(m, home());
      p.push(block);
      p.play.begin_block(1);
      for (long n = 0; n < first; ++n) p.step();
      for (int holds = 0; holds < 2; ++holds) {
        p.play.hold();
        for (int n = 0; n < 100; ++n) p.step();
        p.play.resume();
        for (int n = 0; holds == 0 && n < waited; ++n) p.step();
      }
      long open = 0;
      while (!p.play.idle()) open += (p.step().outputs & kValve) != 0;
      EXPECT_EQ(open, 100);
    }
}

}  // namespace
}  // namespace gantry::motion::test
