"""Online queries, from a scene to a proven, timed plan with its events.

Read `pick` with `pick_problem`, then its `stages` in their order, with what they hand to each other in
`pick_motion`, then `assembly`, where what the stages prove becomes a plan. `move` and `recovery` are the
other queries; `arm_choice` says which of several arms to ask. All need the `planning_context`, the
`start_state` and the figures in `pick_settings`.
"""
