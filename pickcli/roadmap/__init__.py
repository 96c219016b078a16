"""The roadmap and the trajectory database: graph, search, connection of start and goal, storage.

Read in this order:

- The roadmap and routes through it: `graph`, `astar`; two routes that share no edge: `edge_disjoint`.
- A query: `query`, with the `connection` of start and goal, the `query_graph` with both, and
  `roadmap_search`. New paths that it finds are `query_experience`; `merge_edges` adds them to a roadmap.
- Stored motions: `trajectory_database`.
- Files: `store`; `roadmap_tables` and `database_tables` with the `common_columns` of both, `validate` for
  their content, `recovered_content` for the intact part of a damaged file, `statistics` for a summary.
"""
