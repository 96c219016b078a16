"""Recovery after a stop: a safe way back to a known configuration. See docs/recovery.md.

Read `recovery_plan`, which finds a way out on a given level: by what `recovery_rules` allow there, back along
the motion that stopped (`retrace`), or by a `jog` of some millimetres.
"""
