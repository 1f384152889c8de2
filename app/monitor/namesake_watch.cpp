#include "app/monitor/namesake_watch.hpp"

#include <algorithm>

#include "app/monitor/topics.hpp"
#include "core/log.hpp"

namespace gantry::monitor {
namespace {

constexpr int kMostOthers = 64;

std::optional<Speaker> speaker_of(const dds_builtintopic_endpoint_t& writer) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(writer.qos, &data, &size) || data == nullptr) return std::nullopt;
  const auto speaker = announced({static_cast<const char*>(data), size});
  dds_free(data);
  return speaker;
}

}  // namespace

std::optional<Speaker> speaker_of(const dds::Entity& reader, dds_instance_handle_t publication) {
  auto* writer = dds_get_matched_publication_data(reader.id(), publication);
  if (writer == nullptr) return std::nullopt;
  auto speaker = speaker_of(*writer);
  dds_builtintopic_free_endpoint(writer);
  return speaker;
}

Result<void> NamesakeWatch::open(const dds::Participant& participant, Speaker self) {
  participant_ = &participant;
  self_ = std::move(self);
  const auto reader = dds_create_reader(participant.id(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  if (reader < 0) return fail(Fault::DdsUnusable, std::string("DDS announces no others: ") + dds_strretcode(reader));
  announcements_ = dds::Entity(reader);
  return {};
}

void NamesakeWatch::poll(Time now) {
  look();
  if (others_.empty()) {
    if (listening_) states_ = dds::Entity();
    listening_ = false;
    told_.clear();
    return;
  }
  listen(now);
}

void NamesakeWatch::look() {
  for (;;) {
    void* sample = nullptr;  // the reader lends it
    dds_sample_info_t info{};
    const auto n = dds_take(announcements_.id(), &sample, &info, 1, 1);
    if (n <= 0) return;
    if (info.instance_state != DDS_IST_ALIVE) {
      others_.erase(info.instance_handle);
    } else if (info.valid_data) {
      const auto& writer = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
      auto other = std::string_view(writer.topic_name) == kStateTopic ? speaker_of(writer) : std::nullopt;
      if (other && other->machine == self_.machine && other->session != self_.session &&
          std::ssize(others_) < kMostOthers)
        others_[info.instance_handle] = std::move(*other);
    }
    dds_return_loan(announcements_.id(), &sample, n);
  }
}

void NamesakeWatch::listen(Time now) {
  if (!listening_) {
    // The machines share one instance, their name's, and our own states would be the last in it whenever we look.
    auto reader = dds::reader(*participant_, gantry_msg_MachineState_desc, kStateTopic,
                              dds::Qos().best_effort().keep_last(kMostOthers).of_others());
    if (!reader) return;  // tried again by the next poll
    states_ = std::move(*reader);
    listening_ = true;
  }
  dds::take_all<gantry_msg_MachineState>(states_, [&](const gantry_msg_MachineState& s, const dds_sample_info_t&) {
    if (self_.machine != s.machine || s.session == self_.session || told_.contains(s.session)) return;
    const auto other = std::find_if(others_.begin(), others_.end(),
                                    [&](const auto& entry) { return entry.second.session == s.session; });
    if (other == others_.end() || !limit_.admit(now)) return;
    told_.insert(s.session);
    log::warn("{}{}", printable(namesake_words(self_, other->second)), limit_.left_out_words());
  });
}

}  // namespace gantry::monitor
