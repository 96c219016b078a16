#include "simd/dispatch.hpp"

#include <atomic>
#include <cstring>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

struct Build {
  const char* name;
  simd8::Test test;
  simd8::Cast cast;
  simd8::FillNormals fill_normals;
  simd8::CostBefore cost_before;
  simd8::ShowRow show_row;
  simd8::SumFit sum_fit;
  simd8::SumFitCost sum_fit_cost;
};

constexpr Build kBaseline{"baseline", simd8::baseline::test, simd8::baseline::cast,
                          simd8::baseline::fill_normals, simd8::baseline::cost_before,
                          simd8::baseline::show_row, simd8::baseline::sum_fit,
                          simd8::baseline::sum_fit_cost};
#ifdef APC_HAS_AVX2_BUILD
constexpr Build kAvx2{"avx2", simd8::avx2::test, simd8::avx2::cast, simd8::avx2::fill_normals,
                      simd8::avx2::cost_before, simd8::avx2::show_row, simd8::avx2::sum_fit,
                      simd8::avx2::sum_fit_cost};
#endif

std::atomic<const Build*> g_build{nullptr};  //!< null: not chosen yet

bool has_avx2() {
#ifdef APC_HAS_AVX2_BUILD
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

const Build& build_named(const char* name) {
  if (std::strcmp(name, "baseline") == 0) return kBaseline;
#ifdef APC_HAS_AVX2_BUILD
  if (std::strcmp(name, "avx2") == 0 && has_avx2()) return kAvx2;
#endif
  throw std::invalid_argument(std::string("simd \"") + name + "\" is not available here: use \"baseline\"" +
                              (has_avx2() ? " or \"avx2\"" : ""));
}

const Build& build() {
  const Build* chosen = g_build.load(std::memory_order_relaxed);
  if (!chosen) g_build = chosen = &build_named(has_avx2() ? "avx2" : "baseline");
  return *chosen;
}

}  // namespace

simd8::Test collision_test() { return build().test; }

simd8::Cast ray_cast() { return build().cast; }

simd8::FillNormals normals_filler() { return build().fill_normals; }

simd8::CostBefore picture_cost() { return build().cost_before; }

simd8::ShowRow row_shower() { return build().show_row; }

simd8::SumFit fit_sums() { return build().sum_fit; }

simd8::SumFitCost fit_cost() { return build().sum_fit_cost; }

const char* simd_name() { return build().name; }

void set_simd(const char* name) { g_build = &build_named(name); }

}  // namespace apc
