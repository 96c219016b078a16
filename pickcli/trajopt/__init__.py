"""Trajectory optimisation: minimum-time, proven trajectories between two configurations.

Parabolic segments, trajectories of them and steering between two states are in the kernel. Read
`parabolic_segment`, `trajectory_validator`; then the moves of the search, `collision_descent`,
`perturbations` and `time_shortcutting`, and `minimum_time_search` over all of them, with
`trajectory_settings` and the `time_lower_bound` of what it can find. `jerk_filter`, `path_fitting` and
`proven_clearance` finish a result.
"""
