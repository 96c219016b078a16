"""Tracks of what rides on a conveyor, from the pictures that a camera takes of it.

A `sighting` is what one picture shows. A `belt_filter` estimates one speed for the belt and a place for each
item, an `alignment` decides which item is which, a `mean_yaw` averages orientations without the outliers.
A `belt_tracker` makes tracks of all this, with bounds of their errors, for planning.
"""
