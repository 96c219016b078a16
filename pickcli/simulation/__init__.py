"""The simulated world behind one door: pybullet, the cup, the servo, what goes wrong and what is watched.

Read `engine` and `engine_bodies` (the only files that know pybullet), `scene_bodies` and `world`, then
`execute` with `supervision`; `suction`, `bellows`, `vacuum` and `servo` are devices, `reality` their levels.
"""
