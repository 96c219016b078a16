"""From figures to solids and places: the makers of shelves and boxes, told apart by nobody behind them.

Read `carrier_builder`, which asks `pod`, `tote` and `grid`.
"""
