// The same scene for FCL: a dynamic tree of boxes, boolean contact (never distances: notes in docs/motion/planning.md).
#pragma once
#include <memory>

#include "config/machine.hpp"
#include "core/vec.hpp"

namespace gantry::bench {

class FclScene {
 public:
  explicit FclScene(const config::Machine& machine);
  ~FclScene();
  FclScene(const FclScene&) = delete;
  FclScene& operator=(const FclScene&) = delete;
  [[nodiscard]] bool collides(Vec3 tip);
  /// Poses at most `step_mm` apart, from the start on, until one collides.
  [[nodiscard]] bool line_is_free(Vec3 from, Vec3 to, double step_mm = 0.5);
  [[nodiscard]] long calls() const { return calls_; }

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  long calls_ = 0;
};

}  // namespace gantry::bench
