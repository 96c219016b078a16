"""A whole order: what to try next, how it is carried out, and what it scores.

Read `order`, `loop`, `strategy` and `player`; `ports` are the interfaces of a trial, `arena` the simulated
cell behind them; `score` and `record` tell what came of it.
"""
