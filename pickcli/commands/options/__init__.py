"""Options that commands share, and the values that are made of them, refused before any work.

- Every command's: `common_options` with `option_types`; `arm_options` with the `configuration_option`.
- Planning: `artifact_options`, `plan_options`, `transit_options`, `experience_session`; building:
  `build_options`.
- Scenes: `scene_options`, `pod_shift`; streams: `stream_options`, `stream_plan_options`; trials:
  `trial_options`, `people_options`, `operator_stop_option`.
- Queries: `stated_pick` and `stated_stow` refuse impossible ones, `pick_request` chooses the arm,
  `motion_queries` reads --pick, --stow and --move.
- Items and cameras: `named_item`, `named_camera`, `camera_pictures` for what a camera takes or took, and
  `listed_contents` for what is known to be there.
"""
