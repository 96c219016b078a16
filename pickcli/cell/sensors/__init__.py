"""Cameras of a cell.

A `pinhole_camera` has the intrinsics of one eye.
"""
