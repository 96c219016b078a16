"""What stands in the cell now, how well that is known, and what rests on what.

Read `scene`, then `scene_file`, `scene_schema` and `scene_checks`; `touching`, `solid_overlap` and
`patches` measure how solids meet, from which `solid_contact` follows; `contact_graph` has all contacts of a
scene, `balance` the statics of its items, and `supports` what falls or rolls when one is taken away.
"""
