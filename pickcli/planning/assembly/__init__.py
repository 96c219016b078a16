"""From the segments that the stages proved to one timed plan with its events.

Read `stitching`, then `certified_timing`, which times the segments between two stops as `grip_load`
allows; `timed_motion_validation` proves what is timed, `tool_path_check` measures the way of the tool, and
`events` says when the devices switch.
"""
