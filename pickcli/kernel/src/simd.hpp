// Eight floats as one value. Included only by the translation units of the hot test, each with its own
// instruction set: everything has internal linkage, so that the linker cannot mix the two.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

using V = float __attribute__((vector_size(32)));
using Mask = int __attribute__((vector_size(32)));  // 0 or -1 per lane
using Doubles = double __attribute__((vector_size(64)));
using Longs = long long __attribute__((vector_size(64)));

#define APC_INLINE inline __attribute__((always_inline))

#if defined(__AVX2__)

APC_INLINE int bits(Mask m) { return _mm256_movemask_ps((__m256)m); }
APC_INLINE V larger(V a, V b) { return (V)_mm256_max_ps((__m256)a, (__m256)b); }
APC_INLINE V square_root(V a) { return (V)_mm256_sqrt_ps((__m256)a); }

#elif defined(__SSE2__)

union Halves {
  V v;
  __m128 half[2];
};
APC_INLINE int bits(Mask m) {
  const Halves h{(V)m};
  return _mm_movemask_ps(h.half[0]) | _mm_movemask_ps(h.half[1]) << 4;
}
APC_INLINE V larger(V a, V b) {
  Halves x{a};
  const Halves y{b};
  for (int i = 0; i < 2; ++i) x.half[i] = _mm_max_ps(x.half[i], y.half[i]);
  return x.v;
}
APC_INLINE V square_root(V a) {
  Halves x{a};
  for (int i = 0; i < 2; ++i) x.half[i] = _mm_sqrt_ps(x.half[i]);
  return x.v;
}

#else

APC_INLINE int bits(Mask m) {
  int out = 0;
  for (int i = 0; i < 8; ++i) out |= (m[i] & 1) << i;
  return out;
}
APC_INLINE V larger(V a, V b) { return a > b ? a : b; }
APC_INLINE V square_root(V a) {
  for (int i = 0; i < 8; ++i) a[i] = __builtin_sqrtf(a[i]);
  return a;
}

#endif

APC_INLINE V load(const float* eight) {
  V v;
  __builtin_memcpy(&v, eight, sizeof v);
  return v;
}

// The largest lane.
APC_INLINE float largest(V a) {
  a = larger(a, __builtin_shuffle(a, Mask{4, 5, 6, 7, 0, 1, 2, 3}));
  a = larger(a, __builtin_shuffle(a, Mask{2, 3, 0, 1, 6, 7, 4, 5}));
  a = larger(a, __builtin_shuffle(a, Mask{1, 0, 3, 2, 5, 4, 7, 6}));
  return a[0];
}

// The lanes whose bit is set.
APC_INLINE Mask lanes(int set) { return (Mask{1, 2, 4, 8, 16, 32, 64, 128} & set) != 0; }

APC_INLINE V magnitude(V a) { return (V)((Mask)a & 0x7fffffff); }
// Written so that a NaN counts as not above.
APC_INLINE Mask not_above(V a, V b) { return ~(a > b); }

// Sine and cosine of angles given in double: the multiple of pi/2 is taken off in double, the rest by the
// minimax polynomials of Cephes (S. Moshier) on [-pi/4, pi/4], each off by less than 2 units of 2^-24.
APC_INLINE void sine_cosine(const Doubles& angle, V& sine, V& cosine) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer
  const Doubles rounded = angle * 0.63661977236758134308 + kRound;
  const Mask quadrant = __builtin_convertvector((Longs)rounded, Mask);
  const V y = __builtin_convertvector(angle - (rounded - kRound) * 1.57079632679489661923, V);
  const V z = y * y;
  const V s = y + y * z * (-1.6666654611e-1f + z * (8.3321608736e-3f + z * -1.9515295891e-4f));
  const V c = 1.0f - 0.5f * z +
              z * z * (4.166664568298827e-2f + z * (-1.388731625493765e-3f + z * 2.443315711809948e-5f));
  const Mask is_odd = (quadrant & 1) != 0;
  sine = (V)((Mask)(is_odd ? c : s) ^ ((quadrant & 2) << 30));
  cosine = (V)((Mask)(is_odd ? s : c) ^ (((quadrant + 1) & 2) << 30));
}

}  // namespace
