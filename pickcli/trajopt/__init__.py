"""Trajectory optimisation: minimum-time, certified trajectories between two configurations.

Read `parabolic_segment` and `parabolic_trajectory` (the representation), `steering` (two-point boundary
value problems), `trajectory_validator`; then the moves of the search, `collision_descent`, `perturbations`
and `time_shortcutting`, and `minimum_time_search` over all of them. `jerk_filter`, `path_fitting` and
`certified_clearance` finish a result.
"""
