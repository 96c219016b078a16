"""A cell for a robot that nobody prepared, from its URDF and SRDF: what MoveIt's Setup Assistant asks, found.

Read `cell_setup`, which makes a cell from `setup_options` and goes through it in order. `robot_reading`
reads the `robot_files` (with `package_search` and `xacro_file`). `stated_text` is what follows from them:
`chain_selection`, `suggested_tool` (by `tool_suggestion`, with `suggested_gripper`, `finger_shapes` and
`finger_pads`), `stated_limits`. What is searched for comes then: `collision_sampling`, `suggested_places` and
`place_search`, `suggested_configurations`; `cell_text` is the text. `sphere_excess` says how far the spheres
of the links stick out of their shapes.
"""
