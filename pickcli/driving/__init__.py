"""Driving: how a truck gets from a start to a goal, past everything.

The `tricycle` has figures and kinematics, a `steering_path` is a drive as few control actions. A
`driving_area`, read by `driving_area_file`, says where to drive. `motion_primitives` are the edges of a
`state_lattice`, on which a `lattice_search` finds the path of least cost; `drive_smoothing` makes it shorter
and smoother, a `free_space_proof` shows that the truck meets nothing, a `speed_profile` times it. All of this
makes a `drive_plan`, which a `drive_plan_file` keeps and `drive_svg` draws. `drive_tracking` keeps a truck on
it, a `drive_overseer` may brake it, and `simulated_drives` show how near the goal it comes with noise.
`drive_verification` is the second
opinion on a file.

A truck with `forks` and a `truck_camera` finds a pallet by a `pallet_look`: in an `area_view`, which is
simulated, or in a `truck_recording`; a `detected_pallet_file` keeps what it says. A `pallet_entry` is a drive
into it, whose path changes as the pallet is seen elsewhere; `simulated_entries` do so with noise.
"""
