//! \file
//! The Python module pickcli.kernel._kernel.
#include "bindings/bindings.hpp"

#include <nanobind/stl/string.h>

#include "simd/dispatch.hpp"

NB_MODULE(_kernel, m) {
  m.doc() = R"(Kinematics, clearance and proven edges of a serial chain; paces along paths; prioritized control; rays of cameras.

Any array-like goes in; C-contiguous arrays of the named dtype are read in place. Angles in rad, lengths in m.
Wrong shapes and values raise ValueError naming the argument.)";
  apc::bind_chain(m);
  apc::bind_results(m);
  apc::bind_checker(m);
  apc::bind_planning(m);
  apc::bind_timing(m);
  apc::bind_blend(m);
  apc::bind_parabolic(m);
  apc::bind_control(m);
  apc::bind_pose_blocks(m);
  apc::bind_pose_constraints(m);
  apc::bind_rendering(m);
  apc::bind_perception(m);
  m.def("simd", &apc::simd_name,
        R"(Which build of the batch test and of the rays runs: "avx2" or "baseline". Both give the same bits.)");
  m.def(
      "set_simd", [](const std::string& name) { apc::set_simd(name.c_str()); }, nanobind::arg("name"),
      R"(Choose the build of the batch test and of the rays, "avx2" or "baseline".

Raises:
    ValueError: This processor does not have it.)");
}
