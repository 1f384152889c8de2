// A publisher's look-out for another machine of its name. It asks for the states of others only while one announces
// itself under that name, and believes it when it speaks: an owner that has just died may still be announced.
//   NamesakeWatch watch;   watch.open(participant, self);   watch.poll(now);     // logs what it finds
#pragma once
#include <map>
#include <set>

#include "app/monitor/dds.hpp"
#include "app/monitor/line_limit.hpp"
#include "app/monitor/namesakes.hpp"

namespace gantry::monitor {

/// Whose writer sent the samples with this handle; nothing when it is not known any more or says nothing of itself.
std::optional<Speaker> speaker_of(const dds::Entity& reader, dds_instance_handle_t publication);

class NamesakeWatch {
 public:
  Result<void> open(const dds::Participant& participant, Speaker self);
  void poll(Time now);

 private:
  void look();
  void listen(Time now);

  const dds::Participant* participant_ = nullptr;
  Speaker self_;
  dds::Entity announcements_, states_;
  std::map<dds_instance_handle_t, Speaker> others_;  // who announces himself under our name
  std::set<std::uint64_t> told_;
  LineLimit limit_;
  bool listening_ = false;
};

}  // namespace gantry::monitor
