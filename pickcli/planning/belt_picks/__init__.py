"""Picks from a running conveyor, met at the earliest time at which the arm can be there.

Read `intercept`, which answers a `belt_query`:

- With a linear axis along the belt, `axis_intercept`: the axis alone follows it. `axis_windows` are the times
  between which the lines of a grasp can be followed, `reach_table` says at once what is never met, and
  `tracked_stitching` adds the motion of the belt to that of the axis.
- Without one, `arm_intercept`: all joints follow it. `belt_grasps` are found once for all places along it,
  `belt_reach` is how far the arm reaches them, `belt_meetings` orders when they are tried, `follow_bounds`
  says at once what is never met, and `followed_stitching` adds the motion of the belt to that of the arm.
- In both, `belt_proof` binds the events in time and proves the ways free, `belt_raise` lengthens the lines
  to where the arm may wait whatever comes, and `line_pace` slows them down, so that the belt may change its
  speed.
- By the rules of 2013, `grasp_filtering` leaves out recorded grasps that chase the item, or are not reached.
"""
