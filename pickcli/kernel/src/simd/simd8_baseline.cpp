//! \file
//! The batch test for any x86-64.
#define APC_ARCHITECTURE baseline
#include "simd/simd8_collision_impl.hpp"
#include "simd/simd8_rays_impl.hpp"
#include "simd/simd8_normals_impl.hpp"
#include "simd/simd8_hypothesis_impl.hpp"
#include "simd/simd8_fit_impl.hpp"
