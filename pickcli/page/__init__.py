"""Pages: self-contained HTML files that show a cell, scene, plan, roadmap, database or trial in 3-D, offline.

Read in this order:

- Data of a page: `page_document`, with `page_scene` (static content) and `page_motion` (motion).
- Conversion to these data: `shape_parts`, `visual_meshes` and `cell_parts`, `motion_parts`, `recorded_parts`,
  `path_clearance` and `failure_marks`.
- One module for each kind of page: `scene_page`, `plan_page`, `picture_page`, `trial_page` (with
  `trial_clearance` and `look_pictures`), `trials_page`, `grasps_page`, `envelope_page`, `pallet_page`,
  `pallet_trial_page`, `stream_trial_page`, `commission_page`, `commission_trials_page` and
  `stream_trials_page`.
- Output: `html_page`, which combines the document, the app (readable sources in the folder app) and three.js
  (in the folder vendor, with its licence) in one file; `live_page`, which serves the page of a running trial.
"""
