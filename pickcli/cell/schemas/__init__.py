"""Schemas of a cell's files: fields, types and ranges.

Start with `cell_schema`, which uses `tool_schema`, `place_schema` and `pose_schema`. `items_file` reads files
of items, with the `hollow_schema`, and `items_text` writes them; `sensor_file` reads those of sensors,
`joint_limits_file` ROS's joint_limits.yaml.
"""
