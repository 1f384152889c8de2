// Objects that no PDO of a station carries, by SDO while the loop runs: what the loop wants is written, what it looks
// at is read again and again. One thing at a time, so that the mailbox stays free for others.
//   if (slow_object_is_due(image, now)) serve_slow_objects(link, station, image);        // run thread, often
#pragma once
#include <string>
#include <vector>

#include "devices/ethercat/bent_image.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// There is something to write or to look at.
[[nodiscard]] bool slow_object_is_due(BentImage& image, Time now);
/// The last transfer of each was answered.
[[nodiscard]] bool slow_objects_answer(BentImage& image);
/// At most one transfer, or for a mode that the loop has changed, the write and the look at what became of it.
void serve_slow_objects(Link& link, StationRecord& station, BentImage& image);
/// Into `news`: inputs that have fallen silent, or answer again; outputs that the station does not take.
void tell_silence(const StationRecord& station, BentImage& image, Time now, std::vector<std::string>& news);
/// The station was away: what it has is not known any more, and is written and read anew.
void forget_slow_objects(BentImage& image);

}  // namespace gantry::devices
