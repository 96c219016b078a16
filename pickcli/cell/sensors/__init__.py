"""Cameras of a cell.

A `pinhole_camera` has the intrinsics of one eye. A `sensor_model` is that of a product, with its noise
and how it sees each `material`, and a `mounted_camera` is one of them at its place in a cell.
"""
