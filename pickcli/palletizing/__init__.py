"""Palletizing: cartons of an order stacked on a pallet, so that every one stands by itself at any time.

A `pallet_order`, read by `pallet_order_file` or drawn by `random_pallet_order`, lists the cartons and the
pallet. `stacking` chooses their places one after the other among `landing_places`, with the whole order known
or as they come; a `support_polygon` says whether a carton stands, and where it bears others. The result
is a `pallet_stack`, kept by a `pallet_stack_file`. Two more opinions whether it stands: `stack_verification`
judges the file with algorithms of its own, and a `drop_test` puts it up in the physics engine, on the
`pallet_bodies`. For an arm that stacks them, `arm_sequence` is its sequence, and a
`carton_item` a carton that a cup holds.
"""
