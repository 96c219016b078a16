"""Where the tool is and how to get it there: chains of the kernel, and inverse kinematics.

Read `chain`, then `arm`; `continuous_joints` says which positions are one configuration, `follow` how far a
line may be missed, `tip_motion` and `held_body` how tool and load move along a trajectory, `manipulability`
how well a configuration can move.
"""
