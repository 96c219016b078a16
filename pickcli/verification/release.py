"""Where the item is let go: inside the tote's walls and below the drop limit of the rules."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.scene import Scene
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.verification.arm import link_poses, tip_poses

DROP_LIMIT = 0.3  # m from the item's bottom to the tote's floor (rules of 2016)


def check_release(plan: Plan, scene: Scene, T_tip_item: Array | None) -> tuple[Reason, ...]:
    """() where nothing is released."""
    if plan.grasp is None or T_tip_item is None:
        return ()
    ends = zip(plan.segments, plan.segments[1:], strict=False)
    releases = [a for a, b in ends if a.held is not None and b.held is None]
    if plan.segments[-1].held is None and not releases:
        return (Reason("never released", plan.grasp.item, "the item is not brought to the tote"),)
    robot = scene.cell.robot
    return tuple(
        reason
        for segment in releases
        for reason in _inside(
            scene,
            plan.grasp.item,
            tip_poses(robot, link_poses(robot, plan.trajectory.sample(segment.t_end)), segment.pivot)[0]
            @ T_tip_item,
        )
    )


def _inside(scene: Scene, item_id: str, T_world_item: Array) -> Iterator[Reason]:
    tote = scene.cell.tote
    T = inverse(tote.T_world_tote) @ T_world_item
    reach = scene.find(item_id).item.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - reach, T[:3, 3] + reach
    half = np.array(tote.inner[:2]) / 2
    beyond = float(np.maximum(high[:2] - half, -half - low[:2]).max())
    if beyond > 0.0:
        yield Reason("released beyond the tote's walls", item_id, f"by {beyond * 1e3:.0f} mm")
    if low[2] > DROP_LIMIT:
        yield Reason(
            "released too high", item_id, f"{low[2]:.3f} m over the floor, the limit is {DROP_LIMIT}"
        )
