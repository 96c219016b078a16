"""From paths to trajectories: blends, time-optimal parameterization, jerk limits, strict checks, stops.

Read `timed_run`, which times one run from stop to stop: `polyline_simplification`, `corner_blending`,
`path_parts` of its segments and `blend_validation` make a smooth path that is proven free; `path_limits`,
`path_constraint`, `effort_limit` of the motors and, for a held item, `wrench_limit` are the limits along
it; `time_parameterization` times it with `toppra_closed_form` or `toppra_solver` and `jerk_smoothing`;
`limit_check` checks the result. `concatenation` joins runs, and `plan_parts` their segments;
`line_tracking` adds the motion of a conveyor to that of an axis, `arm_tracking` to that of a whole arm,
`stopping_trajectory` brakes, `trajectory_chords` is used in proofs, `trajectory_sampling` in measurements.
"""
