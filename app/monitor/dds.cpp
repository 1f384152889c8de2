#include "app/monitor/dds.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fmt/format.h>

namespace gantry::monitor::dds {
namespace {

tl::unexpected<Error> refused(const char* what, dds_return_t code) {
  return fail(Fault::DdsUnusable, fmt::format("{}: {}", what, dds_strretcode(code)));
}

/// Cyclone's settings. On loopback there is no multicast, so peers are asked one by one: each takes the first free
/// index, and 32 of them are looked for.
std::string configuration(const std::string& interface) {
  if (interface.empty())
    return R"(<CycloneDDS><Domain Id="any"><General>
      <Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
      <AllowMulticast>false</AllowMulticast></General>
      <Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
      <Peers><Peer Address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>)";
  return fmt::format(R"(<CycloneDDS><Domain Id="any"><General>
      <Interfaces><NetworkInterface name="{}"/></Interfaces></General></Domain></CycloneDDS>)",
                     interface);
}

bool is_interface_name(const std::string& name) {
  return name.size() < 16 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '-' || c == '_' || c == '.' || c == '@';
         });
}

Result<Entity> topic_of(const Participant& participant, const dds_topic_descriptor_t& type, const char* name) {
  const auto topic = dds_create_topic(participant.id(), &type, name, nullptr, nullptr);
  if (topic < 0) return refused(name, topic);
  return Entity(topic);
}

}  // namespace

Result<Participant> Participant::open(const NetworkOptions& options) {
  if (options.domain < 0 || options.domain > 230)
    return fail(Fault::Usage, fmt::format("DDS domain {} is out of range; use 0 .. 230", options.domain));
  if (!is_interface_name(options.interface))
    return fail(Fault::Usage, "'" + options.interface + "' is no name of a network interface; see `ip link`");
  Participant p;
  const auto domain = static_cast<dds_domainid_t>(options.domain);
  const char* uri = std::getenv("CYCLONEDDS_URI");
  if (uri == nullptr || *uri == '\0') {
    const auto created = dds_create_domain(domain, configuration(options.interface).c_str());
    // Somebody else in this process has opened the domain already: his settings hold.
    if (created < 0 && created != DDS_RETCODE_PRECONDITION_NOT_MET)
      return refused("DDS cannot be set up on this computer's network", created);
    if (created > 0) p.domain_ = Entity(created);
  }
  const auto participant = dds_create_participant(domain, nullptr, nullptr);
  if (participant < 0) return refused("DDS cannot be joined", participant);
  p.participant_ = Entity(participant);
  return p;
}

Result<Entity> writer(const Participant& participant, const dds_topic_descriptor_t& type, const char* name,
                      const Qos& qos) {
  auto topic = topic_of(participant, type, name);
  if (!topic) return topic;
  const auto id = dds_create_writer(participant.id(), topic->id(), qos.get(), nullptr);
  if (id < 0) return refused(name, id);
  return Entity(id);
}

Result<Entity> reader(const Participant& participant, const dds_topic_descriptor_t& type, const char* name,
                      const Qos& qos) {
  auto topic = topic_of(participant, type, name);
  if (!topic) return topic;
  const auto id = dds_create_reader(participant.id(), topic->id(), qos.get(), nullptr);
  if (id < 0) return refused(name, id);
  return Entity(id);
}

}  // namespace gantry::monitor::dds
