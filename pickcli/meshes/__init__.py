"""Meshes of links as convex pieces, found once and kept in the user's cache; knows no robot.

Read `mesh_pieces`, which asks the cache, then `mesh_file` (a file as triangles) and `convex_pieces`
(triangles as few convex polyhedra that contain them).
"""
