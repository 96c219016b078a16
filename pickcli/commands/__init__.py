"""One file per subcommand: parse, call one library function, report. No algorithms.

Read in this order:

- The basis of every subcommand: `main`, the group of all, `command`, and `logs` with --verbose and --debug;
  then any of these, e.g. `plan_pick`.
- A new cell: `init`, `suggest_mount`, `suggest_configurations`.
- Offline: `build_roadmap`, `build_trajectories`, `refresh`, `cache`; `compare_planners` beside them.
- Online: `make_order`, `make_scene`, `make_stream`, `render`, `locate_pod`, `locate_tote`, `perceive`,
  `believe`, `plan_stow`, `plan_shift`, `plan_topple`, `plan_move`, `verify`, `execute`, `check_driver`,
  `export`, `roll_out` and `run_trial`; `explain_stow` before a stow; `run_trials` and `compare_trials` for
  many.
- Content and checks of files: `inspect`, `show`, `show_strategy` and `check`; `show_routes` before a look.
- Pallets: `make_pallet_order` and `plan_pallet`; trucks: `plan_drive`, `detect_pallet` and `watch_zone`;
  hands with belts: `try_grasp`.
- Items: `show_grasps`, `show_envelope` and `import_tsr`; `record_grasp`.

What several of them share: the `options` that they take, the `operations` that they carry out, and their
`output`.
"""
