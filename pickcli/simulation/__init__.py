"""The simulated world behind one door: pybullet, the tool, the servo, what goes wrong and what is watched.

Read in this order:

- The engine: `engine` and `engine_bodies`, the only files that know pybullet.
- The world of a scene: `world`, made of `scene_bodies` and `robot_urdf`; `reality` says how it differs from
  its model, `places` where an item lies in it, `contacts` what touched unplanned; `settle` lets items come to
  rest without a robot, `camera` and `colours` make pictures.
- How joints move: `servo`, and `braking`, the hardest stop.
- What holds items: `grip`; as `suction` with `bellows` and `vacuum`, or as `fingers` with `pads`; from both
  an item hangs by a `bushing`.
- Carrying out a plan: `execute`, after a `start_check`, sends the set points of `stream`; `trigger` measures
  how far from its trigger an event fired, `execution` is the record.
- What is watched meanwhile: `supervision` and `contact_guard`, which end in a `protective_stop`.
- Several arms in one world: `arm_turn`.
"""
