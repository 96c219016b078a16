"""Convex pieces of meshes, computed once and cached; independent of robots.

Start with `mesh_pieces`, which uses the cache, then `mesh_file` (files to triangles) and `convex_pieces`
(triangles to a few convex polyhedra that contain them).
"""
