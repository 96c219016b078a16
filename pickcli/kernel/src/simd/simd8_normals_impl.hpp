//! \file
//! The rows of simd8_normals.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
#include "simd/simd8_normals.hpp"
#include "simd/vector8.hpp"

#include <initializer_list>

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

using Words = std::uint32_t __attribute__((vector_size(32)));
using Products = std::uint64_t __attribute__((vector_size(64)));

struct Counter {
  Words word[4];
};

APC_INLINE Products product(std::uint32_t factor, Words words) {
  return __builtin_convertvector(words, Products) * std::uint64_t{factor};
}

//! Philox4x32-10 of Salmon, Moraes, Dror and Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3".
APC_INLINE Counter philox(Counter c, std::uint32_t key0, std::uint32_t key1) {
  for (int round = 0; round < 10; ++round) {
    const Products a = product(0xD2511F53u, c.word[0]), b = product(0xCD9E8D57u, c.word[2]);
    c = {__builtin_convertvector(b >> 32, Words) ^ c.word[1] ^ key0, __builtin_convertvector(b, Words),
         __builtin_convertvector(a >> 32, Words) ^ c.word[3] ^ key1, __builtin_convertvector(a, Words)};
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  return c;
}

//! In (0, 1): the middle of one of 2^23 equal steps, which single precision holds exactly.
APC_INLINE V uniform(Words words) {
  return (__builtin_convertvector((Mask)(words >> 9), V) + 0.5f) * 0x1p-23f;
}

//! Natural logarithm of normal x > 0: the minimax polynomial of Cephes (S. Moshier, logf).
APC_INLINE V logarithm(V x) {
  const Mask whole = (Mask)x;
  V m = (V)((whole & 0x007fffff) | 0x3f000000), e = __builtin_convertvector((whole >> 23) - 126, V);
  const Mask is_small = above(all(0.70710678f), m);
  e = select(is_small, e - 1.0f, e);
  m = select(is_small, m + m, m) - 1.0f;
  const V z = m * m;
  V y = all(7.0376836292e-2f);
  for (const float c : {-1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f,
                        -1.6668057665e-1f, 2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f})
    y = y * m + c;
  return m + (y * m * z - 2.12194440e-4f * e - 0.5f * z) + 0.693359375f * e;
}

//! Sine and cosine of turns in 2^-32, as sine_cosine of vector8.hpp.
APC_INLINE void sine_cosine_of_turns(Words turns, V& sine, V& cosine) {
  const Mask quarter = (Mask)((turns + 0x20000000u) >> 30);  // the nearest
  const V y = __builtin_convertvector((Mask)(turns - ((Words)quarter << 30)), V) * 1.4629180793e-9f;
  const V z = y * y;
  const V s = y + y * z * (-1.6666654611e-1f + z * (8.3321608736e-3f + z * -1.9515295891e-4f));
  const V c = 1.0f - 0.5f * z +
              z * z * (4.166664568298827e-2f + z * (-1.388731625493765e-3f + z * 2.443315711809948e-5f));
  const Mask is_odd = -(quarter & 1);
  sine = (V)((Mask)select(is_odd, c, s) ^ ((quarter & 2) << 30));
  cosine = (V)((Mask)select(is_odd, s, c) ^ (((quarter + 1) & 2) << 30));
}

//! After Box and Muller 1958.
APC_INLINE void write_normals(Words a, Words b, float* out) {
  V sine, cosine;
  sine_cosine_of_turns(b, sine, cosine);
  const V radius = square_root(-2.0f * logarithm(uniform(a)));
  const V first = radius * cosine, second = radius * sine;
  __builtin_memcpy(out, &first, sizeof first);
  __builtin_memcpy(out + 8, &second, sizeof second);
}

}  // namespace

void fill_normals(const RandomRow& row, int n, float* out) {
  const Words zero{};
  Words place{0, 1, 2, 3, 4, 5, 6, 7};
  for (int done = 0; done < n; done += kNormalsPerBatch, place += 8u) {
    const Counter random = philox({{place, zero + row.row, zero + row.stream, zero}}, row.key[0], row.key[1]);
    write_normals(random.word[0], random.word[1], out + done);
    write_normals(random.word[2], random.word[3], out + done + 16);
  }
}

}  // namespace apc::simd8::APC_ARCHITECTURE
