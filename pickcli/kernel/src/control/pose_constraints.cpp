#include "control/pose_constraints.hpp"

namespace apc {
namespace {

constexpr double kOnIt = 1e-12;  // m from a line or a point, within which there is no normal

//! Where a point is relative to a reference.
struct Place {
  double distance;  //!< m
  Vec3 normal;      //!< unit; 0 on the line or the point itself
};

Place place(const Reference& reference, const Vec3& o) {
  const Vec3 off = o - reference.origin;
  const double along = dot(off, reference.axis);
  if (reference.kind == ReferenceKind::plane) return {along, reference.axis};
  const Vec3 from = reference.kind == ReferenceKind::line ? off - along * reference.axis : off;
  const double distance = norm(from);
  return {distance, distance > kOnIt ? (1.0 / distance) * from : Vec3{}};
}

//! Gradient by o of n(o) . v: (I - n n^T - a a^T) v / d, without a a^T for a point, 0 for a plane.
Vec3 gradient_of_normal(const Reference& reference, const Place& at, const Vec3& v) {
  if (reference.kind == ReferenceKind::plane || at.distance <= kOnIt) return {};
  Vec3 across = v - dot(v, at.normal) * at.normal;
  if (reference.kind == ReferenceKind::line) across = across - dot(v, reference.axis) * reference.axis;
  return (1.0 / at.distance) * across;
}

std::array<double, 6> joined(const Vec3& v, const Vec3& w) { return {v.x, v.y, v.z, w.x, w.y, w.z}; }

}  // namespace

double PoseConstraint::value(const Pose& T) const {
  const Place at = place(reference, T.p);
  switch (kind) {
    case PoseConstraintKind::distance_at_most: return at.distance - bound;
    case PoseConstraintKind::distance_at_least: return bound - at.distance;
    case PoseConstraintKind::tool_to_fixed: return bound - dot(T.R * tool, fixed);
    case PoseConstraintKind::tool_to_normal: return bound - dot(T.R * tool, at.normal);
    case PoseConstraintKind::normal_to_fixed: return bound - dot(at.normal, fixed);
  }
  return 0.0;
}

std::array<double, 6> PoseConstraint::gradient(const Pose& T) const {
  const Place at = place(reference, T.p);
  const Vec3 u = T.R * tool;  // d(u . v) = w . (u x v)
  switch (kind) {
    case PoseConstraintKind::distance_at_most: return joined(at.normal, {});
    case PoseConstraintKind::distance_at_least: return joined(-1.0 * at.normal, {});
    case PoseConstraintKind::tool_to_fixed: return joined({}, cross(fixed, u));
    case PoseConstraintKind::tool_to_normal:
      return joined(-1.0 * gradient_of_normal(reference, at, u), cross(at.normal, u));
    case PoseConstraintKind::normal_to_fixed:
      return joined(-1.0 * gradient_of_normal(reference, at, fixed), {});
  }
  return {};
}

}  // namespace apc
