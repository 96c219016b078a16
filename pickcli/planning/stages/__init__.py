"""The stages of a pick, which ``planning.pick`` goes through in this order.

- The grasp, in `grasp_selection`: `target_check` asks whether the item may be taken at all, `tool_clearance`
  what the tool alone could do, before any inverse kinematics; `grasp_motion` proves the lines of one grasp.
- The ways out, in `extraction`: `planned_extraction` and `lift_sampling` where no simple corridor is free.
- Coarse motions, in `transit`: `grasp_transit` to the grasp, and `transfer` with the item to its placement.
- Letting the item go, in `placement`: at `drop_placements` from above, else at `floor_placements`.
"""
