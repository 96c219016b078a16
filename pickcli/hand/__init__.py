"""A two-finger hand with belts, in simulation: how it grasps, holds and fails.

A `belt_hand`, read by `hand_file`, says what the hand is and which objects it is set up for. `hand_urdf`
writes it for the engine. `closing_motor` and `pad_friction` are its physics; a `simulated_hand` brings them
into the engine. By itself it is on a `free_wrist` with `wrist_impedance`, and a `grasp_world` puts objects
before it. A `staged_execution` is how it acts: `grasp_execution` controls a grasp stage by stage, a
`guarded_grasp` with an approach that stops at what a `force_observer` feels; a `grasp_trial` plays and judges
one; `pre_grasps` are where grasps start from, and `grasp_figures` sum them up.

On the flange of an arm it is a `mounted_hand` to planner and verifier, and a `hand_arm` with `arm_impedance`
in an `arm_world`. `arm_motions` are certified plans into a `pre_grasp_envelope`, before a `cluster`, over a
place and home; a `place_execution` sets down. `arm_handling` is all of it for an object.
"""
