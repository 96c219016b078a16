#include "dispatch.hpp"

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

std::atomic<eight::Test> g_test{nullptr};  // null: not chosen yet

bool has_avx2() {
#ifdef APC_HAS_AVX2_BUILD
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

eight::Test test_named(const char* name) {
  if (std::strcmp(name, "baseline") == 0) return eight::baseline::test;
#ifdef APC_HAS_AVX2_BUILD
  if (std::strcmp(name, "avx2") == 0 && has_avx2()) return eight::avx2::test;
#endif
  throw std::invalid_argument(std::string("simd \"") + name + "\" is not available here: use \"baseline\"" +
                              (has_avx2() ? " or \"avx2\"" : ""));
}

eight::Test chosen_test() {
  eight::Test test = g_test.load(std::memory_order_relaxed);
  if (!test) g_test = test = test_named(has_avx2() ? "avx2" : "baseline");
  return test;
}

// Aligned memory for the hot test, kept from call to call by each thread.
void* scratch(std::size_t n_bytes) {
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  thread_local std::unique_ptr<void, Free> memory;
  thread_local std::size_t size = 0;
  if (size < n_bytes) {
    size = (n_bytes + 63) / 64 * 64;
    memory.reset(std::aligned_alloc(64, size));
    if (!memory) {
      size = 0;
      throw std::bad_alloc();
    }
  }
  return memory.get();
}

}  // namespace

eight::Verdict run_eight(const eight::Robot& robot, const eight::World& world, const eight::Batch& batch) {
  eight::Verdict verdict;
  chosen_test()(robot, world, batch, scratch(eight::scratch_bytes(robot)), verdict);
  return verdict;
}

const char* simd_name() { return chosen_test() == eight::baseline::test ? "baseline" : "avx2"; }

void set_simd(const char* name) { g_test = test_named(name); }

}  // namespace apc
