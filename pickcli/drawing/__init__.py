"""Pictures of cells and of stored files as images; pages show them in 3-D.

Start with `draw`, then `picture` and `scenery`, which all pictures use: `cell_picture`, `place_picture` and
those of `stored` files; `png` writes them.
"""
