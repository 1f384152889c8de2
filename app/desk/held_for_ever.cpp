#include "app/desk/held_for_ever.hpp"

#include <fmt/format.h>

namespace gantry::desk {

void HeldForEver::poll() {
  constexpr Time kLook = std::chrono::seconds(1);
  constexpr int kLooks = 2;  // what was pressed before the first may not have acted yet
  const CycleIndex now = owner_.latest().cycle;
  const auto stopped = owner_.stopped();
  if (!owner_.held() || owner_.world() == nullptr || (ends_ == Ends::Stops && !stopped)) {
    since_.reset();
    return;
  }
  if (!since_) since_ = asked_ = now, nothing_left_ = 0;
  if ((now - asked_) * cycle_ < kLook) return;
  asked_ = now;
  const auto hold = owner_.world()->scripted_input(static_cast<unsigned>(config::Input::Hold));
  nothing_left_ = hold.more ? 0 : nothing_left_ + 1;
  if (nothing_left_ < kLooks && (now - *since_) * cycle_ < kLongest) return;
  if (stopped) return owner_.interrupt(*stopped);
  const auto place = hold.entry.find(": ");
  const std::string where = place == std::string::npos ? "" : hold.entry.substr(0, place);
  owner_.interrupt(
      {Fault::Inconsistent,
       fmt::format("the dry run stands on hold{}, and nobody resumes it; write an entry behind it that presses start, "
                   "such as {{at: ..., after: 2 s, do: press, input: start, hold: 100 ms}}",
                   place == std::string::npos ? "" : " by '" + hold.entry.substr(place + 2) + "'"),
       where});
}

}  // namespace gantry::desk
