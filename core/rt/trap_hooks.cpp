// Linked into tests only (target gantry_trap_hooks): takes the place of the C library's allocator, of pthread's mutex
// and of the throw, and aborts with a message and a stack when one of them is called inside an rt::Section. Outside of
// sections everything goes on to the real one. Sanitizers bring an allocator and a mutex of their own: in their builds
// only the throw is watched.
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <execinfo.h>
#include <initializer_list>
#include <pthread.h>
#include <typeinfo>
#include <unistd.h>

#include "core/rt/trap.hpp"

namespace {

void watch(const char* what) noexcept {
  if (gantry::rt::rt_depth == 0) return;
  gantry::rt::rt_depth = 0;  // telling about it may allocate
  constexpr const char* kWhere = " inside an RT section\n";
  for (const char* part : {"gantry trap: ", what, kWhere})
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  void* stack[32];
  backtrace_symbols_fd(stack, backtrace(stack, 32), STDERR_FILENO);
  std::abort();
}

/// The next definition after ours in the order of loading: the real one.
template <class Function>
Function* real(const char* name) noexcept {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

extern "C" {

// glibc's own names of the real allocator: finding them by dlsym would allocate.
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  watch("malloc");
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  watch("calloc");
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  watch("realloc");
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  watch("aligned_alloc");
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  watch("posix_memalign");
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) {
  if (block != nullptr) watch("free");
  __libc_free(block);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  watch("pthread_mutex_lock");
  static const auto next = real<int(pthread_mutex_t*)>("pthread_mutex_lock");
  return next(mutex);
}

}  // extern "C"

#endif

extern "C" void __cxa_throw(void* thrown, std::type_info* type, void (*destroy)(void*)) {
  watch("throw");
  static const auto next = real<void(void*, std::type_info*, void (*)(void*))>("__cxa_throw");
  next(thrown, type, destroy);
  std::abort();  // the real one does not come back
}
