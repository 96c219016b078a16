"""The cell as its owner wrote it: arms, tools, places, devices, items, limits and named configurations.

Read in this order:

- A cell as values: `cell`, as one arm sees it, and `workcell` with all arms; `robot`, made of `shapes`;
  `tool`, of a kind in `tools`; `device`; `station` with each `place` and the `pod_tolerance`; `item`.
- From a folder to a cell: `cell_file` reads it by the `schemas`; `data_path` says where the data folder is.
- From a robot's files to its tree: `robots`. From figures to solids and places: `makers`.
- What must agree, and what is allowed and hardly meant: `checks`.
- What tells cells apart and what is written into one: `fingerprint`, `cell_diff`, `configuration_text`.
"""
