"""Offline pipelines that build a cell's files once per cell: roadmap and trajectory database.

Read in this order:

- Building and writing: `artifact_files`; `artifact_cache` keeps the files in the user's cache, `provenance`
  digests their inputs.
- The roadmap: `roadmap_builder` with `roadmap_settings`, its tasks in `roadmap_edge_job`; `critical_pairs`
  get a second route by `route_redundancy`.
- The trajectory database: `database_builder` with the `motion_pairs` worth storing, its tasks in
  `coarse_motion_job`, one motion each by `coarse_motion_planner`.
- The checkers of both: `empty_cell_checkers`.
- Updates of stored files: `refreshing` by `revalidation` after a change of the cell, `repair` after damage,
  both from `recovered_results`; `experience` adds paths that queries found.
"""
