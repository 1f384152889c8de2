// Marks code that runs in the 1 ms loop. In tests that link core/rt/trap_hooks.cpp, an allocation, a lock or a throw
// inside such a section aborts with a message; in the product the marks cost two thread-local writes.
#pragma once

namespace gantry::rt {

extern constinit thread_local int rt_depth;  ///< > 0: this thread is inside the loop

class Section {
 public:
  Section() noexcept { ++rt_depth; }
  ~Section() { --rt_depth; }
  Section(const Section&) = delete;
  Section& operator=(const Section&) = delete;
};

/// What stands for the outside world (the virtual segment in process) is not held to the loop's rules.
class Outside {
 public:
  Outside() noexcept : saved_(rt_depth) { rt_depth = 0; }
  ~Outside() { rt_depth = saved_; }
  Outside(const Outside&) = delete;
  Outside& operator=(const Outside&) = delete;

 private:
  int saved_;
};

}  // namespace gantry::rt
