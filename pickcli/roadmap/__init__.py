"""The roadmap and the trajectory database: graph, search, connection of start and goal, storage.

Read `graph` and `astar`, then `query` with `connection`, `query_graph` and `roadmap_search`;
`trajectory_database` for stored motions; `store`, `roadmap_tables` and `database_tables` for what is on disk.
"""
