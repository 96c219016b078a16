"""Geometric path planning in joint space; the only package that uses OMPL.

Read `state_space`, then `sampling_planner`, the common interface, with `planner_names` and `planner_options`;
it uses the kernel's RRT-Connect and `ompl_planners`; `shortcutting` and `path_cost` process the paths.
"""
