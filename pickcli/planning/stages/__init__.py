"""The stages of a pick, in the order in which ``planning.pick`` runs them.

- Grasp, in `grasp_selection`: `target_check` checks whether the item may be taken at all, `tool_clearance`
  plans for the tool without the arm, before any inverse kinematics; `grasp_motion` proves the lines of one
  grasp. Candidates are fixed ones of `grasping`, or found from the arm by `region_candidates`, or
  taken from a file by `recorded_candidates`.
- Extraction, in `extraction`: `planned_extraction` and `lift_sampling` if no simple corridor is free.
- Coarse motions: `grasp_transit` to the grasp, if asked as a `reactive_transit`, and `transfer` with the
  item to its placement, by ways of `item_transfer`, or of `upright_transfer` where the item is to stay
  upright.
- Release, in `placement`: at `drop_placements` from above, off a belt by `rim_drops`; else by `set_down`,
  with `picks_back` from `floor_placements`, from `stacked_placements` on other items, or from the
  `stated_placement` of a query.
- Shifts within a place: `shift_corridor` for the item as a free flyer, `shift_end` for the release.
"""
