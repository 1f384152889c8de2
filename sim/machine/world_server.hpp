// Answers the questions of WorldAccess on a Unix socket, for a controller in another process.
//   auto server = sim::WorldServer::listen(simulated, "/run/user/1000/gantry-world");   // serves until it is destroyed
// One JSON object a line each way: {"do": "deposits"} -> {"ok": true, "deposits": [...]}; what fails says
// {"ok": false, "fault": 604, "message": ..., "where": ...}. A frame's pixels follow its line as bare bytes.
#pragma once
#include <atomic>
#include <list>
#include <memory>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "sim/machine/line_socket.hpp"
#include "sim/machine/simulated_machine.hpp"

namespace gantry::sim {

class WorldServer {
 public:
  /// Mode 0600. Replaces the socket of a process that is gone; Fault::SecondOwner when somebody answers there,
  /// FileUnwritable when something else stands there.
  static Result<std::unique_ptr<WorldServer>> listen(SimulatedMachine& world, const std::string& path);
  /// Ends every conversation and removes the socket.
  ~WorldServer();
  WorldServer(const WorldServer&) = delete;
  WorldServer& operator=(const WorldServer&) = delete;

 private:
  WorldServer(SimulatedMachine& world, std::string path, int listening);
  void accept_clients();
  void converse(LineSocket& client);
  void forget_gone_clients();

  SimulatedMachine& world_;
  std::string path_;
  int listening_;
  std::atomic<bool> stop_{false};
  struct Client {
    explicit Client(int fd) : socket(fd) {}
    LineSocket socket;
    std::thread thread;
    std::atomic<bool> gone{false};
  };
  std::list<Client> clients_;  ///< of the acceptor's thread
  std::thread acceptor_;
};

}  // namespace gantry::sim
