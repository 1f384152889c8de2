// Names and qualities of the topics, the same for those who write and those who read, and how values of the machine
// become samples.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/monitor/dds.hpp"
#include "app/monitor/shared_values.hpp"
#include "gantry_topics.h"
#include "ros_joint_state.h"

namespace gantry::monitor {

inline constexpr const char* kStateTopic = "gantry/state";
inline constexpr const char* kEventTopic = "gantry/event";
inline constexpr const char* kAlarmTopic = "gantry/alarm";
inline constexpr const char* kJobTopic = "gantry/job";
inline constexpr const char* kJointTopic = "rt/joint_states";  ///< ROS 2 calls it /joint_states
inline constexpr int kEventsKept = 256;                        ///< for who comes late

/// What ROS 2 expects in the user data of a writer: the hash of sensor_msgs/msg/JointState (REP 2016).
inline constexpr const char* kJointStateHash =
    "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;";

/// A sample of MachineState with the memory its sequences need. Not to be copied: the sample points into it.
class StateSample {
 public:
  StateSample() = default;
  StateSample(const StateSample&) = delete;
  StateSample& operator=(const StateSample&) = delete;
  /// Everything but seq, age_s and what the publisher alone knows: events_lost, events_next, alarms_active, job_known.
  void set(const MachineInfo& info, std::uint64_t session, const SharedSnapshot& shared);
  gantry_msg_MachineState sample{};

 private:
  std::array<gantry_msg_AxisState, kMaxAxes> axes_{};
  std::array<gantry_msg_Name, 32> outputs_{}, inputs_{};
};

/// sensor_msgs/JointState in ROS's units, metres and radians. Velocity and effort stay empty: the bus does not tell
/// them.
class JointSample {
 public:
  JointSample() = default;
  JointSample(const JointSample&) = delete;
  JointSample& operator=(const JointSample&) = delete;
  void set(const MachineInfo& info, const SharedSnapshot& shared);
  sensor_msgs_msg_dds__JointState_ sample{};

 private:
  std::array<std::string, kMaxAxes> name_text_;
  std::array<char*, kMaxAxes> names_{};
  std::array<double, kMaxAxes> positions_{};
  std::string frame_;
};

gantry_msg_Event event_sample(const MachineInfo& info, std::uint64_t session, std::uint64_t number,
                              const SharedEvent& shared);
gantry_msg_Alarm alarm_sample(const MachineInfo& info, std::uint64_t session, const SharedAlarm& shared);
gantry_msg_JobStatus job_sample(const MachineInfo& info, std::uint64_t session, std::int64_t time_ns,
                                const SharedJob& shared);

}  // namespace gantry::monitor
