// The world of a `gantry sim` that runs in another process, over its Unix socket.
//   auto world = sim::WorldClient::connect("/run/user/1000/gantry-world");  world->get()->camera().fetch(...)
#pragma once
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::sim {

class WorldClient final : public WorldAccess {
 public:
  /// Fault::WorldUnreachable when nobody listens there.
  static Result<std::unique_ptr<WorldClient>> connect(const std::string& socket_path);
  ~WorldClient() override;

  /// Frames of the remote camera. `timeout` runs on the world's clock.
  vision::Camera& camera() override;
  Result<void> load_board(const recipes::Recipe& recipe) override;
  /// A job asks this first. A world that has been lost, because its `gantry sim` was ended or stood still for longer
  /// than a question waits (10 s), answers nothing until then, and is looked for again here.
  Result<bool> holds_board(const recipes::Recipe& recipe) override;
  Result<void> begin_job() override;
  Result<std::vector<Deposit>> deposits() override;
  Result<std::vector<Collision>> collisions() override;
  Result<void> write_deposits(const std::string& path) override;
  Result<std::string> placement() override;
  Result<void> add_script(std::string_view yaml) override;
  Result<std::vector<std::string>> script_left(Machine machine) override;
  void give_up() override;

 private:
  class Link;
  explicit WorldClient(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace gantry::sim
