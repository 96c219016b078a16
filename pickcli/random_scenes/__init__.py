"""Random scenes: layouts of items at rest in places.

Start with `make_scene`, then the layout of one place: `bin_layout` for bins, `heap` for places open above.
Bins are filled by `packing_search` over many `bin_packings` at once: `box_arrays` represent items as boxes,
`stable_poses` and `placement_sampling` draw poses, and `crowding_cost` and `extraction_access` rate a
packing. `leaning_items` are drawn from those that can lean, `leaning_placements` of them on walls and
neighbours. `make_stream` draws items that come along a conveyor.
"""
