// The camera on the head: the trigger output exposes, the head's actual place at that instant decides what is seen.
//   camera.expose(...)   // by the world, at the sync where the trigger rises: only keeps the pose
//   camera.fetch(...)    // by vision, on its own thread: renders
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "sim/world/board.hpp"
#include "sim/world/render.hpp"
#include "vision/camera.hpp"

namespace gantry::sim {

class SimCamera final : public vision::Camera {
 public:
  SimCamera(const config::Machine& machine, Clock& clock, std::uint64_t seed);

  /// Bus thread. `focus`: true place of the camera's point in focus; `board` may be null.
  void expose(Vec3 focus, Vec2 speed_mm_s, bool light, std::shared_ptr<const BoardTruth> board);
  /// The attempts on each mark, which seed the noise, begin anew.
  void begin_job();
  /// Script: the trigger exposes nothing any more.
  void set_dead(bool dead);

  std::uint64_t latest() override;
  Result<vision::Frame> fetch(std::uint64_t after, Time timeout) override;

 private:
  struct Exposure {
    std::uint64_t counter = 0, noise_seed = 0;
    View view;
    std::shared_ptr<const BoardTruth> board;
  };
  std::shared_ptr<const Exposure> first_after(std::uint64_t after);

  config::CameraConfig config_;
  double noise_;
  Clock& clock_;
  std::uint64_t seed_;
  std::mutex mutex_;
  std::deque<std::shared_ptr<const Exposure>> kept_;
  std::uint64_t counter_ = 0;
  bool dead_ = false;
  std::map<std::string, std::uint64_t> attempts_;  ///< by the mark nearest to the image's centre
};

/// Index of the mark nearest to a place on the board; -1 when there is none.
int nearest_mark(const BoardPlan& plan, Vec2 at);

}  // namespace gantry::sim
