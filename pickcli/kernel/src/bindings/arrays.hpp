//! \file
//! Numpy arrays in and out: checked views of what comes in, owned arrays for what goes out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "geometry/linear.hpp"

//! Arrays in the signatures that Python sees; what is given may be anything that numpy makes one of.
#define APC_F64 "numpy.typing.NDArray[numpy.float64]"
#define APC_F32 "numpy.typing.NDArray[numpy.float32]"
#define APC_I32 "numpy.typing.NDArray[numpy.int32]"
#define APC_U8 "numpy.typing.NDArray[numpy.uint8]"
#define APC_U64 "numpy.typing.NDArray[numpy.uint64]"
#define APC_BOOL "numpy.typing.NDArray[numpy.bool_]"

namespace apc {

namespace nb = nanobind;

inline constexpr Py_ssize_t kAny = -1;  //!< an extent that may be anything

//! A C-contiguous view of an array-like with the given shape. An array of the right type is not copied and
//! costs about 50 ns; anything else goes through numpy. Raises ValueError naming the argument.
template <typename T>
class View {
 public:
  View(nb::handle object, const char* name, std::initializer_list<Py_ssize_t> shape) {
    if (!get(object)) {
      release();
      converted_ = convert(object, name);
      if (!get(converted_)) throw nb::value_error((std::string(name) + ": not an array of numbers").c_str());
    }
    check_shape(name, shape);
    check_finite(name);
  }
  ~View() { release(); }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  const T* data() const { return static_cast<const T*>(view_.buf); }
  const T& operator[](std::size_t i) const { return data()[i]; }
  int rows() const { return static_cast<int>(view_.shape[0]); }
  std::size_t size() const { return static_cast<std::size_t>(view_.len) / sizeof(T); }

 private:
  static bool is_kind(char code) {
    if (std::is_same_v<T, double>) return code == 'd';
    if (std::is_same_v<T, std::uint64_t>) return code == 'L' || code == 'Q';
    return code == 'i' || (sizeof(long) == 4 && code == 'l');
  }

  static const char* type_name() {
    return std::is_same_v<T, double> ? "float64" : std::is_same_v<T, std::uint64_t> ? "uint64" : "int32";
  }

  bool get(nb::handle object) {
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
      PyErr_Clear();
      return false;
    }
    is_held_ = true;
    return view_.itemsize == sizeof(T) && view_.format && is_kind(view_.format[0]) && view_.format[1] == '\0';
  }

  void release() {
    if (is_held_) PyBuffer_Release(&view_);
    is_held_ = false;
  }

  //! Integers are never made from fractions: only an integer array, or an empty one, becomes integers.
  static nb::object convert(nb::handle object, const char* name) {
    try {
      const nb::module_ numpy = nb::module_::import_("numpy");
      const nb::object array = numpy.attr("asarray")(object);
      const std::string kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
      const bool is_allowed =
          kind == "i" || kind == "u" || kind == "b" || (kind == "f" && std::is_same_v<T, double>);
      if (is_allowed || nb::cast<Py_ssize_t>(array.attr("size")) == 0) {
        const nb::object converted = numpy.attr("ascontiguousarray")(array, type_name());
        // An integer that does not fit would come out as another one.
        if (std::is_same_v<T, double> || nb::cast<bool>(numpy.attr("array_equal")(converted, array)))
          return converted;
      }
    } catch (const nb::python_error&) {
    }
    throw nb::value_error((std::string(name) + ": not an array of " + type_name()).c_str());
  }

  void check_shape(const char* name, std::initializer_list<Py_ssize_t> shape) const {
    bool is_right = view_.ndim == static_cast<int>(shape.size());
    int axis = 0;
    for (Py_ssize_t extent : shape) {
      if (!is_right) break;
      is_right = extent == kAny || view_.shape[axis] == extent;
      ++axis;
    }
    // No rows at all may come in any other shape, e.g. as []; rows without entries never do.
    const bool may_have_none = shape.size() > 0 && *shape.begin() == kAny;
    const bool has_none = may_have_none && view_.ndim > 0 && view_.shape[0] == 0;
    if (is_right || has_none) return;
    std::string text = std::string(name) + ": shape (";
    for (int i = 0; i < view_.ndim; ++i) text += (i ? ", " : "") + std::to_string(view_.shape[i]);
    text += ") instead of (";
    axis = 0;
    for (Py_ssize_t extent : shape)
      text += (axis++ ? ", " : "") + (extent == kAny ? std::string("any") : std::to_string(extent));
    throw nb::value_error((text + ")").c_str());
  }

  void check_finite(const char* name) const {
    if constexpr (std::is_same_v<T, double>) {
      double sum = 0.0;  // stays 0 for finite numbers, NaN otherwise
      for (std::size_t i = 0, n = size(); i < n; ++i) sum += 0.0 * data()[i];
      if (sum != 0.0) throw nb::value_error((std::string(name) + ": not finite").c_str());
    }
  }

  Py_buffer view_{};
  bool is_held_ = false;
  nb::object converted_;
};

using Doubles = View<double>;
using Integers = View<std::int32_t>;

//! A numpy array that owns its values.
template <typename T>
nb::object to_numpy(std::vector<T> values, std::initializer_list<std::size_t> shape) {
  auto* owned = new std::vector<T>(std::move(values));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(owned->data(), shape.size(), shape.begin(), owner));
}

//! Name of an array, or of one of its rows: put together when an error has to tell it.
struct Name {
  Name(const char* array, Py_ssize_t row = kAny) : array(array), row(row) {}
  std::string text() const { return array + (row == kAny ? "" : "[" + std::to_string(row) + "]"); }
  const char* array;
  Py_ssize_t row;
};

//! A rigid pose from 16 numbers, made orthonormal to the last digit (the proofs rely on it).
inline Pose to_pose(const double* m, const Name& name) {
  const Vec3 x{m[0], m[4], m[8]}, y{m[1], m[5], m[9]}, z{m[2], m[6], m[10]};
  const double off = std::abs(norm(x) - 1.0) + std::abs(norm(y) - 1.0) + norm(cross(x, y) - z) +
                     std::abs(dot(x, y)) + std::abs(m[12]) + std::abs(m[13]) + std::abs(m[14]) +
                     std::abs(m[15] - 1.0);
  if (!(off < 1e-5)) throw nb::value_error((name.text() + ": not a rigid pose (4, 4)").c_str());
  const Vec3 ex = (1.0 / norm(x)) * x;
  Vec3 ey = y - dot(ex, y) * ex;
  ey = (1.0 / norm(ey)) * ey;
  return {from_columns(ex, ey, cross(ex, ey)), {m[3], m[7], m[11]}};
}

//! A vector (3,).
inline Vec3 vector_of(nb::handle in, const char* name) {
  const Doubles v(in, name, {3});
  return {v[0], v[1], v[2]};
}

//! A vector (3,) of unit length, to the last digit.
inline Vec3 unit_of(nb::handle in, const char* name) {
  const Vec3 v = vector_of(in, name);
  const double length = norm(v);
  if (!(std::abs(length - 1.0) < 1e-6)) throw nb::value_error((std::string(name) + ": not of unit length").c_str());
  return (1.0 / length) * v;
}

inline void write_pose(const Pose& T, double* m) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[4 * row + column] = T.R(row, column);
    m[4 * row + 3] = row == 0 ? T.p.x : row == 1 ? T.p.y : T.p.z;
  }
  m[12] = m[13] = m[14] = 0.0;
  m[15] = 1.0;
}

//! What a check of collisions may be asked for.
inline void check_margin(double margin) {
  if (!(margin >= 0.0 && std::isfinite(margin))) throw nb::value_error(("margin " + std::to_string(margin) + ": must be finite and at least 0").c_str());
}

inline void check_resolution(double resolution) {
  if (!(resolution >= 1e-6)) throw nb::value_error("resolution must be at least 1e-6 m");
}

//! Single-precision angles lose their meaning beyond this; no joint gets there.
inline void check_range(const Doubles& q, const char* name) {
  for (std::size_t i = 0; i < q.size(); ++i)
    if (std::abs(q[i]) > 1e6) throw nb::value_error((std::string(name) + ": beyond 1e6 rad or m").c_str());
}

}  // namespace apc
