"""What stands in the cell now, how well that is known, and what rests on what.

Read `scene` with the `cloud` that a sensor saw; then `scene_file` and `cloud_file`, with `scene_schema`,
`scene_checks` and `scene_warnings`. How solids meet: `touching`, `solid_overlap` and `patches`, from which
`solid_contact` follows. What rests on what: `contact_graph` has all contacts of a scene, `balance` the
statics of its items, and `supports` what falls or rolls when one is taken away. What lies in a box is seen
from above as a `pile`.
"""
