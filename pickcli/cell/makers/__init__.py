"""Makers of shelves, boxes and tables: solids and places from the figures in a cell file.

Start with `carrier_builder`, which uses `grid`; `pod` and `tote` build the two standard carriers.
"""
