"""Independent verification of plans, which shares only data and a few laws with the planner.

Shared are `files`, `cell`, the data of `scene`, and `motion`; docs/verification.md names the laws.

Read in this order:

- Entry point and result: `verify`, which runs all checks, and its `verdict`.
- Poses of all solids: `state_sampling`, `forward_kinematics` with `finger_kinematics`, `held_pose`,
  `moving_parts` with `hollow_walls`, `static_solids` and `cloud_points`.
- Distances: `fcl_solids` and `separation` for two solids, `pair_distance` over a motion,
  `link_shapes` for two links at single configurations; `solid_arrays` and `broad_phase` for thousands of
  pairs at once; `ray_casting` along a line.
- The motion: `structure_check` with `query_check`, `clearance_check` with `exemptions`, `joint_limit_check`
  by the bounds in `quintic`, `effort_check` by `inverse_dynamics`, `straightness_check`, `tool_speed`, and
  `event_check` with `finger_events` or `vacuum_events`; `tool_change_check` and `upright_check` while an item
  is held.
- The item: `contact_check` with `contact_exemptions`, `support_check` by `pile_statics`, `contact_pile` with
  `body_boxes` and `equilibrium`, `push_check`, `topple_check`, `tipping_check`; `grasp_check` with
  `load_check`, or `pinch_check` with `strayed_pinch_check`, as `hold_choice` selects; `release_check` by
  `landing_statics`.
- Plans for a running conveyor, in the frames of hall and belt: `belt_frame`, `belt_view`.
- Recovery motions after a stop: `recovery_check`.
"""
