"""How much of a place is reached, and from where: by the arm, from a configuration, from a base pose.

Read `cell_check`, what `apc check` asks of a cell, by `place_reachability`; then `configuration_ranking` for
configurations, with `place_pose_sampling`, which draws what has to be reached, and `ranked_configuration`,
the result; then `mount_ranking` for base poses, with `tool_pose_sampling`, by `tool_reachability`, and with
`base_solids`, which may not stand in anything.
"""
