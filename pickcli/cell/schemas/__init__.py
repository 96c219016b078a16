"""Schemas of a cell's files: fields, types and ranges.

Start with `cell_schema`, which uses `tool_schema`, `place_schema` and `pose_schema`. `items_file` reads files
of items and `items_text` writes them; `joint_limits_file` reads ROS's joint_limits.yaml.
"""
