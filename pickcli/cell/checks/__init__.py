"""What a cell must agree with, and what is allowed and hardly meant.

Read `consistency`, by `references`, `robot_consistency`, `tool_consistency`, `gripper_consistency` and
`station_consistency`; `arm_consistency` where there are several arms. `plausibility` and
`configuration_check` end in `cell_warnings`.
"""
