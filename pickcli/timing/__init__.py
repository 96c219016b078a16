"""Paths to trajectories: blends, TOPP-RA, jerk, strict limits, stop and resume."""
