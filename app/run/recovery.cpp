#include "app/run/recovery.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/log.hpp"

namespace gantry::run {
namespace {

constexpr double kLookEvery_s = 0.1;  // between two rounds
constexpr CycleIndex kWhole = 20;     // cycles in a row with all stations before they count as back
constexpr double kLong_s = 0.02;      // of an attempt after which the next idle step goes on
constexpr double kMostWait_s = 10;    // between two attempts at a station that refuses
constexpr double kTellAgain_s = 10;   // in which a station's reason is not told again

}  // namespace

void Recovery::step(Control& control) {
  const cycle::Snapshot& now = control.latest();
  now_ns_ = now.time_ns;
  if (now.complete && now.operational) {
    short_since_ = -1;
    if (whole_since_ < 0) whole_since_ = now.cycle;
    if (now.cycle - whole_since_ >= kWhole) tell_all_back();
    return;
  }
  whole_since_ = -1;
  if (short_since_ < 0) short_since_ = now.cycle;
  if (now.cycle - short_since_ < control.cycles(kLookEvery_s)) return;

  away_.resize(bus_.station_count());
  bus_.step_by([&control] { control.step(); });
  bool ended = true;
  while (next_ < away_.size()) {
    const std::size_t i = next_++;
    Away& away = away_[i];
    const CycleIndex begin = control.latest().cycle;
    if (begin < away.not_before) continue;
    const auto back = bus_.recover(i);
    const CycleIndex end = control.latest().cycle;
    away.seen |= !back || back->has_value();
    if (!back) failed(away, back.error(), control);
    if (back && *back) returned(i, **back);
    if (!back && back.error().fault == Fault::BusDown) next_ = away_.size();  // what is true of one is true of all
    ended = end - begin < control.cycles(kLong_s);
    if (!ended) break;
  }
  bus_.step_by({});
  if (!ended && next_ < away_.size()) return;
  next_ = 0;
  short_since_ = control.latest().cycle;
}

void Recovery::returned(std::size_t i, const devices::Recovered& back) {
  const devices::BusStation& s = bus_.station(i);
  if (back.restarted && s.config != nullptr && s.config->profile.drive) restarted_.push_back(s.id);
  std::string words = fmt::format("{}: takes part again; it was {}", s.where, back.found);
  if (const std::string said = told(Fault::StationLeftOp, static_cast<int>(i), std::move(words)); !said.empty())
    log::info("{}", said);
}

void Recovery::failed(Away& away, const Error& why, const Control& control) {
  const CycleIndex now = control.latest().cycle;
  const bool silent = why.fault == Fault::StationMissing || why.fault == Fault::BusDown;
  away.wait_s = silent ? 0 : std::clamp(2 * away.wait_s, kLookEvery_s, kMostWait_s);
  away.not_before = now + control.cycles(away.wait_s);
  const bool news =
      away.told != why.fault && (away.told == Fault::None || now - away.told_at >= control.cycles(kTellAgain_s));
  if (!news && !silent) log::debug("recovery: {}", to_text(why));
  if (!news) return;
  away.told = why.fault, away.told_at = now;
  const auto of = static_cast<int>(&away - away_.data());
  if (const std::string said = told(why.fault, of, to_text(why)); !said.empty()) log::warn("{}", said);
}

void Recovery::tell_all_back() {
  const bool any = std::any_of(away_.begin(), away_.end(), [](const Away& a) { return a.seen; });
  away_.clear();
  next_ = 0;
  if (!any) return;
  const std::string said =
      told(Fault::None, -1, "every station takes part again; reset, then enable and home the axes that were away");
  if (!said.empty()) log::info("{}", said);
}

std::string Recovery::told(Fault fault, int of, std::string words) {
  const auto now = notes_.tell({fault, of}, now_ns_, std::move(words));
  return now ? now->note + stations::again(now->count) : "";
}

}  // namespace gantry::run
