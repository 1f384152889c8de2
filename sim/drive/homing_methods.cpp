#include "sim/drive/homing_methods.hpp"

#include <algorithm>
#include <array>

#include "sim/drive/motor.hpp"

namespace gantry::sim {
namespace {

constexpr bool kFast = true, kSlow = false, kCloses = true, kOpens = false;

// Limit switch.
constexpr std::array k17Off{HomingPhase{-1, kFast, kNegLimit, kCloses}, HomingPhase{+1, kSlow, kNegLimit, kOpens}};
constexpr std::array k17On{HomingPhase{+1, kSlow, kNegLimit, kOpens}};
constexpr std::array k18Off{HomingPhase{+1, kFast, kPosLimit, kCloses}, HomingPhase{-1, kSlow, kPosLimit, kOpens}};
constexpr std::array k18On{HomingPhase{-1, kSlow, kPosLimit, kOpens}};

// Home switch alone.
constexpr std::array k19Off{HomingPhase{+1, kFast, kHome, kCloses}, HomingPhase{-1, kSlow, kHome, kOpens}};
constexpr std::array k19On{HomingPhase{-1, kSlow, kHome, kOpens}};
constexpr std::array k20Off{HomingPhase{+1, kSlow, kHome, kCloses}};
constexpr std::array k20On{HomingPhase{-1, kFast, kHome, kOpens}, HomingPhase{+1, kSlow, kHome, kCloses}};
constexpr std::array k21Off{HomingPhase{-1, kFast, kHome, kCloses}, HomingPhase{+1, kSlow, kHome, kOpens}};
constexpr std::array k21On{HomingPhase{+1, kSlow, kHome, kOpens}};
constexpr std::array k22Off{HomingPhase{-1, kSlow, kHome, kCloses}};
constexpr std::array k22On{HomingPhase{+1, kFast, kHome, kOpens}, HomingPhase{-1, kSlow, kHome, kCloses}};

// Home switch with the positive limit to turn round at.
constexpr std::array k23Off = k19Off;
constexpr std::array k23Bounced{HomingPhase{-1, kFast, kHome, kCloses}, HomingPhase{-1, kSlow, kHome, kOpens}};
constexpr std::array k23On = k19On;
constexpr std::array k24Off{HomingPhase{+1, kFast, kHome, kCloses}, HomingPhase{-1, kSlow, kHome, kOpens},
                            HomingPhase{+1, kSlow, kHome, kCloses}};
constexpr std::array k24Bounced{HomingPhase{-1, kFast, kHome, kCloses}, HomingPhase{-1, kSlow, kHome, kOpens},
                                HomingPhase{+1, kSlow, kHome, kCloses}};
constexpr std::array k24On{HomingPhase{-1, kSlow, kHome, kOpens}, HomingPhase{+1, kSlow, kHome, kCloses}};
constexpr std::array k25Off{HomingPhase{+1, kFast, kHome, kCloses}, HomingPhase{+1, kSlow, kHome, kOpens},
                            HomingPhase{-1, kSlow, kHome, kCloses}};
constexpr std::array k25Bounced{HomingPhase{-1, kFast, kHome, kCloses}, HomingPhase{+1, kSlow, kHome, kOpens},
                                HomingPhase{-1, kSlow, kHome, kCloses}};
constexpr std::array k25On{HomingPhase{+1, kSlow, kHome, kOpens}, HomingPhase{-1, kSlow, kHome, kCloses}};
constexpr std::array k26Off{HomingPhase{+1, kFast, kHome, kCloses}, HomingPhase{+1, kSlow, kHome, kOpens}};
constexpr std::array k26Bounced{HomingPhase{-1, kFast, kHome, kCloses}, HomingPhase{+1, kSlow, kHome, kOpens}};
constexpr std::array k26On{HomingPhase{+1, kSlow, kHome, kOpens}};

// 27 to 30 are 23 to 26 seen in a mirror, with the negative limit.
template <std::size_t N>
constexpr std::array<HomingPhase, N> mirrored(std::array<HomingPhase, N> phases) {
  for (auto& p : phases) p.direction = static_cast<std::int8_t>(-p.direction);
  return phases;
}
constexpr auto k27Off = mirrored(k23Off), k27Bounced = mirrored(k23Bounced);
constexpr auto k27On = mirrored(k23On);
constexpr auto k28Off = mirrored(k24Off), k28Bounced = mirrored(k24Bounced);
constexpr auto k28On = mirrored(k24On);
constexpr auto k29Off = mirrored(k25Off), k29Bounced = mirrored(k25Bounced);
constexpr auto k29On = mirrored(k25On);
constexpr auto k30Off = mirrored(k26Off), k30Bounced = mirrored(k26Bounced);
constexpr auto k30On = mirrored(k26On);

constexpr std::array kMethods{
    HomingMethod{17, kNegLimit, k17Off, k17On, {}, 0},
    HomingMethod{18, kPosLimit, k18Off, k18On, {}, 0},
    HomingMethod{19, kHome, k19Off, k19On, {}, 0},
    HomingMethod{20, kHome, k20Off, k20On, {}, 0},
    HomingMethod{21, kHome, k21Off, k21On, {}, 0},
    HomingMethod{22, kHome, k22Off, k22On, {}, 0},
    HomingMethod{23, kHome, k23Off, k23On, k23Bounced, kPosLimit},
    HomingMethod{24, kHome, k24Off, k24On, k24Bounced, kPosLimit},
    HomingMethod{25, kHome, k25Off, k25On, k25Bounced, kPosLimit},
    HomingMethod{26, kHome, k26Off, k26On, k26Bounced, kPosLimit},
    HomingMethod{27, kHome, k27Off, k27On, k27Bounced, kNegLimit},
    HomingMethod{28, kHome, k28Off, k28On, k28Bounced, kNegLimit},
    HomingMethod{29, kHome, k29Off, k29On, k29Bounced, kNegLimit},
    HomingMethod{30, kHome, k30Off, k30On, k30Bounced, kNegLimit},
    HomingMethod{35, 0, {}, {}, {}, 0},
};

}  // namespace

HomingList HomingMethod::start_list(std::uint32_t inputs) const noexcept {
  if ((inputs & reference) != 0) return on;
  return (inputs & bounce) != 0 ? bounced : off;
}

const HomingMethod* homing_method(int number) noexcept {
  const auto at = std::find_if(kMethods.begin(), kMethods.end(), [&](const auto& m) { return m.number == number; });
  return at != kMethods.end() ? &*at : nullptr;
}

}  // namespace gantry::sim
