"""Checks of a cell file: consistency, which is enforced, and plausibility, which gives warnings.

Start with `consistency`, which uses `references`, `robot_consistency`, `tool_consistency`,
`gripper_consistency` and `station_consistency`; `arm_consistency` handles several arms. The kinds of warnings
of `plausibility`, `place_plausibility`, `sensor_plausibility`, `inertial_plausibility` and
`configuration_check` are listed in `cell_warnings`.
"""
