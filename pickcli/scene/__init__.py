"""The planning scene: carriers and items at their current poses, pose uncertainty, contacts and support.

Start with `scene` and the `cloud` of a sensor; then `scene_file` and `cloud_file`, with `scene_schema`,
`scene_checks` and `scene_warnings`. Contacts between solids: `touching`, `solid_overlap` and `patches`, which
`solid_contact` builds on. Support: `contact_graph` collects all contacts of a scene, `balance` solves the
statics of single items, `balance_warning` warns of those that cannot be at rest, and `supports` predicts
which fall or roll when another is removed. `pile` is a height map of the items in an open box.
"""
