// A piece of work with a stack of its own: it stops in the middle where it has to wait, and goes on there later. It
// runs in the thread of whoever resumes it, so that virtual time stays one thread's (docs/decisions/013).
//   Fiber fiber([&] { ...; fiber.wait(); ... });   while (!fiber.done()) fiber.resume();
// A fiber has to be resumed until it is done. Nothing may be thrown out of the work.
#pragma once
#include <functional>
#include <memory>

namespace gantry::devices {

class Fiber {
 public:
  explicit Fiber(std::function<void()> work);
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// The work goes on until it waits or ends. Not from inside a fiber.
  void resume();
  /// From inside the work: back to whoever has resumed it.
  void wait();
  [[nodiscard]] bool done() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gantry::devices
