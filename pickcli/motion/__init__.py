"""Data types of motion: paths, trajectories, segments, events, plans. No algorithms.

Read `path`, `trajectory`, `segment` and `event`, then `plan`; `plan_file` and `plan_schema` store it.
`limit_shares` computes how much of its limits a trajectory uses.
"""
