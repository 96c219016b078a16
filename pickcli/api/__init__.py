"""Interface for scripts: one object over the library, with its configurations and goals.

`planner` has the object, `configurations` parses configurations, `arm_states` those of other arms,
`obstacle_check` looks at added obstacles, a `camera_look` at items; a `query_sequence` answers several
queries in one simulated world.
Scripts import from the package itself (docs/reference/python.md), which exports these besides the stable
names of the other packages.
"""
