"""Calibration of a cell by touch: where its tote stands.

- What is touched: `tote_shape` and the `touch_points` on it.
- One touch: `touch_planning`, the way there and the line on which something is met, and `touch_measurement`,
  the point by the record of the guarded move.
- The pose: `tote_fit`, by all points.
- `tote_location`: the loop over all touches in the simulated world; `tote_file`, what it found, by its
  `tote_schema`.
"""
