//! \file
//! Rows of random numbers, eight counters side by side.
//!
//! Compiled twice (baseline x86-64 and AVX2) from simd8_normals_impl.hpp; both give the same bits, and no
//! function of the C library has a part in them.
#pragma once

#include <cstdint>

namespace apc::simd8 {

inline constexpr int kNormalsPerBatch = 32;  //!< of eight counters with four words each

//! Where a row of numbers comes from: of one seed no two rows of any two streams are alike.
struct RandomRow {
  std::uint32_t key[2];  //!< the seed
  std::uint32_t row, stream;
};

//! Independent numbers of the standard normal distribution; n is a multiple of kNormalsPerBatch.
using FillNormals = void (*)(const RandomRow& row, int n, float* out);

namespace baseline {
void fill_normals(const RandomRow& row, int n, float* out);
}
namespace avx2 {
void fill_normals(const RandomRow& row, int n, float* out);
}

}  // namespace apc::simd8
