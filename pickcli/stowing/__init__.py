"""Random scenes that a pod could have: layouts of items in places, at rest.

Read `make_scene`, then how one place is filled: `bin_layout` in a bin, `heap` where it is open above. A bin
is filled by `packing_search` over many `bin_packings` at once: `box_arrays` have their items as boxes,
`stable_poses` and `placement_sampling` say how and where one may lie, `crowding_cost` and
`extraction_access` judge a packing.
"""
