"""Straight lines of the tool inside a bin and over the tote, followed by inverse kinematics.

Read `line`, then `line_following`; `corridor` has the straight ways on which an item comes out of a place,
and `key_waypoints` the poses of the tool up to contact.
"""
