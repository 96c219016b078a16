"""A whole order: what to try next, how it is carried out, and what it scores.

Read `order_file`, `loop`, `target_selection` and `attempt_runner`; `trial_interfaces` are the interfaces of a
trial, `simulated_cell` the simulated cell behind them; `score` and `trial_record` tell what came of it.
"""
