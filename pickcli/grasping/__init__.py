"""How an item may be held, by a suction cup or between two fingers, and whether the hold lasts.

Read `suction_candidates`, which draws grasps of a `grasp_target`, as widely as `search` says. For a cup: `surfaces`
and `region` are the faces of an item, `face_poses` chosen places on them, `cup_press` how far the cup is
pressed on. For two fingers: `pinch_candidates`, from the opposite places that `antipodal` finds. For both:
`holding` is the wrench of gravity and motion against what they bear, `tool_suitability` whether a tool may
hold an item at all.
"""
