"""A whole order: what to try next, how it is carried out, and what it scores.

Read `order_file`, then `loop` with `target_selection`, `blocking_items`, `attempt_runner` and
`recovery_levels`; `trial_interfaces` are what a trial asks of a cell, `simulated_cell` answers; `score`,
`trial_record` and `trial_summary` tell what came of it.
"""
