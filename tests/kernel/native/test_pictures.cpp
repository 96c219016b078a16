//! \file
//! Pictures: no access goes beyond an array, whatever the camera sees, and random words are those of the
//! authors.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "random_cases.hpp"
#include "rendering/counter_random.hpp"
#include "rendering/depth_noise.hpp"
#include "rendering/portable_math.hpp"
#include "rendering/shading.hpp"

using namespace apc;

namespace {

RaycastingScene random_scene(test::Random& random, int n) {
  std::vector<RenderedSolid> solids;
  for (int i = 0; i < n; ++i) {
    const auto kind = static_cast<SolidKind>(i % 3);
    Vec3 half{random.between(0.01, 0.5), random.between(0.01, 0.5), random.between(0.01, 0.5)};
    if (kind != SolidKind::box) half.y = half.x;
    if (kind == SolidKind::sphere) half.z = half.x;
    std::vector<Plane> planes;
    if (i % 6 == 0) planes = {{{0.6, 0.0, 0.8}, 0.3 * half.z}, {{0.0, 1.0, 0.0}, 0.5 * half.y}};
    solids.push_back({random.pose(1.5), half, kind, planes});
  }
  return RaycastingScene(std::move(solids));
}

}  // namespace

TEST_CASE("random words are those of Random123") {
  CHECK(philox({0, 0, 0, 0}, 0, 0) == Words{0x6627E8D5u, 0xE169C58Du, 0xBC57AC4Cu, 0x9B00DBD8u});
  CHECK(philox({0x243F6A88u, 0x85A308D3u, 0x13198A2Eu, 0x03707344u}, 0xA4093822u, 0x299F31D0u) ==
        Words{0xD16CFE09u, 0x94FDCCEBu, 0x5001E420u, 0x24126EA1u});
}

TEST_CASE("rows of normal numbers are made of the same words in both builds") {
  const CounterRandom random(0x123456789ABCDEFull);
  std::vector<float> fast, slow;
  random.fill_normals(7, 3, 1000, fast);
  const char* before = simd_name();
  set_simd("baseline");
  random.fill_normals(7, 3, 1000, slow);
  set_simd(before);
  CHECK(fast == slow);
  // The first lane's first two numbers, by Box and Muller in double from the words of its counter.
  const Words words = random.at(0, 7, 3);
  const double radius = std::sqrt(-2.0 * std::log((static_cast<double>(words[0] >> 9) + 0.5) * 0x1p-23));
  const double angle = static_cast<double>(words[1]) * 0x1p-32 * 2.0 * 3.14159265358979323846;
  CHECK_LE(std::abs(fast[0] - radius * std::cos(angle)), 1e-5);
  CHECK_LE(std::abs(fast[8] - radius * std::sin(angle)), 1e-5);
}

TEST_CASE("the arc cosine is that of the library up to roundings") {
  for (int i = 0; i <= 1000; ++i) {
    const float x = static_cast<float>(i) / 1000.0f;
    CHECK_LE(std::abs(portable::arc_cosine(x) - std::acos(static_cast<double>(x))), 5e-7);
  }
}

TEST_CASE("pictures of any size from anywhere stay within their arrays") {
  test::Random random(5);
  for (int i = 0; i < 60; ++i) {
    const RaycastingScene scene = random_scene(random, i % 20);
    const PinholeCamera camera{random.between(5.0, 300.0),  random.between(5.0, 300.0),
                               random.between(-40.0, 90.0), random.between(-40.0, 90.0),
                               1 + (37 * i) % 71,           1 + (29 * i) % 53};
    const Pose T = random.pose(1.5);
    DepthNoise noise;
    noise.constant = 0.01;
    noise.lateral = 3.0;
    noise.lateral_oblique = 1.0;
    noise.baseline = i % 2 ? 0.1 : 0.0;
    noise.disparity_step = i % 2 ? 0.5 : 0.0;
    noise.correlation = 1.0;
    noise.mixes_edges = i % 3 == 0;
    noise.least = 0.1;
    noise.greatest = 3.0;
    noise.incidence_from = 1.0;
    noise.incidence_to = 1.5;
    check(noise);
    const std::size_t n = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    const std::vector<float> shares(scene.solids().size(), 0.3f);
    CHECK(measured_depth(scene, camera, T, noise, shares, 9).size() == n);
    const std::vector<std::uint8_t> pixels(3 * 5 * 7, 128);
    Looks looks;
    looks.textures = {std::make_shared<const Texture>(pixels.data(), 5, 7),
                      std::make_shared<const Texture>(pixels.data(), 1, 1)};
    for (std::size_t k = 0; k < scene.solids().size(); ++k)
      looks.of_solids.push_back({{200.0f, 10.0f, 30.0f}, 0.5f, {0, 1, 0, -1, 1, 0}});
    const Lighting light{0.3, 0.4, 0.5, random.pose(2.0), {}};
    CHECK(shaded(scene, camera, T, looks, light).size() == 3 * n);
  }
}
