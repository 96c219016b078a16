"""Online queries, from a scene to a proven, timed plan with its events.

Read `pick` with `pick_problem`, then its `stages` in their order, with the results that they pass on in
`pick_motion` and the motions between them (`coarse_path`) by `coarse_motion`, then `assembly`, which makes a
plan of the proven segments. Picks from a running conveyor in `belt_picks`, a `move`, `topple` with its
`toppling_poses` and `sliding_poses`, and `recovery` are the other queries; `arm_choice` selects one of
several arms, `region_query` finds configurations in the `item_envelopes` of a scene, `envelope_roll_outs`
lets a controller run into them, `destination_choice` selects one of several destinations, and `blockers`
finds the items without which a pick would have one. All need the `planning_context`, the `start_state` and
the parameters in `pick_settings`.
"""
