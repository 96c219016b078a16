"""Straight lines of the tool inside a bin and over the tote, followed by inverse kinematics.

Read `line`, then `line_following`; `corridor` has the straight ways out of a place for an item, and
`key_waypoints` the poses of the tool up to contact.
"""
