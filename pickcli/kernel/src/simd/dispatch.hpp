//! \file
//! Which build of the batch test runs.
#pragma once

#include "simd/simd8_collision.hpp"

namespace apc {

//! AVX2 where the processor has it, unless set_simd says otherwise.
simd8::Test collision_test();
const char* simd_name();

//! "avx2" or "baseline". Throws std::invalid_argument for what is not available.
void set_simd(const char* name);

}  // namespace apc
