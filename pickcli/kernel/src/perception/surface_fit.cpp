#include "perception/surface_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simd/dispatch.hpp"

namespace apc {
namespace {

constexpr double kSmallStep = 2e-6;      //!< m: a fit that moves less has converged
constexpr double kLargestRegion = 0.03;  //!< m that a step may move the surface at most
constexpr double kDamping = 1e-9;        //!< of the diagonal, where points leave a direction free

using Vector6 = std::array<double, 6>;

double sign_of(double x) { return x < 0.0 ? -1.0 : 1.0; }

//! Sums over all points, with turns in m at the solid's reach.
struct NormalEquations {
  double cost = 0.0;
  Vector6 gradient{};
  std::array<Vector6, 6> H{};
};

//! The problem of one fit. A change is (move, turn * reach) along the solid's axes, the turn about its centre;
//! an upright one is (move, turn * reach about up).
class Problem {
 public:
  Problem(SolidKind kind, const Vec3& half, const std::vector<Vec3>& points, const Pose& start,
          const FitSettings& settings)
      : settings_(settings),
        reach_(norm(half)),
        n_(settings.freedom == Freedom::upright ? 4 : 6),
        n_points_(static_cast<int>(points.size())),
        origin_(start.p),
        sum_(fit_sums()),
        sum_cost_(fit_cost()) {
    const std::size_t padded = points.size() + simd8::kLanes;
    for (std::vector<float>* each : {&x_, &y_, &z_}) each->resize(padded, 0.0f);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 p = points[i] - origin_;
      x_[i] = static_cast<float>(p.x);
      y_[i] = static_cast<float>(p.y);
      z_[i] = static_cast<float>(p.z);
    }
    solid_.kind = kind;
    write(half, solid_.half);
    solid_.scale2 = static_cast<float>(settings.scale * settings.scale);
    solid_.reach = static_cast<float>(reach_);
  }

  int size() const { return n_; }

  double cost(const Pose& T) const { return sum_cost_(at(T), points()) / n_points_; }

  NormalEquations equations(const Pose& T) const {
    simd8::FitSums sums;
    sum_(at(T), points(), sums);
    NormalEquations out;
    out.cost = sums.cost / n_points_;
    for (std::size_t a = 0; a < 6; ++a) {
      out.gradient[a] = sums.gradient[a];
      for (std::size_t b = 0; b <= a; ++b) out.H[a][b] = out.H[b][a] = sums.H[a][b];
    }
    return n_ == 4 ? upright(out, transposed(T.R) * settings_.up) : out;
  }

  Pose moved(const Pose& T, const Vector6& step) const {
    const Vec3 turn = n_ == 4 ? (step[3] / reach_) * settings_.up
                              : (1.0 / reach_) * (T.R * Vec3{step[3], step[4], step[5]});
    const double angle = norm(turn);
    Pose out = T;
    if (angle > 0.0) out.R = rotation((1.0 / angle) * turn, angle) * T.R;
    out.p = T.p + T.R * Vec3{step[0], step[1], step[2]};
    return out;
  }

 private:
  static void write(const Vec3& v, float* out) {
    out[0] = static_cast<float>(v.x);
    out[1] = static_cast<float>(v.y);
    out[2] = static_cast<float>(v.z);
  }

  simd8::FitPoints points() const { return {x_.data(), y_.data(), z_.data(), n_points_}; }

  simd8::FitSolid at(const Pose& T) const {
    simd8::FitSolid out = solid_;
    const Mat3 R = transposed(T.R);
    const Vec3 t = R * (origin_ - T.p);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        out.R[i][k] = static_cast<float>(R(static_cast<int>(i), static_cast<int>(k)));
    write(t, out.t);
    return out;
  }

  //! Of turns about one axis only, which is given in the solid's frame.
  static NormalEquations upright(const NormalEquations& all, const Vec3& up) {
    const std::array<double, 3> axis{up.x, up.y, up.z};
    NormalEquations out;
    out.cost = all.cost;
    for (std::size_t a = 0; a < 3; ++a) {
      out.gradient[a] = all.gradient[a];
      out.gradient[3] += axis[a] * all.gradient[3 + a];
      for (std::size_t b = 0; b < 3; ++b) {
        out.H[a][b] = all.H[a][b];
        out.H[3][a] += axis[b] * all.H[3 + b][a];
        out.H[3][3] += axis[a] * axis[b] * all.H[3 + a][3 + b];
      }
      out.H[a][3] = out.H[3][a];
    }
    return out;
  }

  const FitSettings& settings_;
  double reach_;
  int n_, n_points_;
  Vec3 origin_;
  std::vector<float> x_, y_, z_;
  simd8::FitSolid solid_{};
  simd8::SumFit sum_;
  simd8::SumFitCost sum_cost_;
};

double length(const Vector6& v) {
  double sum = 0.0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

//! Of the quadratic model, by Cholesky; directions that no point resists are damped.
Vector6 newton_step(const NormalEquations& e, int n) {
  std::array<Vector6, 6> L{};
  double largest = 0.0;
  for (int i = 0; i < n; ++i)
    largest = std::max(largest, e.H[static_cast<std::size_t>(i)][static_cast<std::size_t>(i)]);
  Vector6 y{};
  const auto N = static_cast<std::size_t>(n);
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = e.H[i][j] + (i == j ? kDamping * largest + 1e-12 : 0.0);
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      L[i][j] = i == j ? std::sqrt(std::max(sum, 1e-12)) : sum / L[j][j];
    }
    y[i] = -e.gradient[i];
    for (std::size_t k = 0; k < i; ++k) y[i] -= L[i][k] * y[k];
    y[i] /= L[i][i];
  }
  Vector6 x{};
  for (std::size_t i = N; i-- > 0;) {
    x[i] = y[i];
    for (std::size_t k = i + 1; k < N; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
  return x;
}

//! Powell 1970: along the steepest descent to the minimum of the model on it, from there towards the minimum
//! of the model, and no farther than the region that is trusted.
Vector6 dogleg_step(const NormalEquations& e, int n, double region) {
  const Vector6 newton = newton_step(e, n);
  const double far = length(newton);
  if (far <= region) return newton;
  double g2 = 0.0, curvature = 0.0;
  for (std::size_t a = 0; a < 6; ++a) {
    g2 += e.gradient[a] * e.gradient[a];
    for (std::size_t b = 0; b < 6; ++b) curvature += e.gradient[a] * e.H[a][b] * e.gradient[b];
  }
  const double steep = std::sqrt(g2);
  if (!(steep > 0.0)) return {};
  const double down = curvature > 0.0 ? g2 / curvature : region / steep;
  Vector6 step{};
  if (down * steep >= region) {
    for (std::size_t a = 0; a < 6; ++a) step[a] = -region / steep * e.gradient[a];
    return step;
  }
  double aa = 0.0, ab = 0.0, bb = 0.0;
  Vector6 across{};
  for (std::size_t a = 0; a < 6; ++a) {
    step[a] = -down * e.gradient[a];
    across[a] = newton[a] - step[a];
    aa += across[a] * across[a];
    ab += across[a] * step[a];
    bb += step[a] * step[a];
  }
  const double root = std::sqrt(std::max(ab * ab + aa * (region * region - bb), 0.0));
  const double share = aa > 0.0 ? (root - ab) / aa : 0.0;
  for (std::size_t a = 0; a < 6; ++a) step[a] += share * across[a];
  return step;
}

}  // namespace

SurfaceDistance surface_distance(SolidKind kind, const Vec3& half, const Vec3& p) {
  if (kind == SolidKind::sphere) {
    const double r = norm(p);
    return {r - half.x, r > 0.0 ? (1.0 / r) * p : Vec3{0.0, 0.0, 1.0}};
  }
  const Vec3 side{sign_of(p.x), sign_of(p.y), sign_of(p.z)};
  if (kind == SolidKind::cylinder) {
    const double across = std::sqrt(p.x * p.x + p.y * p.y);
    const Vec3 out = across > 0.0 ? Vec3{p.x / across, p.y / across, 0.0} : Vec3{1.0, 0.0, 0.0};
    const double q = across - half.x, r = std::abs(p.z) - half.z;
    const Vec3 up{0.0, 0.0, side.z};
    if (q <= 0.0 || r <= 0.0) return q > r ? SurfaceDistance{q, out} : SurfaceDistance{r, up};
    const double d = std::sqrt(q * q + r * r);
    return {d, (q / d) * out + (r / d) * up};
  }
  const Vec3 q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
  const Vec3 over{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
  const double d = norm(over);
  if (d > 0.0) return {d, {side.x * over.x / d, side.y * over.y / d, side.z * over.z / d}};
  if (q.x > q.y)
    return q.x > q.z ? SurfaceDistance{q.x, {side.x, 0, 0}} : SurfaceDistance{q.z, {0, 0, side.z}};
  return q.y > q.z ? SurfaceDistance{q.y, {0, side.y, 0}} : SurfaceDistance{q.z, {0, 0, side.z}};
}

SurfaceFit fit_surface(SolidKind kind, const Vec3& half, const std::vector<Vec3>& points, const Pose& start,
                       const FitSettings& settings) {
  if (points.empty()) return {start, 0.0, 0};
  const Problem problem(kind, half, points, start, settings);
  SurfaceFit fit{start, 0.0, 0};
  NormalEquations at = problem.equations(fit.T);
  fit.cost = at.cost;
  double region = 0.5 * kLargestRegion;
  const double scale2 = settings.scale * settings.scale, n = static_cast<double>(points.size());
  for (; fit.steps < settings.most_steps && region > kSmallStep; ++fit.steps) {
    const Vector6 step = dogleg_step(at, problem.size(), region);
    const double far = length(step);
    if (far < kSmallStep) break;
    double promised = 0.0;  // decrease by the quadratic model, in units of the cost
    for (std::size_t a = 0; a < 6; ++a) {
      promised -= 2.0 * at.gradient[a] * step[a];
      for (std::size_t b = 0; b < 6; ++b) promised -= step[a] * at.H[a][b] * step[b];
    }
    promised /= scale2 * n;
    const Pose next = problem.moved(fit.T, step);
    const double cost = problem.cost(next), gained = fit.cost - cost;
    if (gained < 0.25 * promised) region = 0.25 * far;
    if (gained > 0.75 * promised) region = std::min(std::max(region, 2.0 * far), kLargestRegion);
    if (!(gained > 0.0)) continue;
    fit.T = next;
    at = problem.equations(fit.T);
    fit.cost = cost;
    if (gained < 1e-7) break;
  }
  return fit;
}

}  // namespace apc
