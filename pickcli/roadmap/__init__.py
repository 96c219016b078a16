"""The roadmap and the trajectory database: graph, search, connection of start and goal, storage.

Read in this order:

- The roadmap and the ways through it: `graph`, `astar`; two routes that share no edge: `edge_disjoint`.
- A query: `query`, with the `connection` of start and goal, the `query_graph` that has both, and
  `roadmap_search`. What it finds and no file held is `query_experience`; `merge_edges` adds it to a roadmap.
- Stored motions: `trajectory_database`.
- Files: `store`; `roadmap_tables` and `database_tables` with the `common_columns` of both, `validate` for
  what is read, `recovered_content` for what is left of a damaged file, `statistics` for what is in one.
"""
