"""Straight lines of the tool inside a bin and over the tote, followed by inverse kinematics."""
