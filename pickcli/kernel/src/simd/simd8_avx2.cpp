//! \file
//! The batch test for processors with AVX2 (compiled with -mavx2).
#define APC_ARCHITECTURE avx2
#include "simd/simd8_collision_impl.hpp"
#include "simd/simd8_rays_impl.hpp"
#include "simd/simd8_normals_impl.hpp"
#include "simd/simd8_hypothesis_impl.hpp"
#include "simd/simd8_fit_impl.hpp"
