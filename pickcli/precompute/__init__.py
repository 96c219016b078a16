"""The pipelines that make a cell's files: roadmap and trajectory database, once per cell, offline.

Read `make`, then `build_roadmap` and `build_trajectories` with their recipes; `refresh` and `repair` make a
stored file right again, `learn` adds what queries found.
"""
