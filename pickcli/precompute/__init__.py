"""The pipelines that make a cell's files: roadmap and trajectory database, once per cell, offline.

Read `artifact_files`, then `roadmap_builder` and `database_builder` with their jobs, `roadmap_edge_job` and
`coarse_motion_job`; `refreshing` and `repair` make a stored file right again, `experience` adds what queries
found, `artifact_cache` keeps what is built in the user's cache.
"""
