//! \file
//! Items against pictures of places: no access goes beyond an array, whatever the window, an item costs what its
//! pixels do, and both builds give the same bits.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "perception/item_search.hpp"
#include "perception/place_picture.hpp"
#include "perception/surface_fit.hpp"
#include "random_cases.hpp"
#include "simd/dispatch.hpp"

using namespace apc;

namespace {

constexpr int kWidth = 21, kHeight = 11;  // no multiples of eight
const std::vector<Vec3> kHalf{{0.05, 0.03, 0.02}, {0.03, 0.03, 0.06}, {0.04, 0.04, 0.04}};  // by kind

//! A wall with holes in depth, and a column that is not of the place.
PlacePicture random_picture(test::Random& random) {
  MeasuredPicture measured{{25.0, 25.0, 10.0, 5.0, kWidth, kHeight}, {}, {}, {}};
  KnownSurface known;
  for (int pixel = 0; pixel < kWidth * kHeight; ++pixel) {
    const bool is_lost = random.below(4) == 0;
    measured.depth.push_back(is_lost ? std::numeric_limits<float>::quiet_NaN()
                                     : static_cast<float>(random.between(0.4, 0.62)));
    measured.share.push_back(is_lost ? 0.0f : static_cast<float>(random.between(0.1, 1.0)));
    measured.colour.push_back(random.below(3));
    known.depth.push_back(pixel % kWidth == 4 ? std::numeric_limits<float>::quiet_NaN() : 0.6f);
    known.facing.push_back(1.0f);
  }
  DepthNoise noise;
  noise.constant = 0.001;
  noise.baseline = 0.1;
  noise.least = 0.1;
  noise.greatest = 3.0;
  noise.incidence_from = 1.1;
  noise.incidence_to = 1.4;
  PlacePicture picture(std::move(measured), std::move(known), {0.0f, 0.1f, -0.1f}, noise, {});
  for (std::size_t kind = 0; kind < kHalf.size(); ++kind)
    picture.add({static_cast<SolidKind>(kind), kHalf[kind], 0.2, {0.2f, -0.3f, 0.1f}});
  return picture;
}

Pose before_camera(test::Random& random) {
  Pose T = random.pose(0.15);
  T.p.z = random.between(0.0, 0.7);
  return T;
}

}  // namespace

TEST_CASE("an item costs what its pixels do, at the edges of the picture too") {
  test::Random random(5);
  const PlacePicture picture = random_picture(random);
  int n_shown = 0, n_hidden = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const int kind = trial % 3;
    const Composite others = composed(picture, {{random.below(3), before_camera(random)}}, -1);
    const Pose T = before_camera(random);
    const Sight sight = picture.sight(kind, T);
    int shown = 0;
    const double cost = picture.cost_before(kind, T, others, &shown);
    CHECK_LE(std::abs(cost - cost_before(sight, others)), 1e-4);
    int expected = 0;
    for (std::size_t i = 0; i < sight.pixel.size(); ++i) {
      const auto pixel = static_cast<std::size_t>(sight.pixel[i]);
      REQUIRE_LT(pixel, picture.n_pixels());
      CHECK_NE(pixel % kWidth, 4u);
      CHECK_LT(sight.depth[i], picture.known_depth()[pixel]);
      expected += sight.depth[i] < others.depth[pixel];
    }
    CHECK_EQ(shown, expected);
    n_shown += shown;
    n_hidden += static_cast<int>(sight.pixel.size()) - shown;
  }
  CHECK_GT(n_shown, 1000);
  CHECK_GT(n_hidden, 100);
}

TEST_CASE("both builds cost and fit to the same bits") {
  const char* fastest = simd_name();
  std::vector<double> found[2];
  for (int build = 0; build < 2; ++build) {
    set_simd(build ? fastest : "baseline");
    test::Random random(9);
    const PlacePicture picture = random_picture(random);
    const Composite nothing = known_only(picture);
    for (int trial = 0; trial < 300; ++trial) {
      const auto kind = static_cast<std::size_t>(trial % 3);
      const Pose T = before_camera(random);
      found[build].push_back(picture.cost_before(static_cast<int>(kind), T, nothing));
      std::vector<Vec3> points;
      for (int i = random.below(40); i >= 0; --i) points.push_back(T.p + random.point(0.08));
      const SurfaceFit fit = fit_surface(static_cast<SolidKind>(kind), kHalf[kind], points, T, {});
      for (const double x : {fit.T.p.x, fit.T.p.y, fit.T.p.z, fit.T.R(0, 1), fit.cost})
        found[build].push_back(x);
    }
  }
  set_simd(fastest);
  CHECK_EQ(std::memcmp(found[0].data(), found[1].data(), found[0].size() * sizeof(double)), 0);
}
