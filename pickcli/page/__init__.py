"""Pages: one HTML file that shows a cell, scene, plan, roadmap, database or trial in 3-D, without a network.

Read in this order:

- All that a page shows: `page_document`, made of `page_scene` (what stands) and `page_motion` (what happens).
- What fills it: `shape_parts`, `visual_meshes` and `cell_parts`, `motion_parts`, `path_clearance` and
  `failure_marks`.
- One module for each kind of page: `scene_page`, `plan_page`, `picture_page`,
  `trial_page` (with `trial_clearance`), `trials_page` and `grasps_page`.
- What writes it: `html_page`, which puts the document, the app (readable, in
  the folder app) and three.js (in the folder vendor, with its licence) into one file.
"""
