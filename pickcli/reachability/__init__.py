"""Reachability of places: by the arm, from a configuration, from a base pose.

Read `cell_check`, the checks of `apc check` for a cell, by `place_reachability` and, for links that nothing
tests against each other, `untested_pairs`; then `configuration_ranking` for configurations, with
`place_pose_sampling`, which samples the poses to reach, and `ranked_configuration`, the result; then
`mount_ranking` for base poses, with `tool_pose_sampling`, by `tool_reachability`, and with `base_solids`,
which may not collide with anything; and `belt_reachability` for conveyors.
"""
