//! \file
//! The sums of simd8_fit.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
#include "simd/simd8_fit.hpp"
#include "simd/vector8.hpp"

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

//! Distances of points to a surface, negative inside, and where they grow fastest.
struct Away {
  V distance, gradient[3];
};

APC_INLINE V with_sign_of(V sign, V a) { return (V)((Mask)a | ((Mask)sign & (Mask)all(-0.0f))); }

APC_INLINE Away from_ball(const FitSolid& solid, const V (&p)[3]) {
  const V r = square_root(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  const Mask is_off = above(r, V{});
  const V inverse = select(is_off, 1.0f / r, V{});
  return {r - solid.half[0], {inverse * p[0], inverse * p[1], select(is_off, inverse * p[2], all(1.0f))}};
}

APC_INLINE Away from_cylinder(const FitSolid& solid, const V (&p)[3]) {
  const V across = square_root(p[0] * p[0] + p[1] * p[1]);
  const Mask is_off = above(across, V{});
  const V inverse = select(is_off, 1.0f / across, V{});
  const V out[2] = {select(is_off, inverse * p[0], all(1.0f)), inverse * p[1]};
  const V q = across - solid.half[0], r = magnitude(p[2]) - solid.half[2];
  const V d = square_root(q * q + r * r);
  const Mask is_edge = above(q, V{}) & above(r, V{}), is_side = above(q, r);
  const V of_side = select(is_edge, q / d, select(is_side, all(1.0f), V{}));
  const V of_end = select(is_edge, r / d, select(is_side, V{}, all(1.0f)));
  return {select(is_edge, d, larger(q, r)),
          {of_side * out[0], of_side * out[1], with_sign_of(p[2], of_end)}};
}

APC_INLINE Away from_box(const FitSolid& solid, const V (&p)[3]) {
  V q[3], over[3];
  for (int i = 0; i < 3; ++i) {
    q[i] = magnitude(p[i]) - solid.half[i];
    over[i] = larger(q[i], V{});
  }
  const V outside = square_root(over[0] * over[0] + over[1] * over[1] + over[2] * over[2]);
  const V inside = larger(larger(q[0], q[1]), q[2]);
  const Mask is_out = above(outside, V{});
  const V inverse = 1.0f / outside;
  const Mask x_first = above(q[0], q[1]) & above(q[0], q[2]);
  const Mask y_first = ~above(q[0], q[1]) & above(q[1], q[2]);
  const Mask nearest[3] = {x_first, y_first, ~(x_first | y_first)};
  Away found;
  found.distance = select(is_out, outside, inside);
  for (int i = 0; i < 3; ++i)
    found.gradient[i] =
        with_sign_of(p[i], select(is_out, over[i] * inverse, select(nearest[i], all(1.0f), V{})));
  return found;
}

APC_INLINE Away away(const FitSolid& solid, const V (&p)[3]) {
  return solid.kind == SolidKind::box        ? from_box(solid, p)
         : solid.kind == SolidKind::cylinder ? from_cylinder(solid, p)
                                             : from_ball(solid, p);
}

APC_INLINE void locate(const FitSolid& solid, const FitPoints& points, int first, V (&p)[3]) {
  const V x = load(points.x + first), y = load(points.y + first), z = load(points.z + first);
  for (int i = 0; i < 3; ++i) p[i] = solid.R[i][0] * x + solid.R[i][1] * y + solid.R[i][2] * z + solid.t[i];
}

APC_INLINE Mask lanes_left(int n) { return n >= kLanes ? ~Mask{} : lanes((1 << n) - 1); }

APC_INLINE double total(V a) {
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += static_cast<double>(a[i]);
  return sum;
}

APC_INLINE double total(const Doubles& a) {
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += a[i];
  return sum;
}

}  // namespace

void sum_fit(const FitSolid& solid, const FitPoints& points, FitSums& out) {
  Doubles cost{};
  V gradient[6]{}, H[21]{};
  const float inverse_reach = 1.0f / solid.reach;
  for (int first = 0; first < points.n; first += kLanes) {
    V p[3];
    locate(solid, points, first, p);
    const Away found = away(solid, p);
    const V* g = found.gradient;
    const Mask is_point = lanes_left(points.n - first);
    const V d = found.distance, d2 = d * d, inverse = 1.0f / (solid.scale2 + d2);
    const V root = solid.scale2 * inverse, w = select(is_point, root * root, V{});
    cost += __builtin_convertvector(select(is_point, d2 * inverse, V{}), Doubles);
    const V row[6] = {-g[0],
                      -g[1],
                      -g[2],
                      inverse_reach * (p[2] * g[1] - p[1] * g[2]),
                      inverse_reach * (p[0] * g[2] - p[2] * g[0]),
                      inverse_reach * (p[1] * g[0] - p[0] * g[1])};
    int entry = 0;
    for (int a = 0; a < 6; ++a) {
      const V weighted = w * row[a];
      gradient[a] += d * weighted;
      for (int b = 0; b <= a; ++b) H[entry++] += weighted * row[b];
    }
  }
  out.cost = total(cost);
  int entry = 0;
  for (int a = 0; a < 6; ++a) {
    out.gradient[a] = total(gradient[a]);
    for (int b = 0; b <= a; ++b) out.H[a][b] = total(H[entry++]);
  }
}

double sum_fit_cost(const FitSolid& solid, const FitPoints& points) {
  Doubles cost{};
  for (int first = 0; first < points.n; first += kLanes) {
    V p[3];
    locate(solid, points, first, p);
    const V d = away(solid, p).distance, d2 = d * d;
    cost += __builtin_convertvector(
        select(lanes_left(points.n - first), d2 / (solid.scale2 + d2), V{}), Doubles);
  }
  return total(cost);
}

}  // namespace apc::simd8::APC_ARCHITECTURE
