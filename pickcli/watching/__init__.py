"""People seen from a driving truck, and what brakes it for them.

A `watched_scene` says who walks where past which reflectors; `watched_scene_file` reads it, `drawn_scene`
draws one. With its figures from a `watch_file`, a `nir_pair` of cameras takes `flash_pictures` of the
`scene_solids`, with the `retroreflection` of vests; `vest_detection` finds vests in them, `vest_tracking`
follows them. A `laser_scanner` watches a `protective_field`, which a `stopping_distance` determines;
`foreseen_contact` tells whether a stop would do. Both are `brake_guards`. A `drive_watch` oversees a drive
by them, `zone_watch` plays all of it, `watch_truth` keeps what was true, and a `watched_drive` is what came
of it, written by `watched_drive_file` and drawn by `watch_svg`.
"""
