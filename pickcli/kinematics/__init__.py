"""Forward and inverse kinematics of the tool, by the kernel's chains.

Read `chain`, then `arm`; `continuous_joints` handles positions that are equal up to whole turns, `follow`
states tolerances of a line, `tip_motion` and `held_body` compute how tool and load move along a
trajectory, `arm_dynamics` what the motors exert for that, `tool_change` how the tool moves while it changes
its state, `manipulability` how well a configuration can move, `linear_axis` finds the one that carries the
whole arm, and `wrist_reach` bounds where the point can be in which the axes of the last joints meet.
"""
