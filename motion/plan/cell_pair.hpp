// A body of the head and a standing one, as seen by cells of positions: in a cell the pair never meets, always meets,
// or it depends. For cells.hpp.
#pragma once
#include <array>
#include <optional>

#include "motion/plan/difference.hpp"

namespace gantry::motion {

/// An axis-aligned cell of positions; index 0, 1, 2 is X, Y, Z.
struct Cell {
  std::array<double, 3> low{}, high{};
  [[nodiscard]] Vec3 centre() const { return {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2}; }
  [[nodiscard]] Vec3 half() const { return {(high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[2] - low[2]) / 2}; }
};

/// Where a cell is cut in two.
struct Cut {
  std::size_t axis = 0;
  double at = 0;
};

class CellPair {
 public:
  /// A cell counts as blocked while the pair keeps no more than the margin and this. So a cut between what is free and
  /// what is blocked finds room, and a gap that leaves no more than this counts as none.
  static constexpr double kBlur_mm = 1e-6;

  CellPair(const Difference& difference, double margin_mm);

  /// They keep more than the margin wherever in the cell the head is.
  [[nodiscard]] bool free(const Cell& cell) const;
  /// They are within the margin and kBlur_mm wherever in the cell the head is.
  [[nodiscard]] bool blocked(const Cell& cell) const;
  /// The cut that tells most; nothing when the cell is too small to be cut.
  [[nodiscard]] std::optional<Cut> cut(const Cell& cell) const;
  /// Face of the pair across `axis` within the cell that is nearest to `middle`.
  [[nodiscard]] std::optional<double> face(const Cell& cell, std::size_t axis, double middle) const;
  /// Its upright faces that stand askew: the direction of each (unit, x and y above 0) goes to `tell`.
  template <class Tell>
  void tell_askew(const Tell& tell) const {
    for (const Vec2 g : d_.generator) {
      const double length = norm(g);
      if (!(length > 0)) continue;
      const Vec2 unit = g * (1 / length);
      if (std::abs(unit.x) < kAligned || std::abs(unit.y) < kAligned) continue;
      tell((unit.x > 0) == (unit.y > 0) ? Vec2{std::abs(unit.x), std::abs(unit.y)}
                                        : Vec2{std::abs(unit.y), std::abs(unit.x)});
    }
  }
  /// Share of the cell that its box covers.
  [[nodiscard]] double share(const Cell& cell) const;

 private:
  static constexpr double kAligned = 1e-14;
  Difference d_;
  double margin_ = 0;
  bool aligned_ = false;              ///< its figure stands along X and Y
  std::array<double, 3> at_{};        ///< its centre
  std::array<double, 3> reach_{};     ///< of everything that collides, from the centre
  std::array<double, 3> straight_{};  ///< of the part whose faces are planes across the axes; below 0: there is none
};

}  // namespace gantry::motion
