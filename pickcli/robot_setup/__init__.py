"""Creates a cell for a new robot from its URDF and SRDF, like MoveIt's Setup Assistant without questions.

Start with `cell_setup`, which creates a cell from `setup_options`, step by step. `robot_reading` reads the
`robot_files` (with `package_search` and `xacro_file`). `stated_text` collects what follows from them
directly: `chain_selection`, `suggested_tool` (by `tool_suggestion`, with `suggested_gripper`, `finger_shapes`
and `finger_pads`), `stated_limits`. Then come searches: `collision_sampling`, `suggested_places` with
`place_search`, `suggested_configurations` with `coarse_motions`; `cell_text` writes the result.
`sphere_excess` measures how far the links' spheres extend beyond their shapes.
"""
