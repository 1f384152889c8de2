#include "app/monitor/dds.hpp"

#include <cstdlib>
#include <fmt/format.h>

#include "app/monitor/dds_log.hpp"
#include "app/monitor/device_sockets.hpp"
#include "core/log.hpp"

namespace gantry::monitor::dds {
namespace {

tl::unexpected<Error> refused(const char* what, dds_return_t code) {
  return fail(Fault::DdsUnusable, fmt::format("{}: {}", what, dds_strretcode(code)));
}

/// Cyclone's settings. Every participant takes the first free index, so that who knows its address finds it at one of
/// 33 ports; on loopback, where there is no multicast, all of this computer are asked so. On a network multicast only
/// finds others: samples go to each reader by its address, also through a router. Who came first or whose first packet
/// was lost is asked for again each second.
std::string configuration(const NetworkOptions& options) {
  const bool alone = options.device() == "lo";
  std::string peers = alone ? R"(<Peer Address="127.0.0.1"/>)" : "";
  for (const std::string& peer : options.peers) peers += fmt::format(R"(<Peer Address="{}"/>)", peer);
  return fmt::format(R"(<CycloneDDS><Domain Id="any"><General>
      <Interfaces><NetworkInterface name="{}" {}/></Interfaces>
      <AllowMulticast>{}</AllowMulticast></General>
      <Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
      <Peers>{}</Peers><SPDPInterval>1s</SPDPInterval></Discovery></Domain></CycloneDDS>)",
                     options.device(), alone ? R"(multicast="false")" : "", alone ? "false" : "spdp", peers);
}

Result<Entity> topic_of(const Participant& participant, const dds_topic_descriptor_t& type, const char* name) {
  const auto topic = dds_create_topic(participant.id(), &type, name, nullptr, nullptr);
  if (topic < 0) return refused(name, topic);
  return Entity(topic);
}

}  // namespace

Result<Participant> Participant::open(const NetworkOptions& options) {
  if (auto fits = check(options); !fits) return tl::unexpected(fits.error());
  if (auto bound = confine_sockets(options.device()); !bound) return tl::unexpected(bound.error());
  log_in_bounds();
  if (const char* uri = std::getenv("CYCLONEDDS_URI"); uri != nullptr && *uri != '\0')
    log::info("CYCLONEDDS_URI is set and not followed; --domain, --interface and --peer decide");
  Participant p;
  const auto domain = static_cast<dds_domainid_t>(options.domain);
  const auto created = dds_create_domain(domain, configuration(options).c_str());
  // Somebody else in this process has opened the domain already: his settings hold.
  if (created < 0 && created != DDS_RETCODE_PRECONDITION_NOT_MET)
    return refused("DDS cannot be set up on this computer's network", created);
  if (created > 0) p.domain_ = Entity(created);
  const auto participant = dds_create_participant(domain, nullptr, nullptr);
  if (participant < 0) return refused("DDS cannot be joined", participant);
  p.participant_ = Entity(participant);
  if (auto bound = check_sockets(options.device()); !bound) return tl::unexpected(bound.error());
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
