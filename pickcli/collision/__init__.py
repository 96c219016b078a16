"""Whether a motion is free, who may touch whom on it, and what is in the way.

Read `motion_validator`, the question, and `kernel_validator`, how the kernel answers it; then `checker` for
the robot in a scene and `free_flyer` for an item or the tool alone. `motion_segment` joins a path to the
mode in which it is free, `allowed_contacts` and `stage_contacts` say who may touch whom, `checker_cache`
keeps what was made. `robot_model` and `collision_world` are the two sides of a check; `attached_item` is
held. Covers by spheres: `sphere_cover`, `solid_covers`, `swept_cover`, `set_cover`.
"""
