#include "simd/dispatch.hpp"

#include <atomic>
#include <cstring>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

std::atomic<simd8::Test> g_test{nullptr};  //!< null: not chosen yet

bool has_avx2() {
#ifdef APC_HAS_AVX2_BUILD
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

simd8::Test test_named(const char* name) {
  if (std::strcmp(name, "baseline") == 0) return simd8::baseline::test;
#ifdef APC_HAS_AVX2_BUILD
  if (std::strcmp(name, "avx2") == 0 && has_avx2()) return simd8::avx2::test;
#endif
  throw std::invalid_argument(std::string("simd \"") + name + "\" is not available here: use \"baseline\"" +
                              (has_avx2() ? " or \"avx2\"" : ""));
}

}  // namespace

simd8::Test collision_test() {
  simd8::Test test = g_test.load(std::memory_order_relaxed);
  if (!test) g_test = test = test_named(has_avx2() ? "avx2" : "baseline");
  return test;
}

const char* simd_name() { return collision_test() == simd8::baseline::test ? "baseline" : "avx2"; }

void set_simd(const char* name) { g_test = test_named(name); }

}  // namespace apc
