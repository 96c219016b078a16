"""Pictures of cells and of what is stored for them, as an image; pages show them in 3-D.

Read `draw`, then `picture` and `scenery`, of which all pictures are made: `cell_picture`, `place_picture` and
those of what is `stored`; `png` writes them.
"""
