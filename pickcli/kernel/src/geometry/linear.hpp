//! \file
//! Small fixed-size linear algebra in double: what forward kinematics and boxes need.
#pragma once

#include <array>
#include <cmath>

namespace apc {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Mat3 {
  std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};  //!< row-major

  double operator()(int row, int column) const { return m[3 * row + column]; }
  double& operator()(int row, int column) { return m[3 * row + column]; }
  Vec3 column(int j) const { return {m[j], m[3 + j], m[6 + j]}; }
};

inline Mat3 from_columns(const Vec3& x, const Vec3& y, const Vec3& z) {
  return {{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}};
}

inline Vec3 operator*(const Mat3& R, const Vec3& v) {
  return {R(0, 0) * v.x + R(0, 1) * v.y + R(0, 2) * v.z, R(1, 0) * v.x + R(1, 1) * v.y + R(1, 2) * v.z,
          R(2, 0) * v.x + R(2, 1) * v.y + R(2, 2) * v.z};
}

inline Mat3 operator*(const Mat3& A, const Mat3& B) {
  return from_columns(A * B.column(0), A * B.column(1), A * B.column(2));
}

inline Mat3 transposed(const Mat3& R) {
  return {{R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), R(0, 2), R(1, 2), R(2, 2)}};
}

struct Pose {
  Mat3 R;
  Vec3 p;
};

inline Vec3 operator*(const Pose& T, const Vec3& v) { return T.R * v + T.p; }
inline Pose operator*(const Pose& A, const Pose& B) { return {A.R * B.R, A * B.p}; }
inline Pose inverse(const Pose& T) {
  const Mat3 R = transposed(T.R);
  return {R, -1.0 * (R * T.p)};
}

//! Rotation about a unit axis by an angle in rad (Rodrigues).
inline Mat3 rotation(const Vec3& a, double angle) {
  const double s = std::sin(angle), c = std::cos(angle), k = 1.0 - c;
  return {{c + k * a.x * a.x, k * a.x * a.y - s * a.z, k * a.x * a.z + s * a.y, k * a.y * a.x + s * a.z,
           c + k * a.y * a.y, k * a.y * a.z - s * a.x, k * a.z * a.x - s * a.y, k * a.z * a.y + s * a.x,
           c + k * a.z * a.z}};
}

//! Some right-handed rotation whose third column is the unit vector z.
inline Mat3 rotation_with_z(const Vec3& z) {
  const Vec3 helper = std::abs(z.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 y = cross(z, helper);
  y = (1.0 / norm(y)) * y;
  return from_columns(cross(y, z), y, z);
}

//! Rotation vector (axis times angle, angle in [0, pi]) of R; well-conditioned at both ends.
inline Vec3 rotation_vector(const Mat3& R) {
  const Vec3 v{R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1)};  // 2 sin(angle) axis
  const double trace = R(0, 0) + R(1, 1) + R(2, 2);
  const double sine = norm(v), cosine = trace - 1.0;  // both doubled
  if (cosine > 0.0 || sine > 1e-3) {
    const double angle = std::atan2(sine, cosine);
    return (sine > 1e-12 ? angle / sine : 0.5) * v;
  }
  // Near pi the sine vanishes: the axis is the largest column of R + R^T - (trace - 1) I.
  Vec3 axis;
  for (int j = 0; j < 3; ++j) {
    Vec3 column{R(0, j) + R(j, 0), R(1, j) + R(j, 1), R(2, j) + R(j, 2)};
    (j == 0 ? column.x : j == 1 ? column.y : column.z) -= cosine;
    if (norm(column) > norm(axis)) axis = column;
  }
  const double sign = dot(axis, v) < 0.0 ? -1.0 : 1.0;
  return (sign * std::atan2(sine, cosine) / norm(axis)) * axis;
}

}  // namespace apc
