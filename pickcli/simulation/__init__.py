"""The simulated world behind one door: pybullet, the cup, the servo, what goes wrong and what is watched.

Read `engine` and `engine_bodies` (the only files that know pybullet), `scene_bodies` and `world`, then
`execute` with `supervision`; `grip` says what `suction` (with `bellows` and `vacuum`) has in common with
`fingers` (with `pads`), `servo` moves joints and tool, `reality` has the levels.
"""
