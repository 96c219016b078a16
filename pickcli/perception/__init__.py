"""Cameras in the cell: what they see of a scene.

A `rendered_scene` holds the solids of a scene as cameras see them. A `surface_view` is what one camera sees
of them, without noise, from its `camera_pose`; a `depth_picture` is what its sensor measures, with noise.
A `recorded_picture` is what a real one took, by its `recorded_picture_schema`. Colour pictures follow from
the `looks` of the solids, which for items include a `procedural_texture`; a `photograph` shows damaged labels
in other light, as trials do. Cloth and bags may have a
`deformed_look`, inside of their boxes.
`viewpoints` are from where cameras look into a place, and the `next_view` is from where most is in sight of
what is not known in it.
`items` finds the listed items of a place in one or several pictures with depth and colour; `textures` are
what is printed on them, and recognised.
A `camera_picture` is taken from a viewpoint, and `perceived_places` are all that it shows with their items.
`pod_pose` finds the pod: from its `pod_legs` in a `planar_scan`, or from a `pod_start`, by a `pod_fit`, with
a `pod_bound` of the error, a `floor_pose_bound`.
`pallets` finds a pallet on the floor.
`tracking` follows items on a conveyor.
A `mount_calibration` finds it in several pictures, and the errors of cameras' mounts with it.
A `perceived_picture` shows answers over the picture; `perception_versions` say which packages shaped them.
A `believed_scene` is what all this leaves a robot with.
"""
