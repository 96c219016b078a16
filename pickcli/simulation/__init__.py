"""Physics simulation of the cell, and execution of plans in it or by any other driver.

Read in this order:

- Engine: `engine`, `engine_bodies` and `engine_client`, the only modules that use pybullet.
- World of a scene: `world`, built by `scene_bodies` and `robot_urdf`; `reality` states its
  deviations from the model, `places` finds the place of an item, `contacts` logs contacts that are not among
  the `planned_contacts`; `settle` lets items come to rest without a robot; `camera`, with a `camera_view`,
  makes pictures.
- Pairs without collision physics: `collision_filter`.
- Joint motion: `servo`, and `braking`, the hardest stop.
- Tool: `simulated_tool`, created by `tool_choice` as a `simulated_cup` or a `simulated_gripper`. Its `grip`
  holds items: `suction` with `bellows`, `vacuum` and `cup_friction`, or `fingers` with `pads`; in both,
  items hang by a `bushing`.
- Execution of a plan by a `driver`: `drive`, by a `plan_run` that, after a `start_check`, sends the set
  points of `stream`; `trigger` measures how far from its trigger an event fired, `following` compares joints
  with set points, `plan_record` is the record. In simulation: `execute`, with the record `execution`; a
  `motion_recorder` records all motion. An `operator_stop` interrupts a motion, which goes on afterwards.
- Running conveyors: a `running_belt` with its encoder, by which the `belt_clock` tells the plan's time, with
  `online_time_scaling` within the limits of the joints; a `belt_way_off`, or a `planned_way_off`, leaves it
  if the motion is stopped. A `belt_run` is a run of a plan that follows one, supervised on the way off, too.
- Other drivers: `recorder`, and `installed_drivers` by name; `driver_check` tests a driver against the
  protocol, and a `guarded_driver` turns its faults into a single error message.
- Supervision: `supervision` with a `hold_watch`, `contact_guard` and `weight_watch`; beyond their
  `thresholds` they request a `protective_stop`.
- `guarded_move`: slowly along a line until the tool feels something, and back.
- Several arms in one world: `arm_turn`.
"""
