#include "sim/machine/bus_actions.hpp"

#include <algorithm>
#include <cmath>

#include "sim/segment/segment.hpp"

namespace gantry::sim {

namespace {

struct Doing {
  Segment& segment;
  const config::Machine& machine;

  void operator()(const act::CutLink& a) { segment.cut_link(link_to(a.station)); }
  void operator()(const act::HealLink& a) { segment.heal_link(link_to(a.station)); }
  void operator()(const act::LoseFrames& a) { segment.lose_frames(a.count); }
  void operator()(const act::CorruptFrames& a) { segment.faults().corrupt(a.count); }
  void operator()(const act::CorruptHeaders& a) { segment.faults().corrupt_headers(a.count); }
  void operator()(const act::DuplicateFrames& a) { segment.faults().duplicate(a.count); }
  void operator()(const act::ReorderFrames& a) { segment.faults().reorder(a.count); }
  void operator()(const act::ForeignFrames& a) { segment.faults().add_foreign(a.count); }
  void operator()(const act::DelayFrames& a) { segment.faults().delay(a.count, a.by); }
  void operator()(const act::Noise& a) { segment.faults().set_noise(a.shares); }
  void operator()(const act::Drift& a) { segment.set_clock_drift(a.station, a.ppm); }
  void operator()(const act::Jitter& a) {
    segment.set_clock_jitter(a.station, static_cast<std::uint32_t>(a.by.count()));
  }
  void operator()(const act::CountErrors& a) { segment.count_errors(a.station, a.port, a.count); }
  void operator()(const act::StickStatusword& a) {
    if (segment.has_motor(a.axis, a.drive)) segment.stick_statusword(a.axis, a.drive, a.stuck);
  }
  void operator()(const act::IgnoreWrites& a) {
    segment.ignore_writes(a.station, a.object.value_or(config::ObjectAddress{}));
  }
  void operator()(const act::SlowMailbox& a) { segment.slow_mailbox(a.station, a.by); }
  void operator()(const act::HeedWrites& a) { segment.ignore_writes(a.station, std::nullopt); }
  void operator()(const act::SetObject& a) { segment.set_object(a.station, a.object, std::llround(a.value)); }
  void operator()(const act::DriveFault& a) {
    if (segment.has_motor(a.axis, a.drive)) segment.drive_fault(a.axis, a.drive, a.code);
  }
  void operator()(const act::Stall& a) {
    for (int drive = 0; segment.has_motor(a.axis, drive); ++drive) segment.motor(a.axis, drive).set_stalled(a.held);
  }
  void operator()(const act::SlipBrake& a) {
    for (int drive = 0; segment.has_motor(a.axis, drive); ++drive)
      if (!a.drive || *a.drive == drive) segment.motor(a.axis, drive).set_slipping(a.per_s);
  }
  void operator()(const act::PowerOff& a) { segment.power_off(a.station); }
  void operator()(const act::PowerOn& a) { segment.power_on(a.station); }
  void operator()(const act::PowerCycle& a) { segment.power_cycle(a.station, a.dark); }
  /// The drives' common supply. Stations without a drive have one of their own.
  void operator()(const act::EmergencyStop& a) {
    for (const config::Station& s : machine.stations)
      if (s.bus == config::BusKind::EtherCat && s.profile.drive)
        a.pressed ? segment.power_off(s.id) : segment.power_on(s.id);
  }

 private:
  [[nodiscard]] int link_to(StationId station) const {
    const auto at = std::find_if(machine.stations.begin(), machine.stations.end(),
                                 [&](const config::Station& s) { return s.id == station; });
    return at == machine.stations.end() ? -1 : at->position;
  }
};

}  // namespace

void do_action(const BusAction& action, Segment& segment, const config::Machine& machine) {
  Doing doing{segment, machine};
  std::visit(doing, action);
}

}  // namespace gantry::sim
