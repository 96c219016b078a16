"""Export of verified plans to other formats, for robots, recorders and tables.

Read in this order:

- Formats: `exporter` defines them; `formats` finds those of this package and those of installed packages.
- Common content: `samples` of the motion in integer nanoseconds, and its `device_events`.
- One module per format: `joint_trajectory`, `csv_table`, `urscript` with its `channels`, `mcap_log`.
- Content of an MCAP log: `ros_messages` with their definitions, `link_frames` and `robot_description` of the
  robot, `scene_markers` of everything else.
"""
