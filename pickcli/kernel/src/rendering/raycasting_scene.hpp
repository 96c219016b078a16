//! \file
//! What a camera sees of solids: depth, which solid, and the normals of surfaces, exact and without any mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/linear.hpp"
#include "rendering/pinhole_camera.hpp"
#include "simd/simd8_rays.hpp"

namespace apc {

//! All points p with normal . p <= offset; the normal has length 1.
struct Plane {
  Vec3 normal;
  double offset = 0.0;
};

//! A box, cylinder about its z or sphere; a box may be cut by planes to a convex piece.
struct RenderedSolid {
  Pose T_world_solid;
  Vec3 half;  //!< half extents, m
  simd8::SolidKind kind = simd8::SolidKind::box;
  std::vector<Plane> planes;  //!< in its frame
};

//! Pictures row by row; each a number per pixel.
struct RayHits {
  std::vector<float> depth;         //!< m along the optical axis, NaN where nothing is seen
  std::vector<std::int32_t> index;  //!< of the solid, -1 where nothing is seen
};

//! Where a ray meets a solid.
struct SurfacePoint {
  Vec3 point;   //!< in the solid's frame
  Vec3 normal;  //!< in the solid's frame, outwards
  int face;     //!< box: +x, -x, +y, -y, +z, -z; cylinder: +z, -z, mantle; sphere: 0; a plane: 6 + its number
};

//! A solid that the camera's centre is inside of is not seen: it is the camera's own body.
class RaycastingScene {
 public:
  explicit RaycastingScene(std::vector<RenderedSolid> solids) : solids_(std::move(solids)) {}

  const std::vector<RenderedSolid>& solids() const { return solids_; }

  RayHits cast_rays(const PinholeCamera& camera, const Pose& T_world_camera) const;

  //! Normals in the camera's frame, three numbers per pixel; NaN where nothing is seen.
  std::vector<float> normals(const PinholeCamera& camera, const Pose& T_world_camera,
                             const RayHits& hits) const;

 private:
  std::vector<RenderedSolid> solids_;
};

//! The surface at a point on it, found up to roundings, in the solid's frame.
SurfacePoint surface_at(const RenderedSolid& solid, const Vec3& point);

}  // namespace apc
