"""Named configurations ranked by how much of a bin each reaches.

Read `configuration_ranking`; `bin_pose_sampling` draws what has to be reached, `ranked_configuration` is the
result.
"""
