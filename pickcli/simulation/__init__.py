"""The simulated world behind one door: pybullet, the cup, the servo, what goes wrong and what is watched.

Read `engine` (the only file that knows pybullet), `world`, then `execute` with `supervision`; `suction`,
`bellows`, `vacuum` and `servo` are the devices, `reality` their levels.
"""
