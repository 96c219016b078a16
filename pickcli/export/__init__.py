"""Verified plans as files of others: for robots, recorders and tables.

Read in this order:

- What a format is: `exporter`; `formats` finds those that come with the package and those that others add.
- What every format writes: `samples` of the motion in whole nanoseconds, and its `device_events`.
- One module per format: `joint_trajectory`, `csv_table`, `urscript` with its `channels`, `mcap_log`.
- What an MCAP shows: `ros_messages` by their definitions, `link_frames` and `robot_description` of the robot,
  `scene_markers` of everything else.
"""
