// One motor of the virtual plant with what it carries: the axis behind it moves in continuous time, so that switches
// and the probe are met at the instant of contact and not at the next tick. A virtual drive commands it, the world
// reads where it is.
//   motor.run(piece, dt, watch)  ->  how far it got, and the first watched edge on the way
// All coordinates are those of the machine axis (mm or rad); inverting and counts belong to the drive.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "config/machine.hpp"

namespace gantry::sim {

/// Command of the drive's own trajectory: p + v t + a t^2 / 2, t from 0.
struct CommandPiece {
  double p = 0, v = 0, a = 0;
};

/// Inputs as bits: what a drive can see of its axis.
enum MotorInput : std::uint32_t { kNegLimit = 1, kPosLimit = 2, kHome = 4, kProbe = 8 };

/// An input, and where on the axis it changes.
struct Threshold {
  std::uint32_t input = 0;
  double edge = 0;
  bool closed_below = false;  ///< closed at and below the edge; else at and above

  [[nodiscard]] bool closed(double x) const noexcept { return closed_below ? x <= edge : x >= edge; }
};

struct Ran {
  double elapsed_s = 0;       ///< <= dt; shorter when a watched input changed
  std::uint32_t changed = 0;  ///< bits of the inputs that changed at that instant
  double position = 0;        ///< actual coordinate there
};

class Motor {
 public:
  explicit Motor(const config::SimAxis& truth);

  /// Moves for at most `dt` under the command; stops at the first change of an input in `watch`. The axis follows its
  /// command through a pure delay (SimAxis::delay_s) and a first-order lag (time constant SimAxis::lag_s), solved
  /// exactly; within 1e-9 of a standing command it stands exactly on it, so that a run repeats to the bit.
  Ran run(const CommandPiece& command, double dt, std::uint32_t watch) noexcept;

  /// The same without torque: nothing but friction slows the axis down (SimAxis::coast), whatever was commanded.
  Ran coast(double dt, std::uint32_t watch) noexcept;

  [[nodiscard]] bool runs_out() const noexcept { return truth_.coast > 0; }
  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Switch and probe levels at this position; home is closed on the side that SimAxis::home_active_below names.
  [[nodiscard]] std::uint32_t inputs() const noexcept;

  /// The world tells at which coordinate the probe on this axis closes (it closes at and below it); far away when there
  /// is nothing under it.
  void set_contact(double coordinate) noexcept { edges_.back().edge = coordinate; }
  /// Script: the axis is held by an obstacle.
  void set_stalled(bool stalled) noexcept { stalled_ = stalled; }
  /// Script: the brake does not hold; without torque the axis moves by so much a second.
  void set_slipping(double per_s) noexcept { slipping_ = per_s; }
  [[nodiscard]] double slipping() const noexcept { return slipping_; }
  /// Puts the motor somewhere, at rest; commands still on their way are forgotten.
  void restore(double position) noexcept;
  /// As the constructor left it.
  void renew() noexcept { *this = Motor(truth_); }

 private:
  struct Delayed {
    CommandPiece command;
    double dt = 0;
  };
  Ran follow(const CommandPiece& command, double lag_s, double dt, std::uint32_t watch) noexcept;
  void remember(const CommandPiece& command, double dt) noexcept;

  config::SimAxis truth_;
  static constexpr double kNoContact = -1e9;
  std::array<Threshold, 4> edges_;  ///< the probe last
  double position_ = 0, velocity_ = 0;
  double faded_s_ = -1, faded_lag_s_ = 0, faded_ = 0;  ///< e^(-t/lag) of the last t, the same in most cycles
  bool stalled_ = false;
  double slipping_ = 0;
  std::array<Delayed, 64> delayed_{};  ///< commands not yet acted on, oldest first; together delay_s long
  std::size_t first_ = 0, waiting_ = 0;
};

}  // namespace gantry::sim
