"""Recovery after a stop: a safe way back to a known configuration. See docs/recovery.md.

Read `recovery_plan`, which finds a recovery motion for a given level: as `recovery_rules` allow, back along
the motion that stopped (`retrace`), or by a `jog` of some millimetres.
"""
