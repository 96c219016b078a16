"""The roadmap and the trajectory database: graph, search, connection of start and goal, storage.

Read `graph` and `astar`, then `query` with `connect`, `linked` and `through`; `database` for stored
motions; `store` and the `stored_` files for what is on disk.
"""
