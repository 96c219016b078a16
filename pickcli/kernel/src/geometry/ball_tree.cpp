#include "geometry/ball_tree.hpp"

#include <algorithm>

namespace apc {
namespace {

constexpr int kLeafSpheres = 4;

double component(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

int widest_axis(const Sphere* first, const Sphere* last) {
  int widest = 0;
  double most = -1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(first, last, [axis](const Sphere& a, const Sphere& b) {
      return component(a.center, axis) < component(b.center, axis);
    });
    const double width = component(high->center, axis) - component(low->center, axis);
    if (width > most) widest = axis, most = width;
  }
  return widest;
}

void add_nodes(Sphere* first, Sphere* last, std::vector<BallNode>& nodes) {
  const std::size_t self = nodes.size();
  nodes.push_back({ball_around(first, last), 0, false});
  if (last - first <= kLeafSpheres) {
    for (const Sphere* s = first; s != last; ++s)
      nodes.push_back({*s, static_cast<int>(nodes.size()) + 1, true});
  } else {
    const int axis = widest_axis(first, last);
    Sphere* middle = first + (last - first) / 2;
    std::stable_sort(first, last, [axis](const Sphere& a, const Sphere& b) {
      return component(a.center, axis) < component(b.center, axis);
    });
    add_nodes(first, middle, nodes);
    add_nodes(middle, last, nodes);
  }
  nodes[self].next = static_cast<int>(nodes.size());
}

}  // namespace

//! From the centre of the bounding box, walk towards whatever sticks out most in ever smaller steps
//! (Badoiu and Clarkson), and keep the best centre met.
Sphere ball_around(const Sphere* first, const Sphere* last) {
  Vec3 low = first->center, high = first->center;
  for (const Sphere* s = first; s != last; ++s) {
    low = {std::min(low.x, s->center.x), std::min(low.y, s->center.y), std::min(low.z, s->center.z)};
    high = {std::max(high.x, s->center.x), std::max(high.y, s->center.y), std::max(high.z, s->center.z)};
  }
  Vec3 center = 0.5 * (low + high);
  Sphere best{center, -1.0};
  for (int i = 2; i < 18; ++i) {
    const Sphere* farthest = first;
    double radius = -1.0;
    for (const Sphere* s = first; s != last; ++s) {
      const double reach = norm(s->center - center) + s->radius;
      if (reach > radius) farthest = s, radius = reach;
    }
    if (best.radius < 0.0 || radius < best.radius) best = {center, radius};
    center = center + (1.0 / i) * (1.0 - farthest->radius / radius) * (farthest->center - center);
  }
  return best;
}

std::vector<BallNode> build_ball_tree(std::vector<Sphere> spheres) {
  std::vector<BallNode> nodes;
  if (!spheres.empty()) add_nodes(spheres.data(), spheres.data() + spheres.size(), nodes);
  return nodes;
}

}  // namespace apc
