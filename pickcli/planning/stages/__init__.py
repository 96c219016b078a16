"""The stages of a pick, one file each, which ``planning.pick`` goes through in this order.

``grasp_selection`` (``tool_clearance`` before any inverse kinematics, ``grasp_motion`` for the lines of one
grasp), ``extraction`` (``planned_extraction`` and ``lift_sampling`` where no simple corridor is free),
``transit`` to the grasp and from it, and ``placement``, where the item is let go: at ``drop_placements`` from
above, else at ``floor_placements``.
"""
