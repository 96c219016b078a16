"""What the files of a cell may say: fields, types and ranges.

Read `cell_schema` with `tool_schema`, `place_schema` and `pose_schema`; `items_file` and `joint_limits_file`
are files of their own; `items_text` writes the former.
"""
