"""From the files of robots to one tree of links and joints.

Read `urdf` with `urdf_link`, `urdf_joint`, `urdf_origin` and `mesh_names`, then `srdf`. `robot_tree` puts
several robots into one tree, `planning_group` takes out what an arm moves; `urdf_writer` writes one.
"""
