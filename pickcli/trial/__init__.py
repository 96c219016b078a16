"""A whole order: what to try next, how it is carried out, and what it scores.

Read in this order:

- What is asked: `order`, read by `order_file`; `make_order` draws a fresh order. `stow_assignment` says
  which bin each item of a stow is meant for.
- The trial: `loop` takes the target that `target_selection` finds most promising; `attempt_runner` plans,
  with a `certifier` that has the verifier judge every candidate, `attempt_execution` carries out and says
  what became of it. What is in the way is moved aside: the
  search is a `clearing`, by what the plans of `blocking_items` blame.
- When things go wrong: `recovery_levels` after a stop; `arm_turns` when another arm is in the way.
- What a trial plays in: `trial_interfaces`, and behind them the `simulated_cell`; `pod_shift` says
  where the pod really stands, `pose_noise` how exactly poses are told.
- What came of it: `disturbance` and `damage`, judged in the `final_state` by the rules of `score`, make a
  `trial_result`; `trial_folder` keeps it with its `trial_record`, the `motion_record` and the official
  `output_file`, and `trial_summary` has the rows of its table. `record_schema` and `motion_schema` say what
  record and motion have to hold when they are read again.
- One or many: a `played_trial` is all that a folder keeps, a `trial_job` plays one for each order and seed;
  `trials_folder` keeps them with their `trial_statistics`, a `success_rate` each for items and places. A
  `trial_comparison` tells two such runs apart, by `sign_flips`.
"""
