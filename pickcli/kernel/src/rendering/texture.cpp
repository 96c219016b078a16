#include "rendering/texture.hpp"

#include <algorithm>

namespace apc {
namespace {

Colour pixel(const std::uint8_t* p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

}  // namespace

Texture::Texture(const std::uint8_t* rgb, int width, int height) {
  const std::size_t n = 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  levels_.push_back({width, height, std::vector<std::uint8_t>(rgb, rgb + n)});
  while (levels_.back().width > 1 && levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{fine.width / 2, fine.height / 2, {}};
    coarse.rgb.reserve(3 * static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
    const std::size_t row = 3 * static_cast<std::size_t>(fine.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(coarse.height); ++y)
      for (std::size_t x = 0; x < static_cast<std::size_t>(coarse.width); ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t i = 2 * y * row + 6 * x + c;
          const int sum = fine.rgb[i] + fine.rgb[i + 3] + fine.rgb[i + row] + fine.rgb[i + row + 3];
          coarse.rgb.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
        }
    levels_.push_back(std::move(coarse));
  }
}

Colour Texture::at(float u, float v, float covered) const {
  std::size_t chosen = 0;
  for (; covered > 1.4f && chosen + 1 < levels_.size(); covered *= 0.5f) ++chosen;
  const Level& level = levels_[chosen];
  const float x =
      std::clamp(u * static_cast<float>(level.width) - 0.5f, 0.0f, static_cast<float>(level.width - 1));
  const float y =
      std::clamp(v * static_cast<float>(level.height) - 0.5f, 0.0f, static_cast<float>(level.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const std::size_t right = x0 + 1 < level.width ? 3 : 0, row = 3 * static_cast<std::size_t>(level.width);
  const std::size_t down = y0 + 1 < level.height ? row : 0;
  const std::uint8_t* p =
      level.rgb.data() + static_cast<std::size_t>(y0) * row + 3 * static_cast<std::size_t>(x0);
  return (1.0f - b) * ((1.0f - a) * pixel(p) + a * pixel(p + right)) +
         b * ((1.0f - a) * pixel(p + down) + a * pixel(p + down + right));
}

}  // namespace apc
