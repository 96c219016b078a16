"""Grasps of an item by a suction cup or two fingers, and the loads that they can hold.

Read `grasp_method`, the interface of picks to a kind of tool; `method_choice` selects the method of a tool.
Each samples grasps of a `grasp_target`, as widely as `search` states.

- `suction_grasping`, by `suction_candidates`: `surfaces` and `region` are the faces of an item, `face_poses`
  selects poses on them, `lip_coverage` is what the cup keeps across a narrow one, `cup_press` how far it is
  pressed on, `press_check` whether the item tips over, if no `backing` stops it; `contact_speeds` keeps its
  results.
- `region_import` makes seals and areas of an item from KTH's regions, which `box_tsr` reads.
- `envelope` is the set of poses from which an object is grasped: `finger_envelopes` are those of a shape,
  `cup_envelopes` those of an item, `envelope_truncation` is what a scene leaves of one.
- `recorded_grasp` keeps one for later, in a file read by `recorded_grasp_file`, of `recorded_grasp_schema`;
  `recorded_filters` leave out what runs after a moving item, or is not reached, and say which and why.
- `pinch_grasping`, by `pinch_candidates`, from the pairs of opposite places found by `antipodal`.

For all of them, `holding` compares the wrench of gravity and motion with what the tool bears.
"""
