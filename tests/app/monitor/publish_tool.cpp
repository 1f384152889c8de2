// The other processes of the tests over DDS, with --domain N, --interface IF, --peer ADDR as in the program:
//   publish --shm FD     the publisher
//   hold                 a subscriber that asks for every sample, has room for one, and never reads; it writes a byte
//                        when it is matched
//   flood                a peer that writes states under a name of its own without a pause
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <dds/dds.h>
#include <iostream>
#include <string>
#include <sys/prctl.h>
#include <unistd.h>

#include "app/monitor/publish.hpp"
#include "app/monitor/rights.hpp"
#include "app/monitor/topics.hpp"
#include "core/log.hpp"

namespace {

using namespace gantry;
using namespace gantry::monitor;

int hold(const NetworkOptions& network) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that fails leaves nobody behind
  auto participant = dds::Participant::open(network);
  if (!participant) return 1;
  const auto topic = dds_create_topic(participant->id(), &gantry_msg_MachineState_desc, kStateTopic, nullptr, nullptr);
  auto* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_resource_limits(qos, 1, 1, 1);
  const auto reader = dds_create_reader(participant->id(), topic, qos, nullptr);
  dds_delete_qos(qos);
  dds_subscription_matched_status_t matched{};
  while (matched.current_count == 0) {
    if (dds_get_subscription_matched_status(reader, &matched) != DDS_RETCODE_OK) return 1;
    usleep(10'000);
  }
  std::cout << 'm' << std::flush;
  for (;;) pause();
}

int flood(const NetworkOptions& network) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  auto participant = dds::Participant::open(network);
  if (!participant) return 1;
  const auto topic = dds_create_topic(participant->id(), &gantry_msg_MachineState_desc, kStateTopic, nullptr, nullptr);
  const auto writer = dds_create_writer(participant->id(), topic, nullptr, nullptr);
  gantry_msg_MachineState sample{};
  std::strcpy(sample.machine, "flood");
  for (;;) dds_write(writer, &sample);  // what it answers makes no difference
}

int publish_as_child(int shm, const PublishOptions& options) {
  if (auto given_up = give_up_rights(); !given_up) {
    std::cerr << to_text(given_up.error()) << '\n';
    return 1;
  }
  const std::atomic<bool> stop{false};
  const auto done = publish(shm, options, stop);
  if (!done) std::cerr << to_text(done.error()) << '\n';
  return done ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  log::open(log::Level::Normal);
  int shm = -1;
  PublishOptions options;
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--shm") shm = std::atoi(argv[i + 1]);
    if (word == "--domain") options.network.domain = std::atoi(argv[i + 1]);
    if (word == "--interface") options.network.interface = argv[i + 1];
    if (word == "--peer") options.network.peers.emplace_back(argv[i + 1]);
  }
  if (argc > 1 && std::strcmp(argv[1], "hold") == 0) return hold(options.network);
  if (argc > 1 && std::strcmp(argv[1], "flood") == 0) return flood(options.network);
  return publish_as_child(shm, options);
}
