//! \file
//! Pictures on faces, with smaller and smaller copies of each for what is far away (mipmaps, Williams 1983).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace apc {

//! Red, green and blue, 0 to 255; their squares are amounts of light.
struct Colour {
  float r = 0.0f, g = 0.0f, b = 0.0f;
};

inline Colour operator+(const Colour& a, const Colour& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Colour operator*(float s, const Colour& a) { return {s * a.r, s * a.g, s * a.b}; }

class Texture {
 public:
  //! Rows from the top, each of red, green, blue by column.
  Texture(const std::uint8_t* rgb, int width, int height);

  int width() const { return levels_.front().width; }

  //! At a place in [0, 1] from the left and from the top, where a pixel of the camera covers so many of the
  //! texture's.
  Colour at(float u, float v, float covered) const;

 private:
  struct Level {
    int width, height;
    std::vector<std::uint8_t> rgb;
  };

  std::vector<Level> levels_;  //!< each half as wide and high as the one before
};

}  // namespace apc
