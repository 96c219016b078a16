"""Pallets: where one stands on the floor, from one depth picture of its entry side.

A `pallet_shape` is its boards and blocks, and the front into which forks go. A `front_search` finds places
where columns and pockets of that width alternate, a `front_fit` moves the front until each of the
`front_pixels` shows what it should, on the front or through it, and `front_shares` say how much of it is
seen. All of this makes a `pallet_pose`.
"""
