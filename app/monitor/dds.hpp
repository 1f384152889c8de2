// A thin layer over Cyclone DDS's C interface: entities that delete themselves, and errors as Results.
//   auto p = dds::Participant::open({});                                       // this computer alone
//   auto w = dds::writer(*p, gantry_msg_Event_desc, "gantry/event", dds::Qos().reliable().keep_last(1));
//   dds_write(w->id(), &sample);
// Nothing leaves this computer, and nothing from elsewhere is received, unless an interface is named; then that one
// alone is used. A CYCLONEDDS_URI in the environment is not followed: it would decide this in our place.
#pragma once
#include <dds/dds.h>
#include <string>
#include <utility>

#include "app/monitor/network.hpp"
#include "core/error.hpp"

namespace gantry::monitor::dds {

class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t id) : id_(id) {}
  Entity(Entity&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Entity() {
    if (id_ > 0) dds_delete(id_);
  }
  [[nodiscard]] dds_entity_t id() const { return id_; }

 private:
  dds_entity_t id_ = 0;
};

/// Quality of service, written like a sentence. Defaults are the standard's.
class Qos {
 public:
  Qos() : qos_(dds_create_qos()) {}
  Qos(const Qos&) = delete;
  Qos& operator=(const Qos&) = delete;
  ~Qos() { dds_delete_qos(qos_); }
  Qos& reliable() { return dds_qset_reliability(qos_, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100)), *this; }
  Qos& best_effort() { return dds_qset_reliability(qos_, DDS_RELIABILITY_BEST_EFFORT, 0), *this; }
  Qos& keep_last(int depth) { return dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, depth), *this; }
  /// A reader hears nothing that its own participant writes.
  Qos& of_others() { return dds_qset_ignorelocal(qos_, DDS_IGNORELOCAL_PARTICIPANT), *this; }
  /// Who comes late gets the last `depth` samples.
  Qos& for_latecomers(int depth) {
    dds_qset_durability(qos_, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos_, 0, DDS_HISTORY_KEEP_LAST, depth, -1, -1, -1);
    return *this;
  }
  /// An instance ends where the writer says so, and not because it has gone.
  Qos& disposed_by_hand() { return dds_qset_writer_data_lifecycle(qos_, false), *this; }
  /// What the endpoint announces of itself in discovery.
  Qos& user_data(const std::string& text) { return dds_qset_userdata(qos_, text.data(), text.size()), *this; }
  [[nodiscard]] const dds_qos_t* get() const { return qos_; }

 private:
  dds_qos_t* qos_;
};

class Participant {
 public:
  /// Confines the network sockets of this process to one device, for good. Fault::Usage for options that cannot be,
  /// Fault::Refused for a second device in one process, Fault::DdsUnusable with DDS's own reason or when a socket would
  /// be open to other devices.
  static Result<Participant> open(const NetworkOptions& options);
  [[nodiscard]] dds_entity_t id() const { return participant_.id(); }

 private:
  Entity domain_;  // deleted last
  Entity participant_;
};

/// The topic belongs to the participant and goes with it.
Result<Entity> writer(const Participant& participant, const dds_topic_descriptor_t& type, const char* topic,
                      const Qos& qos);
Result<Entity> reader(const Participant& participant, const dds_topic_descriptor_t& type, const char* topic,
                      const Qos& qos);

/// Takes what has come, one at a time: `use(sample, info)`, T as its C type. Where info.valid_data is false only the
/// key is: an instance has ended. Returns how many.
template <class T, class Use>
int take_changes(const Entity& reader, Use&& use) {
  int taken = 0;
  for (;;) {
    void* sample = nullptr;  // the reader lends it
    dds_sample_info_t info{};
    const auto n = dds_take(reader.id(), &sample, &info, 1, 1);
    if (n <= 0) return taken;
    use(*static_cast<const T*>(sample), info);
    ++taken;
    dds_return_loan(reader.id(), &sample, n);
  }
}

/// The same of valid data alone.
template <class T, class Use>
int take_all(const Entity& reader, Use&& use) {
  int valid = 0;
  take_changes<T>(reader, [&](const T& sample, const dds_sample_info_t& info) {
    if (!info.valid_data) return;
    use(sample, info);
    ++valid;
  });
  return valid;
}

}  // namespace gantry::monitor::dds
