//! \file
//! Eight floats as one value. Included only by the translation units of the batch test, each with its own
//! instruction set: everything has internal linkage, so that the linker cannot mix the two.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

using V = float __attribute__((vector_size(32)));
using Mask = int __attribute__((vector_size(32)));  //!< 0 or -1 per lane
using Doubles = double __attribute__((vector_size(64)));
using Longs = long long __attribute__((vector_size(64)));

#define APC_INLINE inline __attribute__((always_inline))

//! What the compiler makes badly, or not the same, of vector operators: written out per instruction set. Where
//! either is a NaN, larger and smaller are the second, and nothing is above.
#if defined(__AVX2__)

APC_INLINE int bits(Mask m) { return _mm256_movemask_ps((__m256)m); }
APC_INLINE Mask above(V a, V b) { return (Mask)_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_GT_OQ); }
APC_INLINE Mask equal(Mask a, Mask b) { return (Mask)_mm256_cmpeq_epi32((__m256i)a, (__m256i)b); }
APC_INLINE V larger(V a, V b) { return (V)_mm256_max_ps((__m256)a, (__m256)b); }
APC_INLINE V smaller(V a, V b) { return (V)_mm256_min_ps((__m256)a, (__m256)b); }
APC_INLINE V square_root(V a) { return (V)_mm256_sqrt_ps((__m256)a); }
APC_INLINE V gathered(const float* table, Mask at) {
  return (V)_mm256_i32gather_ps(table, (__m256i)at, sizeof(float));
}

#elif defined(__SSE2__)

union Halves {
  V v;
  Mask m;
  __m128 low_high[2];
  __m128i integers[2];
};
APC_INLINE int bits(Mask m) {
  Halves h;
  h.m = m;
  return _mm_movemask_ps(h.low_high[0]) | _mm_movemask_ps(h.low_high[1]) << 4;
}
APC_INLINE Mask above(V a, V b) {
  Halves x{a};
  const Halves y{b};
  for (int i = 0; i < 2; ++i) x.low_high[i] = _mm_cmpgt_ps(x.low_high[i], y.low_high[i]);
  return x.m;
}
APC_INLINE Mask equal(Mask a, Mask b) {
  Halves x{(V)a};
  const Halves y{(V)b};
  for (int i = 0; i < 2; ++i) x.integers[i] = _mm_cmpeq_epi32(x.integers[i], y.integers[i]);
  return x.m;
}
APC_INLINE V larger(V a, V b) {
  Halves x{a};
  const Halves y{b};
  for (int i = 0; i < 2; ++i) x.low_high[i] = _mm_max_ps(x.low_high[i], y.low_high[i]);
  return x.v;
}
APC_INLINE V smaller(V a, V b) {
  Halves x{a};
  const Halves y{b};
  for (int i = 0; i < 2; ++i) x.low_high[i] = _mm_min_ps(x.low_high[i], y.low_high[i]);
  return x.v;
}
APC_INLINE V square_root(V a) {
  Halves x{a};
  for (int i = 0; i < 2; ++i) x.low_high[i] = _mm_sqrt_ps(x.low_high[i]);
  return x.v;
}

#else

APC_INLINE int bits(Mask m) {
  int out = 0;
  for (int i = 0; i < 8; ++i) out |= (m[i] & 1) << i;
  return out;
}
APC_INLINE Mask above(V a, V b) { return a > b; }
APC_INLINE Mask equal(Mask a, Mask b) { return a == b; }
APC_INLINE V larger(V a, V b) { return a > b ? a : b; }
APC_INLINE V smaller(V a, V b) { return a < b ? a : b; }
APC_INLINE V square_root(V a) {
  for (int i = 0; i < 8; ++i) a[i] = __builtin_sqrtf(a[i]);
  return a;
}

#endif

APC_INLINE V select(Mask m, V a, V b) { return (V)(((Mask)a & m) | ((Mask)b & ~m)); }

APC_INLINE V load(const float* lanes) {
  V v;
  __builtin_memcpy(&v, lanes, sizeof v);
  return v;
}

//! One number in every lane.
APC_INLINE V all(float a) { return V{a, a, a, a, a, a, a, a}; }

//! Lanes in another order: written with the builtin that GCC from 12 on and clang have, or with GCC's older
//! one.
#if defined(__has_builtin) && __has_builtin(__builtin_shufflevector)
#define APC_SHUFFLE(a, ...) __builtin_shufflevector(a, a, __VA_ARGS__)
#else
#define APC_SHUFFLE(a, ...) __builtin_shuffle(a, Mask{__VA_ARGS__})
#endif

//! The largest lane.
APC_INLINE float largest(V a) {
  a = larger(a, APC_SHUFFLE(a, 4, 5, 6, 7, 0, 1, 2, 3));
  a = larger(a, APC_SHUFFLE(a, 2, 3, 0, 1, 6, 7, 4, 5));
  a = larger(a, APC_SHUFFLE(a, 1, 0, 3, 2, 5, 4, 7, 6));
  return a[0];
}

#if !defined(__AVX2__)
//! Entries of a table.
APC_INLINE V gathered(const float* table, Mask at) {
  V out{};
  for (int i = 0; i < 8; ++i) out[i] = table[at[i]];
  return out;
}
#endif

//! The lanes whose bit is set.
APC_INLINE Mask lanes(int set) {
  constexpr Mask bit{1, 2, 4, 8, 16, 32, 64, 128};
  return equal(bit & set, bit);
}

APC_INLINE V magnitude(V a) { return (V)((Mask)a & 0x7fffffff); }
//! Written so that a NaN counts as not above.
APC_INLINE Mask not_above(V a, V b) { return ~above(a, b); }

//! Sine and cosine of angles given in double: the multiple of pi/2 is taken off in double, the rest by the
//! minimax polynomials of Cephes (S. Moshier) on [-pi/4, pi/4], each off by less than 2 units of 2^-24.
APC_INLINE void sine_cosine(const Doubles& angle, V& sine, V& cosine) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer
  const Doubles rounded = angle * 0.63661977236758134308 + kRound;
  const Mask quadrant = __builtin_convertvector((Longs)rounded, Mask);
  const V y = __builtin_convertvector(angle - (rounded - kRound) * 1.57079632679489661923, V);
  const V z = y * y;
  const V s = y + y * z * (-1.6666654611e-1f + z * (8.3321608736e-3f + z * -1.9515295891e-4f));
  const V c = 1.0f - 0.5f * z +
              z * z * (4.166664568298827e-2f + z * (-1.388731625493765e-3f + z * 2.443315711809948e-5f));
  const Mask is_odd = -(quadrant & 1);
  sine = (V)((Mask)select(is_odd, c, s) ^ ((quadrant & 2) << 30));
  cosine = (V)((Mask)select(is_odd, s, c) ^ (((quadrant + 1) & 2) << 30));
}

}  // namespace
