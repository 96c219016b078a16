//! \file
//! Colour pictures: textures and plain colours under a lamp with shadows, light from everywhere, and a light
//! at the camera.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "rendering/raycasting_scene.hpp"
#include "rendering/texture.hpp"

namespace apc {

//! How a solid looks. Its faces are those of SurfacePoint; a ball has the faces of the box around it.
struct Look {
  Colour colour;                                        //!< of faces without a texture
  float gloss = 0.0f;                                   //!< of highlights, 0 to 1
  std::array<int, 6> textures{-1, -1, -1, -1, -1, -1};  //!< by face, -1: none
};

struct Looks {
  std::vector<Look> of_solids;
  std::vector<std::shared_ptr<const Texture>> textures;
};

//! Amounts of light on a white surface, of which 1 is white.
struct Lighting {
  double ambient = 0.0;    //!< from everywhere; a quarter less from below than from above
  double headlight = 0.0;  //!< of the light at the camera, square to a surface 0.5 m away
  double lamp = 0.0;       //!< of the lamp, square to a surface
  Pose T_world_lamp;       //!< it shines along its z and throws shadows within 45 degrees of that
  Colour background;       //!< where nothing is seen
};

//! Three numbers per pixel: red, green, blue.
std::vector<std::uint8_t> shaded(const RaycastingScene& scene, const PinholeCamera& camera,
                                 const Pose& T_world_camera, const Looks& looks, const Lighting& lighting);

}  // namespace apc
