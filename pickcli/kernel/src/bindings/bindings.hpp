#pragma once

#include <nanobind/nanobind.h>

namespace apc {

void bind_chain(nanobind::module_& m);
void bind_results(nanobind::module_& m);
void bind_checker(nanobind::module_& m);
void bind_planning(nanobind::module_& m);
void bind_timing(nanobind::module_& m);
void bind_blend(nanobind::module_& m);
void bind_parabolic(nanobind::module_& m);
void bind_control(nanobind::module_& m);
void bind_pose_blocks(nanobind::module_& m);
void bind_pose_constraints(nanobind::module_& m);
void bind_rendering(nanobind::module_& m);
void bind_perception(nanobind::module_& m);

}  // namespace apc
