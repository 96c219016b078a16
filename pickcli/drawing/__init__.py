"""Pictures of cells and of what is stored for them, as an image or a page to turn about.

Read `draw`, then `picture` and `scenery`, of which all pictures are made: `cell_picture`, `place_picture` and
those of what is `stored`; `png` and `html` write them.
"""
