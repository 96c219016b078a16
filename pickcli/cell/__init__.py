"""The cell: robots with their arms and tools, places, devices, items, limits and named configurations.

Read in this order:

- Data: `cell`, as seen by one arm, and `workcell` with all arms; `robot` with its `shapes` and the `inertial`
  of each link; `tool`, of a kind in `tools`; `device`; `station` with each `place`, its `conveyor` and the
  `pod_tolerance`; `item` with each `hollow` and the `hollow_body` left; cameras in `sensors`.
- Reading: `cell_file` reads a cell's folder by the `schemas`; `data_path` locates the data folder.
- Building: `robots` reads robot files into one link tree; `makers` turns figures into solids and places.
- Checking: `checks` refuses inconsistent values and warns of implausible ones.
- Comparing and writing: `fingerprint`, `cell_diff`, `configuration_text`.
"""
