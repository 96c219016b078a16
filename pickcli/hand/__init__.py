"""A two-finger hand with belts, in simulation: how it grasps, holds and fails.

A `belt_hand`, read by `hand_file`, says what the hand is and which objects it is set up for. `hand_urdf`
writes it for the engine. `wrist_impedance`, `closing_motor` and `pad_friction` are its physics; a
`simulated_hand` brings them into the engine, a `grasp_world` puts objects before it. `grasp_execution`
controls a grasp stage by stage, a `grasp_trial` plays and judges one; `pre_grasps` are where grasps start
from, and `grasp_figures` sum them up.
"""
