"""One file per subcommand: parse, call one library function, report. No algorithms.

Read in this order:

- The basis of every subcommand: `main`, the group of all, and `command`; then any of these, e.g. `plan_pick`.
- A new cell: `init`, `suggest_mount`, `suggest_configurations`.
- Offline: `build_roadmap`, `build_trajectories`, `refresh`, `cache`; `compare_planners` beside them.
- Online: `make_order`, `make_scene`, `make_stream`, `render`, `locate_pod`, `locate_tote`, `perceive`,
  `believe`, `plan_stow`, `plan_shift`, `plan_topple`, `plan_move`, `verify`, `execute`, `check_driver`,
  `export`, `roll_out` and `run_trial`; `explain_stow` before a stow; `run_trials` and `compare_trials` for
  many.
- Content and checks of files: `inspect`, `show`, `show_strategy` and `check`; `show_routes` before a look.
- Pallets: `make_pallet_order`, `plan_pallet` and `pallet_verification`; trucks: `plan_drive`,
  `verified_drive`, `detect_pallet` and `watch_zone`; hands with belts: `try_grasp`.
- Items: `show_grasps`, `show_envelope` and `import_tsr`, with the `named_item` of both; `record_grasp`.
- Options that commands share: `options` with `option_types`; `arm_options` with the `configuration_option`,
  `artifact_options`, `scene_options`, `stream_options`, `transit_options`, `stream_plan_options`,
  `plan_options`, `build_options`, `trial_options`,
  `pod_shift`, `operator_stop_option`; `logs` has --verbose and --debug.
- Queries: `stated_pick` and `stated_stow` refuse impossible ones, `motion_queries` reads --pick, --stow
  and --move, `query_execution` answers them.
- Functions that commands share: `plan_verification` and `plan_execution` for plans, `pick_request` and
  `experience_session` for queries, `building` for builds, `progress_bar`; `named_camera` for cameras,
  `camera_pictures` for what they take or took, and `listed_contents` for what is known to be there.
- Output to stdout: `report` and `table`; `cell_summary`, `summary_text` and `stored_motion` for `apc
  inspect`, `checked_texts` for `apc check`, `perceived_lines`, `execution_report` and `trial_table`;
  `played_stream` plays and reports a trial of a stream, `played_pallet` one of a pallet,
  `played_commission` one of a commission with its `people_options`; `played_commissions` and
  `played_streams` many, with the `trials_output` of all that are many.
"""
