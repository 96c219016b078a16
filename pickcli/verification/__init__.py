"""The second opinion: checks a plan; shares only `files`, `cell`, `scene` and `motion` with the planner.

Read `verify`, which runs all checks and answers with a `verdict`. `state_sampling`, `forward_kinematics`,
`moving_parts` and `static_solids` say what is where; `fcl_solids` and `separation` measure distances; each
check has a file of its own.
"""
