"""Reading and writing of robot files: URDF and SRDF to one tree of links and joints.

Start with `urdf`, which uses `urdf_link`, `urdf_joint`, `urdf_origin` and `mesh_names`, then `srdf`.
`robot_tree` joins several robots into one tree, `planning_group` selects the joints that an arm moves,
`travelling` puts a robot on one more joint, `urdf_writer` writes.
"""
