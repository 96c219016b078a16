"""The simulated world behind one door, and how plans are carried out: in it, or by any other driver.

Read in this order:

- The engine: `engine` and `engine_bodies`, the only files that call pybullet; `engine_client` imports it.
- The world of a scene: `world`, made of `scene_bodies` and `robot_urdf`; `reality` says how it differs from
  its model, `places` where an item lies in it, `contacts` what touched that is not among the
  `planned_contacts`; `settle` lets items come to rest without a robot; `camera`, from a `camera_view`, and
  `colours` make pictures.
- Which pairs the physics leaves out: `collision_filter`.
- How joints move: `servo`, and `braking`, the hardest stop.
- The tool: `simulated_tool`, by `tool_choice` a `simulated_cup` or a `simulated_gripper`. What holds items is
  its `grip`: `suction` with `bellows` and `vacuum`, or `fingers` with `pads`; from both an item hangs by a
  `bushing`.
- Carrying out a plan by a `driver`: `plan_run`, after a `start_check`, sends the set points of `stream`;
  `trigger` measures how far from its trigger an event fired, `following` whether the joints follow,
  `plan_record` is the record. In the simulated world: `execute`, with `execution` as the record;
  a `motion_recorder` notes all that moves.
- Other drivers: `recorder`, and `installed_drivers` by their names; `driver_check` tells whether one keeps to
  the protocol, and what a `guarded_driver` does amiss ends a run by one message.
- What is watched meanwhile: `supervision` with a `hold_watch`, and `contact_guard`; beyond their `thresholds`
  they end in a `protective_stop`.
- Several arms in one world: `arm_turn`.
"""
