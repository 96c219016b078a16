"""Collision checking: whether a motion is free, which contacts are allowed on it, and what is in the way.

Read in this order:

- Interface and implementations: `motion_validator`, the protocol that all planning uses, and
  `kernel_validator`, its implementation by the kernel; `checker` for the robot in a scene, `free_flyer` for
  an item or the tool without the arm.
- Parameters of a check: `motion_segment` joins a path to the mode in which it is free; `allowed_contacts` and
  `stage_contacts` state the allowed contacts; `checker_cache` keeps the checkers of the modes.
- The two sides of a check: `robot_model`, in one tool state a `kernel_robot`, with the `attached_item`, and
  `collision_world`, where a `hollow_cover` is what the tool may not enter of an item that it takes by a
  hollow; `link_pairs` for two links alone, `hand_sphere` for where the hand may be at all.
- Spheres that cover moving bodies: `sphere_cover`, from `solid_covers` and `hull_cover`, both by `set_cover`;
  `swept_cover` for bodies that a joint of the tool moves.
"""
