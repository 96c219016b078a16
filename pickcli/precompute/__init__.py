"""The pipelines that make a cell's files: roadmap and trajectory database, once per cell, offline.

Read in this order:

- Building and writing: `artifact_files`; `artifact_cache` keeps what is built in the user's cache, and
  `provenance` says what it depends on.
- The roadmap: `roadmap_builder` with `roadmap_settings`, its tasks in `roadmap_edge_job`; `critical_pairs`
  get a second route by `route_redundancy`.
- The trajectory database: `database_builder` with the `motion_pairs` worth storing, its tasks in
  `coarse_motion_job`, one motion each by `coarse_motion_planner`.
- What both are proven in: `empty_cell_checkers`.
- Stored files made right again: `refreshing` by `revalidation` after a change of the cell, `repair` after
  damage, both from `recovered_results`; `experience` adds what queries found.
"""
