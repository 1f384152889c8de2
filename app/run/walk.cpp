#include "app/run/walk.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>

#include "app/job/jog.hpp"
#include "app/job/walk.hpp"
#include "config/look_alikes.hpp"
#include "core/units.hpp"

namespace gantry::run {
namespace {

const config::Station& station_of(const config::Machine& machine, const config::DriveRef& ref) {
  return machine.stations[ref.station.value];
}

/// "'y1' (position 2) and 'y2' (position 3)"
std::string stations_of(const config::Machine& machine, const config::Axis& axis) {
  std::string words;
  for (const config::DriveRef& ref : axis.drives) {
    const config::Station& s = station_of(machine, ref);
    words += fmt::format("{}'{}' (position {}{})", words.empty() ? "" : " and ", s.name, s.position,
                         s.profile.slots > 1 ? fmt::format(", axis {} of it", ref.slot) : "");
  }
  return words;
}

std::string swapped(const config::Machine& machine, const config::Axis& ordered, const config::Axis& moved) {
  const bool one_station = std::ranges::any_of(ordered.drives, [&](const config::DriveRef& a) {
    return std::ranges::any_of(moved.drives, [&](const config::DriveRef& b) { return a.station == b.station; });
  });
  const std::string where = fmt::format("{} was ordered, and {} moved", ordered.name, moved.name);
  const bool alike = std::ranges::all_of(ordered.drives, [&](const config::DriveRef& a) {
    return std::ranges::any_of(moved.drives, [&](const config::DriveRef& b) {
      return config::look_alike(station_of(machine, a), station_of(machine, b));
    });
  });
  if (one_station)
    return where + fmt::format(": at {} the cables of the two motors are swapped, or the `slot`s of the machine file",
                               stations_of(machine, ordered));
  if (!alike)
    return where + fmt::format(": the motor cables of {} and {} are crossed", stations_of(machine, ordered),
                               stations_of(machine, moved));
  return where + fmt::format(
                     ": {} and {} are swapped; exchange their bus cables, or their `position`s in the machine "
                     "file, or else their motor cables",
                     stations_of(machine, ordered), stations_of(machine, moved));
}

std::string turned_round(const config::Machine& machine, const config::Axis& axis) {
  std::string parameters;
  for (const config::DriveRef& ref : axis.drives)
    for (const config::Parameter& p : station_of(machine, ref).profile.parameters)
      if (p.name == "direction")
        parameters += fmt::format(
            "{}`stations.{}.parameters.direction` ({})", parameters.empty() ? "" : ", ", station_of(machine, ref).name,
            config::to_text(config::in_slot(station_of(machine, ref).profile, p.address, ref.slot)));
  return fmt::format(
      "it went the other way: turn {}{}`invert` of axes.{}.drives round, or a motor phase; then try its "
      "limit switches by hand again, each must block its own end",
      parameters, parameters.empty() ? "" : " or ", axis.name);
}

/// Which way its coordinate rises, as a person can see it.
std::string up_hint(const config::Machine& machine, const config::Axis& axis) {
  if (axis.id == machine.z) return "+ is up";
  if (machine.u && axis.id == *machine.u) return "+ is down, - is up";
  if (machine.c && axis.id == *machine.c) return "+ is counter-clockwise, seen from above";
  if (!axis.homing || axis.rotary) return "+ is where its coordinate rises";
  const bool home_below = axis.homing->position <= (axis.p_min + axis.p_max) / 2;
  return fmt::format("+ leads {} its home switch", home_below ? "away from" : "towards");
}

/// Waits for a line. What stops the machine meanwhile ends the walk: who stopped it may have changed what it says.
Result<std::string> line(Owner& owner, const WalkTalk& talk) {
  for (;;) {
    if (const Fault fault = owner.latest().latched; fault != Fault::None)
      return fail(fault, "the machine was stopped during the walk; nothing is kept of it, walk anew");
    auto heard = talk.hear();
    if (!heard) return tl::unexpected(heard.error());
    if (*heard) return **heard;
    if (auto alive = owner.idle(); !alive) return tl::unexpected(alive.error());
  }
}

/// What of a simulated machine moves, for a person who cannot stand beside it.
class Watcher {
 public:
  explicit Watcher(Owner& owner) : owner_(owner), start_(look()) {}
  void look_again() {
    const auto now = look();
    if (!start_ || !now) return;
    for (std::size_t i = 0; i < now->size(); ++i)
      if (const double by = (*now)[i] - (*start_)[i]; std::abs(by) > std::abs(farthest_[i])) farthest_[i] = by;
  }
  [[nodiscard]] std::string words(const config::Machine& machine) const {
    if (!start_) return "";
    std::string words;
    for (const config::Axis& axis : machine.axes) {
      const double by = farthest_[axis.id.value];
      if (std::abs(by) < 0.1 * std::abs(job::walk_by(machine, axis))) continue;
      words += fmt::format("{}{} by {:+.3g} {}", words.empty() ? "" : ", ", axis.name,
                           axis.rotary ? units::deg(by) : by, axis.rotary ? "deg" : "mm");
    }
    return "    (the simulated machine: " + (words.empty() ? "nothing moved" : words + " and back") + ")\n";
  }

 private:
  [[nodiscard]] std::optional<AxisVec> look() const {
    return owner_.world() != nullptr ? owner_.world()->axes() : std::nullopt;
  }
  Owner& owner_;
  std::optional<AxisVec> start_;
  AxisVec farthest_{};
};

}  // namespace

Result<Seen> read_seen(const config::Machine& machine, const std::string& text) {
  std::string word;
  for (const char c : text)
    if (!std::isspace(static_cast<unsigned char>(c))) word += c;
  if (word == "nothing" || word == "0") return Seen{};
  const auto bad = [&] {
    return fail(Fault::BadValue, "write the axis that moved and which way it went first, X+ or X-, or `nothing`");
  };
  if (word.size() < 2 || (word.back() != '+' && word.back() != '-')) return bad();
  const bool up = word.back() == '+';
  word.pop_back();
  const auto same = [&](const config::Axis& a) {
    return std::ranges::equal(a.name, word,
                              [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
  };
  const auto axis = std::ranges::find_if(machine.axes, same);
  if (axis == machine.axes.end()) return bad();
  return Seen{axis->name, up};
}

Result<void> judge_seen(const config::Machine& machine, const config::Axis& axis, const Seen& seen) {
  const std::string where = "axis " + axis.name;
  if (seen.axis.empty())
    return fail(Fault::AxisNotAsWired,
                fmt::format("nothing moved: look at the supply and the cables of the motors of {}, and whether a brake "
                            "holds",
                            stations_of(machine, axis)),
                where);
  if (seen.axis != axis.name)
    return fail(Fault::AxisNotAsWired, swapped(machine, axis, *config::find_axis(machine, seen.axis)), where);
  if (seen.up != (job::walk_by(machine, axis) > 0))
    return fail(Fault::AxisNotAsWired, turned_round(machine, axis), where);
  return {};
}

std::vector<const config::Axis*> walk_order(const config::Machine& machine) {
  std::vector<const config::Axis*> order;
  for (const config::Axis& axis : machine.axes)
    if (axis.kind == config::AxisKind::Streamed) order.push_back(&axis);
  const auto comes_first = [&](const config::Axis* a) {
    return a->id == machine.z ? 0 : machine.u && a->id == *machine.u ? 1 : 2;
  };
  std::ranges::stable_sort(order, {}, comes_first);
  return order;
}

namespace {

/// An empty line. What was written before it was asked for does not count.
Result<void> consent(Owner& owner, const WalkTalk& talk) {
  if (talk.forget) talk.forget();
  const auto words = line(owner, talk);
  if (!words) return tl::unexpected(words.error());
  if (std::ranges::all_of(*words, [](unsigned char c) { return std::isspace(c) != 0; })) return {};
  return fail(Fault::Aborted,
              "something else than Enter alone was written where Enter moves the axis: the walk is over, "
              "and nothing is kept of it");
}

Result<Seen> answer(Owner& owner, const config::Machine& machine, const WalkTalk& talk) {
  constexpr int kTries = 3;
  Result<Seen> seen = tl::unexpected(Error{});
  for (int n = 0; n < kTries && !seen; ++n) {
    talk.say("Which axis moved, and which way first? ");
    const auto words = line(owner, talk);
    if (!words) return tl::unexpected(words.error());
    seen = read_seen(machine, *words);
    if (!seen) talk.say(seen.error().message + "\n");
  }
  return seen;
}

/// What earlier walks have said is void; that this is not written anywhere is told beside what was seen.
Error voided(Owner& owner, Error seen) {
  const Result<bool> any = owner.forget_walk();
  if (!any)
    seen.message +=
        fmt::format("; what was kept of earlier walks is wrong now, and could not be voided: {}", any.error().message);
  else if (*any)
    seen.message += "; what was kept of earlier walks, and the drives' accepted serials, is void";
  return seen;
}

}  // namespace

Result<std::vector<const config::Axis*>> walk(Owner& owner, const config::Machine& machine, const WalkTalk& talk) {
  const auto order = walk_order(machine);
  for (const config::Axis* axis : order) {
    talk.say(fmt::format(
        "{} ({}) goes by {}, and back. {}. Nothing knows where the axes stand, and another one may move:\n"
        "keep 1 mm and 3 degrees free around all of them, with a hand at the emergency stop. Enter moves it,\n"
        "anything else ends the walk.\n",
        axis->name, stations_of(machine, *axis), job::walk_in_words(machine, *axis), up_hint(machine, *axis)));
    if (auto go = consent(owner, talk); !go) return tl::unexpected(go.error());
    Watcher watcher(owner);
    owner.on_step([&] {
      watcher.look_again();
      if (talk.poll) talk.poll();
    });
    const auto moved = owner.walk(axis->name);
    owner.on_step(talk.poll);
    if (!moved) return tl::unexpected(moved.error());
    talk.say(watcher.words(machine));
    const Result<Seen> seen = answer(owner, machine, talk);
    if (!seen) return tl::unexpected(seen.error());
    if (auto right = judge_seen(machine, *axis, *seen); !right) return tl::unexpected(voided(owner, right.error()));
  }
  return order;
}

}  // namespace gantry::run
