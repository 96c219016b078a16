"""The words of motion: paths, trajectories, segments, events, plans. No algorithms."""
