#include "devices/ethercat/fiber.hpp"

#include <cstddef>
#include <cstdint>
#include <ucontext.h>
#include <utility>

// The sanitizers have to be told of each change of stacks.
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif
#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace gantry::devices {
namespace {

constexpr std::size_t kStackBytes = 256 * 1024;

}  // namespace

struct Fiber::Parts {
  std::function<void()> work;
  std::unique_ptr<std::byte[]> stack = std::make_unique_for_overwrite<std::byte[]>(kStackBytes);
  ucontext_t inside{}, outside{};
  bool done = false;
#if defined(__SANITIZE_ADDRESS__)
  void *fake_inside = nullptr, *fake_outside = nullptr;
  const void* outer_stack = nullptr;
  std::size_t outer_bytes = 0;
#endif
#if defined(__SANITIZE_THREAD__)
  void *tsan_inside = __tsan_create_fiber(0), *tsan_outside = nullptr;
#endif

  void enter() {
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_start_switch_fiber(&fake_outside, stack.get(), kStackBytes);
#endif
#if defined(__SANITIZE_THREAD__)
    tsan_outside = __tsan_get_current_fiber();
    __tsan_switch_to_fiber(tsan_inside, 0);
#endif
    swapcontext(&outside, &inside);
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_finish_switch_fiber(fake_outside, nullptr, nullptr);
#endif
  }
  void leave() {
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_start_switch_fiber(done ? nullptr : &fake_inside, outer_stack, outer_bytes);
#endif
#if defined(__SANITIZE_THREAD__)
    __tsan_switch_to_fiber(tsan_outside, 0);
#endif
    swapcontext(&inside, &outside);
    arrived();
  }
  void arrived() {
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_finish_switch_fiber(fake_inside, &outer_stack, &outer_bytes);
#endif
  }
  /// makecontext() passes nothing but ints.
  static void begin(unsigned high, unsigned low) {
    auto* const parts = reinterpret_cast<Parts*>(std::uintptr_t{high} << 32 | low);
    parts->arrived();
    parts->work();
    parts->done = true;
    parts->leave();
  }
};

Fiber::Fiber(std::function<void()> work) : parts_(std::make_unique<Parts>()) {
  parts_->work = std::move(work);
  getcontext(&parts_->inside);
  parts_->inside.uc_stack.ss_sp = parts_->stack.get();
  parts_->inside.uc_stack.ss_size = kStackBytes;
  parts_->inside.uc_link = nullptr;  // it leaves by itself
  const auto self = reinterpret_cast<std::uintptr_t>(parts_.get());
  makecontext(&parts_->inside, reinterpret_cast<void (*)()>(&Parts::begin), 2, static_cast<unsigned>(self >> 32),
              static_cast<unsigned>(self & 0xFFFF'FFFFu));
}

Fiber::~Fiber() {
#if defined(__SANITIZE_THREAD__)
  __tsan_destroy_fiber(parts_->tsan_inside);
#endif
}

void Fiber::resume() { parts_->enter(); }
void Fiber::wait() { parts_->leave(); }
bool Fiber::done() const noexcept { return parts_->done; }

}  // namespace gantry::devices
