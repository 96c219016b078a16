"""Trials: whole orders played in simulation, from the selection of targets to the score.

Read in this order:

- Orders: `order`, read by `order_file`; `make_order` draws random orders. `stow_assignment` chooses the bins
  for the items of a stow.
- The trial: by its `trial_settings`, `loop` does what its strategy decides by the `action_values`, with time
  by the `trial_clock`; its `target_list` knows what is open, and `attempt_memory` what failed. `item_moves`
  moves one item: `attempt_runner` plans, with a `certifier` that has the verifier judge every candidate;
  `attempt_execution` executes and determines the outcome. Blocking items are moved aside: `clearing` searches
  them and their destinations, `aside_memory` keeps such moves from being undone; `room_making` moves what
  takes the room of an item in a bin. What stands on edge is toppled: `toppling_memory` knows when. A
  `jam_memory` knows which items are not to push others aside again.
- Failures: `recovery_levels` after a stop; `arm_turns` when another arm is in the way.
- Environment: `trial_interfaces`, implemented by the `simulated_cell`; `pod_shift` displaces the pod,
  `tote_shift` the tote, `pose_noise` adds errors to perceived poses. What the robot perceives is by a
  `trial_perception`, of which `camera_looks` is the one by cameras: `simulated_cameras` take its pictures,
  and `camera_motion` brings them there.
- Results: `disturbance` and `damage`, judged in the `final_state` by the rules of `score`, are part of a
  `trial_result`; `trial_folder` stores it with its `trial_record`, the `motion_record` and the official
  `output_file`; `trial_summary` has the rows of its table. A `record_kind` reads records of one
  kind of trial; `record_schema` and `motion_schema` validate stored records and motions.
- A `played_trial` is everything that a folder stores. In trials of pallets and commissions,
  `standing_items` is what is known of items that stand, and a `scene_plan` a plan that was executed.
"""
