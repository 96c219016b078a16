"""How much of a place is reached: by the arm at all, and from named configurations, which are ranked by it.

`cell_check` is what `apc check` asks of a cell, by `place_reachability`. Read `configuration_ranking` for the
configurations; `place_pose_sampling` draws what has to be reached, `ranked_configuration` is the
result.
"""
