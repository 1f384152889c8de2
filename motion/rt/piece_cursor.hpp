// A moment in the planned time of the pieces of a path that wait in the ring.
//   PieceCursor at(ring, 0, t);   if (at.advance(0.001) == PieceCursor::Met::Piece) ... at.piece(), at.t()
// Time that is left at the end of a piece goes on in the next one. Lives in the loop.
#pragma once
#include <cstdint>

#include "core/rt/ring.hpp"
#include "motion/profile/speed_profile.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

using SegmentRing = rt::Ring<Segment, 1024>;

class PieceCursor {
 public:
  enum class Met : std::uint8_t {
    Piece,    ///< the time is on a piece
    Rest,     ///< the path rests before that, and so does the cursor
    Unknown,  ///< the next piece is not there yet
  };

  /// The n-th waiting segment is a piece, and it is at time t.
  PieceCursor(SegmentRing& ring, std::size_t n, double t) noexcept : ring_(&ring), n_(n), t_(t) {}

  Met advance(double dt) noexcept {
    t_ += dt;
    for (;;) {
      const Segment& here = piece();
      const double end = duration(here.nominal);
      if (t_ < end) return Met::Piece;
      if (here.rests) return t_ = end, Met::Rest;
      const Segment* next = ring_->peek(n_ + 1);
      if (next == nullptr || next->block != here.block || next->kind != SegmentKind::Piece) return Met::Unknown;
      t_ -= end;
      ++n_;
    }
  }

  [[nodiscard]] const Segment& piece() const noexcept { return *ring_->peek(n_); }
  [[nodiscard]] double t() const noexcept { return t_; }

 private:
  SegmentRing* ring_;
  std::size_t n_;
  double t_;
};

}  // namespace gantry::motion
