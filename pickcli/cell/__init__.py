"""The cell as its owner wrote it: arms, tools, places, devices, items, limits and named configurations.

Read in this order:

- A cell as values: `cell`, as one arm sees it, and `workcell` with all arms; `robot`, made of `shapes`;
  `tool` with a `grip_model`: a `suction_cup`, which bears `cup_limits`, a `gripper`, which bears
  `pinch_limits`, or a `bare_flange`; `device`;
  `station` with each `place` and the `pod_tolerance`; `item`.
- From a folder to a cell: `cell_file` reads it by `cell_schema`, `tool_schema`, `place_schema` and
  `pose_schema`, with `items_file` and `joint_limits_file`; `data_path` says where the data folder is.
- From a robot's files to its tree: `urdf` with `urdf_link`, `urdf_joint`, `urdf_origin` and `mesh_names`;
  `srdf`; `robot_tree` puts several robots into one tree, `planning_group` takes out what an arm moves;
  `urdf_writer` writes one.
- From figures to solids, places and tools: `pod`, `tote`, `grid`, `carrier_builder`, `tool_builder`.
- What must agree: `consistency`, by `references`, `robot_consistency`, `tool_consistency`,
  `gripper_consistency` and `station_consistency`; `arm_consistency` where there are several arms.
- What is allowed and hardly meant: `plausibility` and `configuration_check`, told as `cell_warnings`.
- What tells cells apart and what is written into one: `fingerprint`, `cell_diff`, `configuration_text`.
"""
