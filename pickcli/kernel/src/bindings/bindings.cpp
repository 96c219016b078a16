// The Python module pickcli.kernel._kernel.
#include "bindings/bindings.hpp"

#include <nanobind/stl/string.h>

#include "simd/dispatch.hpp"

NB_MODULE(_kernel, m) {
  m.doc() = "Forward kinematics, inverse kinematics, clearance and proven edges of a serial chain; fastest paces.";
  apc::bind_chain(m);
  apc::bind_checker(m);
  apc::bind_planning(m);
  apc::bind_timing(m);
  m.def("simd", &apc::simd_name);
  m.def("set_simd", [](const std::string& name) { apc::set_simd(name.c_str()); }, nanobind::arg("name"));
}
