// The trap itself: each thing that the loop must not do is caught inside a section, and only there.
#include "core/rt/trap.hpp"

#include <cctype>
#include <cstdlib>
#include <cxxabi.h>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace gantry::rt {
namespace {

/// Keeps the compiler from leaving an allocation out.
void keep(const void* p) { asm volatile("" : : "g"(p) : "memory"); }

struct Caught {
  const char* name;
  const char* message;
  void (*act)();
};

std::vector<int>& grown() {
  static std::vector<int> v(4);
  return v;
}
void* block = nullptr;
std::mutex mutex;

const Caught kCaught[] = {
    {"malloc", "malloc inside", [] { keep(std::malloc(8)); }},
    {"calloc", "calloc inside", [] { keep(std::calloc(2, 8)); }},
    {"realloc", "realloc inside", [] { keep(block = std::realloc(block, 64)); }},
    {"aligned_alloc", "aligned_alloc inside", [] { keep(std::aligned_alloc(64, 64)); }},
    {"free", "free inside", [] { std::free(std::exchange(block, nullptr)); }},
    {"new", "malloc inside", [] { keep(new int(3)); }},
    {"over-aligned new", "aligned_alloc inside", [] { keep(::operator new (64, std::align_val_t{64})); }},
    {"a vector that grows", "malloc inside", [] { grown().resize(grown().capacity() + 1); }},
    {"a long string", "malloc inside", [] { keep(std::string(100, 'x').data()); }},
    {"std::function with much to carry", "malloc inside",
     [] {
       struct Big {
         char bytes[64] = {};
       } big;
       std::function<void()> f = [big] { keep(&big); };
       keep(&f);
     }},
    {"shared_ptr", "malloc inside", [] { keep(std::make_shared<int>(1).get()); }},
    {"mutex", "pthread_mutex_lock inside", [] { std::lock_guard lock(mutex); }},
    {"throw", "(malloc|throw) inside",
     [] {
       try {
         throw 1;
       } catch (int) {
       }
     }},
    {"a rethrow", "(malloc|throw) inside",
     [] {
       try {
         std::rethrow_exception(std::make_exception_ptr(2));
       } catch (int) {
       }
     }},
};

class TrapDeathTest : public testing::TestWithParam<Caught> {
 protected:
  void SetUp() override {
    grown();
    block = std::malloc(8);
  }
  void TearDown() override { std::free(block); }
};

TEST_P(TrapDeathTest, is_caught_inside_a_section) {
  EXPECT_DEATH(
      {
        Section section;
        GetParam().act();
      },
      GetParam().message);
}

TEST_P(TrapDeathTest, is_allowed_outside_of_any_section) { GetParam().act(); }

INSTANTIATE_TEST_SUITE_P(Trap, TrapDeathTest, testing::ValuesIn(kCaught),
                         [](const testing::TestParamInfo<Caught>& row) {
                           std::string name = row.param.name;
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

TEST(TrapDeathTest, is_lifted_by_outside_and_set_again_after_it) {
  {
    const Section section;
    const Outside outside;
    keep(std::make_unique<int>(1).get());
  }
  EXPECT_DEATH(
      {
        const Section section;
        { const Outside outside; }
        keep(std::malloc(8));
      },
      "malloc inside");
}

TEST(TrapDeathTest, names_a_throw_whose_exception_was_allocated_before) {
  EXPECT_DEATH(
      {
        void* thrown = abi::__cxa_allocate_exception(sizeof(int));
        const Section section;
        abi::__cxa_throw(thrown, const_cast<std::type_info*>(&typeid(int)), nullptr);
      },
      "throw inside");
}

TEST(Trap, sections_nest) {
  int depth = 0;
  {
    const Section outer;
    { const Section inner; }
    depth = rt_depth;
  }
  EXPECT_EQ(depth, 1);
  EXPECT_EQ(rt_depth, 0);
}

}  // namespace
}  // namespace gantry::rt
