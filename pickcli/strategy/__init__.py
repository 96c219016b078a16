"""Strategies of trials: behaviour trees that decide what to try next, read from files.

Read in this order: `node_types` (the vocabulary), `strategy_tree` (a strategy, as data), `strategy_file`
(reading one, or the packaged ones), `name_check` (names that a cell does not have), `trial_actions` (what a
tree sees of a trial, and can do in it), `target_choice` (which target is next), `tree_player` (ticks of a
tree, with py_trees), `strategy_player` (a trial of an order by a tree) and the exports `strategy_text`,
`strategy_svg` and `strategy_xml`.
"""
