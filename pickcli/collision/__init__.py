"""Whether a motion is free, who may touch whom on it, and what is in the way.

Read in this order:

- The question and its answer: `motion_validator`, which everything that plans asks, and `kernel_validator`,
  how the kernel answers; `checker` for the robot in a scene, `free_flyer` for an item or the tool alone.
- What a check is about: `motion_segment` joins a path to the mode in which it is free; `allowed_contacts`
  and `stage_contacts` say who may touch whom; `checker_cache` keeps the checkers of the modes.
- The two sides of a check: `robot_model`, in one tool state a `kernel_robot`, with the `attached_item`, and
  `collision_world`.
- Spheres that cover what moves: `sphere_cover`, from `solid_covers` and `hull_cover`, both by `set_cover`;
  `swept_cover` for what a joint of the tool moves.
"""
