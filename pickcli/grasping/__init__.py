"""How an item may be held, by a suction cup or between two fingers, and whether the hold lasts.

Read `grasp_method`, what picks ask of a kind of tool; `method_choice` says which one a tool has. Each draws
grasps of a `grasp_target`, as widely as `search` says.

- `suction_grasping`, by `suction_candidates`: `surfaces` and `region` are the faces of an item, `face_poses`
  chosen places on them, `cup_press` how far the cup is pressed on, `press_check` whether the item tips over.
- `region_import` makes seals and areas of an item from KTH's regions, which `box_tsr` reads.
- `pinch_grasping`, by `pinch_candidates`, from the opposite places that `antipodal` finds.

For all, `holding` is the wrench of gravity and motion against what the tool bears.
"""
