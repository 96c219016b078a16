//! \file
//! Random numbers by counter: what a pixel draws depends on its place and the seed alone, not on who drew
//! before.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "simd/dispatch.hpp"

namespace apc {

using Words = std::array<std::uint32_t, 4>;

//! Philox4x32-10 of Salmon, Moraes, Dror and Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3".
inline Words philox(Words counter, std::uint32_t key0, std::uint32_t key1) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53u} * counter[0],
                        b = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key0, static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key1, static_cast<std::uint32_t>(a)};
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  return counter;
}

//! In (0, 1): the middle of one of 2^23 equal steps, which single precision holds exactly.
inline float uniform(std::uint32_t word) { return (static_cast<float>(word >> 9) + 0.5f) * 0x1p-23f; }

//! Independent streams of one seed.
class CounterRandom {
 public:
  explicit CounterRandom(std::uint64_t seed)
      : low_(static_cast<std::uint32_t>(seed)), high_(static_cast<std::uint32_t>(seed >> 32)) {}

  //! Four words of a place in a stream.
  Words at(int u, int v, std::uint32_t stream) const {
    return philox({static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v), stream, 0}, low_, high_);
  }

  //! At least n independent numbers of the standard normal distribution, of a row of a stream.
  void fill_normals(int row, std::uint32_t stream, std::size_t n, std::vector<float>& out) const {
    constexpr std::size_t batch = simd8::kNormalsPerBatch;
    out.resize((n + batch - 1) / batch * batch);
    const simd8::RandomRow from{{low_, high_}, static_cast<std::uint32_t>(row), stream};
    normals_filler()(from, static_cast<int>(out.size()), out.data());
  }

 private:
  std::uint32_t low_, high_;
};

}  // namespace apc
