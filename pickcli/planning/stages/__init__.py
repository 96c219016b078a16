"""The stages of a pick, in the order in which ``planning.pick`` runs them.

- Grasp, in `grasp_selection`: `target_check` checks whether the item may be taken at all, `tool_clearance`
  plans for the tool without the arm, before any inverse kinematics; `grasp_motion` proves the lines of one
  grasp. Candidates are fixed ones of `grasping`, or found from the arm by `region_candidates`, or
  taken from a file by `recorded_candidates`.
- Extraction, in `extraction`: `planned_extraction` and `lift_sampling` if no simple corridor is free.
- Over a running belt: `reach_table` and `follow_bounds` say at once what is never met, with a linear axis
  along it and without one; `belt_raise` lengthens the lines to where the arm may wait whatever comes, and
  `line_pace` slows them down, so that the belt may change its speed. Where all joints follow the belt,
  `belt_grasps` are found once for all places along it, `belt_reach` is how far the arm reaches them, and
  `belt_meetings` orders when they are tried.
- Coarse motions: `grasp_transit` to the grasp, and `transfer` with the item to its placement, by ways of
  `item_transfer`, or of `upright_transfer` where the item is to stay upright.
- Release, in `placement`: at `drop_placements` from above, off a belt by `rim_drops`; else by `set_down`,
  with `picks_back` from `floor_placements`, from `stacked_placements` on other items, or from the
  `stated_placement` of a query.
- Shifts within a place: `shift_corridor` for the item as a free flyer, `shift_end` for the release.
"""
