"""Pictures of what is stored: a roadmap or a database over its cell, as an image or a page to turn about.

Read `draw`; `stored` and `scenery` make a `picture`, which `png` and `html` write.
"""
