"""Random scenes that a pod could have: layouts of items in bins, at rest.

Read `make_scene`, then `bin_layout`, `packing_search` and `bin_packings`; the rest are the costs and poses
of a packing.
"""
