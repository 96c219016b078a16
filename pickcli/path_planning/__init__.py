"""Geometric path planning; the only package that uses OMPL.

Read `state_space`, then `sampling_planner`, the common interface, with `planner_names` and `planner_options`;
it uses the kernel's RRT-Connect and `ompl_planners`; `shortcutting` and `path_cost` process the paths.
`lattice_planner` plans by a graph search instead: `ara_star` on a `workspace_lattice`, whose steps are in
`lattice_cost` and whose heuristic is in `hand_distance`.
"""
