"""For those who script: one object over the library, and what scripts name as configurations and goals.

`planner` has the object, `configurations` what stands for a configuration, `arm_states` where other arms
stand; a `query_sequence` answers several queries in one simulated world. Scripts import from the package
itself (docs/reference/python.md), which hands these on beside the stable names of the other packages.
"""
