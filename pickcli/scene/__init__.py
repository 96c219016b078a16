"""The planning scene: carriers and items at their current poses, and pose uncertainty.

Start with `scene`, the `cloud` of a sensor and `unknown_space`; then `scene_file` and `cloud_file`, with
`scene_schema`, `scene_checks` and `scene_warnings`. `item_stream` has the items that ride on a conveyor,
with `stream_file` and `stream_schema`; `belt_sweep` draws them out over all that they may come to. Gaps
between solids: `touching`, `solid_overlap`, how deep they intersect, and `solid_distance`, how far apart
they are. `pile` is a height map of the items in an open box, and `colours` are those of pictures.
"""
