"""Monte Carlo: many trials, of several orders and seeds, and what they tell together.

A `trial_job` plays one trial, whose result is a `packed_folder`; `trials_folder` stores them with their
`trial_statistics`, with a `success_rate` each for items and places; an `interrupted_run` is continued. What
is played otherwise has a `trials_kind`. A `trial_comparison` compares two such runs by `sign_flips`.
"""
