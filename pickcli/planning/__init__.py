"""Online queries, from a scene to a proven, timed plan with its events.

Read `pick` with `pick_problem`, then its `stages` in their order, with what they hand to each other in
`pick_motion`, then `stitching`; `move` and `recovery_plan` are the other queries. `planning_context` is what
all need, `certified_timing` times what is proven, `timed_motion_validation` proves what is timed,
`tool_path_check` measures the tool's way of the result.
"""
