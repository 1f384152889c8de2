#include "devices/rt/sender_watch.hpp"

namespace gantry::devices {

/// Its own, or the one that nobody has used for longest.
SenderWatch::Row& SenderWatch::row_of(const MacAddress& sender, std::uint32_t sequence) noexcept {
  Row* oldest = &rows_[0];
  for (Row& row : rows_) {
    if (row.frames != 0 && row.sender == sender) return row;
    const bool free = row.frames == 0, longer_ago = sequence - row.last > sequence - oldest->last;
    if (oldest->frames != 0 && (free || longer_ago)) oldest = &row;
  }
  *oldest = {.sender = sender, .first = sequence};
  return *oldest;
}

void SenderWatch::heard(const MacAddress& sender, std::uint32_t sequence) noexcept {
  Row& row = row_of(sender, sequence);
  if (!row.known && sequence - row.first >= kAmong) row.first = sequence, row.frames = 0;
  row.last = sequence;
  ++row.frames;
  if (!row.known && row.frames < kEnough) return;
  const std::uint64_t before = other_ ? other_->frames : 0;
  other_ = OtherMaster{.address = sender, .frames = before + (row.known ? 1 : row.frames)};
  row.known = true;
}

}  // namespace gantry::devices
