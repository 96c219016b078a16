"""Where a suction cup may sit on an item, and whether it would hold there.

Read `surfaces` and `region` for the faces of an item, then `candidates` with `search` and `face_poses` for
the places on them; `holding` is the load on the cup at rest, `cup_press` how far it is pressed on.
"""
