"""Prioritized control: the motion of the next instant from tasks in levels of strict priority.

Read `roll_out`, the controller alone from period to period, then the `tasks` of its stack, which a
`stack_file` states, then `hierarchical_qp`, which solves their rows.
"""
