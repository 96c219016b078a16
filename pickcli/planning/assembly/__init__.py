"""Assembly of the proven segments into one timed plan with its events.

Read `stitching`, then `carried_motion` for the part with the item, and `proven_timing`, which times the
segments between two stops within the limits of `grip_load`; `timed_motion_validation` proves the timed
motion, `pick_plan` makes the plan, `tool_path_check` measures the tool's path, and `tilt_bound` bounds how
far the held item is tilted.
"""
