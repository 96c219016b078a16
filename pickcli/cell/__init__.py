"""The cell as its owner wrote it: robot, pod, tote, devices, items, limits and named configurations.

Read `cell` and what it is made of (`robot`, `tool` with `suction_cup` and `gripper`, `station`, `device`,
`item`, `shapes`), then `cell_file`, which reads one with `cell_schema`, `urdf`, `pod`, `tote`, `tool_builder`
and `items_file` and judges it in `consistency` and in the modules that it calls, one for each part of a cell;
`fingerprint` and `cell_diff` tell cells apart.
"""
