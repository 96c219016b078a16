//! \file
//! Which build of the batch test, of the rays, of pictures, of fits and of random numbers runs.
#pragma once

#include "simd/simd8_collision.hpp"
#include "simd/simd8_fit.hpp"
#include "simd/simd8_hypothesis.hpp"
#include "simd/simd8_normals.hpp"
#include "simd/simd8_rays.hpp"

namespace apc {

//! AVX2 where the processor has it, unless set_simd says otherwise.
simd8::Test collision_test();
simd8::Cast ray_cast();
simd8::FillNormals normals_filler();
simd8::CostBefore picture_cost();
simd8::ShowRow row_shower();
simd8::SumFit fit_sums();
simd8::SumFitCost fit_cost();
const char* simd_name();

//! "avx2" or "baseline". Throws std::invalid_argument for what is not available.
void set_simd(const char* name);

}  // namespace apc
