"""Tasks of a stack, one kind per module: what is wanted of the next instant, as rows on joint rates.

Read `task`, their common interface. `tool_task` bounds the pose of the tool, by the terms of an envelope or
any others; `obstacle_task` keeps the robot off what is near; `joint_limit_task` keeps limits of positions,
rates and accelerations; `posture_task` draws the joints to a configuration.
"""
