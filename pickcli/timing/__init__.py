"""From paths to trajectories: blends, time-optimal parameterization, jerk limits, strict checks, stops.

Read `timed_run`, which times one run from stop to stop: `polyline_simplification`, `corner_blending` and
`blend_validation` make a smooth path that is proven free; `path_limits`, `path_constraint` and, for what is
carried, `wrench_limit` say what limits the speed along it; `time_parameterization` times it with
`toppra_closed_form` or `toppra_solver` and `jerk_smoothing`; `limit_check` judges the result.
`concatenation` joins runs, `stopping_trajectory` brakes, `trajectory_chords` serves proofs,
`trajectory_sampling` what is measured on a motion.
"""
