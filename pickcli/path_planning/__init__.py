"""Geometric planning in joint space, and the only place that knows OMPL.

Read `state_space`, then `sampling_planner`, the one interface, with `planner_names` and `planner_options`;
behind it stand the kernel's RRT-Connect and `ompl_planners`; `shortcutting` and `path_cost` work on what
they find.
"""
