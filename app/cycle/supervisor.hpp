// Watches what every cycle brings and names what is wrong; what is then done stands in the fault catalogue. It keeps
// only counters.
//   Findings f = supervisor.look(view);   for (const Finding& x : f) react(x.fault, x.axis, x.detail);
// RT.
#pragma once
#include <bitset>
#include <cstdint>

#include "app/cycle/axes.hpp"
#include "app/cycle/channels.hpp"
#include "app/cycle/loop_setup.hpp"
#include "app/cycle/pacer.hpp"
#include "devices/bus.hpp"

namespace gantry::cycle {

struct Finding {
  Fault fault = Fault::None;
  AxisId axis = kNoAxis;
  std::int32_t detail = 0;
  StationId station = kNoStation;
  double value = 0;  ///< of the axis, mm or rad, where the fault is about a position
};
using Findings = rt::FixedVector<Finding, 32>;

/// What one cycle showed.
struct View {
  const Beat& beat;
  const devices::Exchange& exchange;
  const Axes& axes;
  const AxisVec& target;  ///< as sent in this cycle
  std::uint32_t inputs = 0;
  State state = State::Offline;
  Time compute{};                  ///< own work of the last cycle
  Purpose purpose = Purpose::Job;  ///< of what plays
};

class Supervisor {
 public:
  explicit Supervisor(const LoopSetup& setup) : setup_(setup) {}
  Findings look(const View& view) noexcept;

 private:
  void look_at_time(const View& view, Findings& found) noexcept;
  void look_at_bus(const View& view, Findings& found) noexcept;
  void look_at_clocks(const View& view, Findings& found) noexcept;
  void look_at_drives(const View& view, Findings& found) noexcept;
  void look_at_rest(const View& view, std::size_t drive, Findings& found) noexcept;
  void look_at_axes(const View& view, Findings& found) noexcept;
  void look_at_targets(const View& view, AxisId id, Findings& found) noexcept;
  void look_at_inputs(const View& view, Findings& found) noexcept;

  /// A station's clock beyond one bound. One that strays to both sides passes the middle now and then: only when it
  /// has been within for a while is it over.
  struct Apart {
    CycleIndex since = -1, last = -1;
    bool told = false;
  };
  /// True when it is beyond the bound, and has been for long enough.
  [[nodiscard]] bool lasts(Apart& apart, bool beyond, CycleIndex now) const noexcept;

  /// A drive without torque.
  struct Rest {
    CycleIndex since = -1;  ///< -1: it has torque, or is away
    double at = 0;          ///< where its brake has closed
    bool held = false;      ///< the machine has closed its brake before the torque went
  };

  const LoopSetup& setup_;
  bool operational_ = false;  ///< all stations were in OP before
  int frames_lost_ = 0, counter_low_ = 0;
  std::bitset<kMostInLateWindow> late_;  ///< cycles of the late window, in a ring
  std::size_t late_at_ = 0;              ///< the newest
  int late_in_window_ = 0;
  std::array<std::uint16_t, kMaxDrives> last_code_{};
  std::array<Apart, kMaxStations> drifts_{}, lost_{};  ///< by StationId
  bool clocks_asked_ = false;                          ///< something stands in these
  std::bitset<kMaxDrives> dropped_;                    ///< as last seen
  std::bitset<kMaxDrives> torque_;                     ///< as last seen
  std::array<Rest, kMaxDrives> rest_{};
  std::array<std::int64_t, kMaxAxes> over_window_{};  ///< cycles in a row outside the following window
  std::array<std::int64_t, kMaxAxes> short_{};        ///< cycles in a row in which an open-loop axis stood short
  std::array<std::int64_t, kMaxDrives> strayed_{};    ///< cycles in a row in which it was not said to follow
};

}  // namespace gantry::cycle
