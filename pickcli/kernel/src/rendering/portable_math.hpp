//! \file
//! Functions whose bits do not depend on the C library: of pictures the same seed gives the same bytes
//! everywhere.
#pragma once

#include <cmath>

namespace apc::portable {

//! Of x in [0, 1]: Abramowitz and Stegun, 4.4.46, off by less than 1e-7 rad and some roundings.
inline float arc_cosine(float x) {
  float y = -0.0012624911f;
  for (const float c : {0.0066700901f, -0.0170881256f, 0.0308918810f, -0.0501743046f, 0.0889789874f,
                        -0.2145988016f, 1.5707963050f})
    y = y * x + c;
  return std::sqrt(1.0f - x) * y;
}

}  // namespace apc::portable
