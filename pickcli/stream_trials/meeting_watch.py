"""Measures how well a tool meets an item on a belt: where it is on the item, and how fast over it.

Of the speed the one step is left out in which the tool takes hold of the item: the engine forgets all of the
item's contacts then (``Engine.set_collision``), and what stands on a round base gets 10 mm/s for that step.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.world import ROBOT, World
from pickcli.stream_trials.stream_result import MeetingRecord

TOUCH = 0.001  # m of the tool from its planned place, along its axis, within which it is at the item
NEAR = 0.03  # m of the tool from that place across its axis, beyond which it is not on its way there
RESTING = 0.003  # m/s of the tool along its axis relative to the item, below which it rests there


class MeetingWatch:
    """Measures how tool and item move relative to each other while the tool rests at the item to take it.

    On a belt that is slower than planned that is later than planned.

    Args:
        plan: The plan.
        world: The world at its start.
        rest: s at the end of the contact in which the cup seals, or the fingers close.
    """

    def __init__(self, plan: Plan, world: World, rest: float) -> None:
        assert plan.grasp is not None
        self.item, self.T_item_tip = plan.grasp.item, plan.grasp.T_item_tip
        contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
        self.t_planned, self.rest = world.t + contact.t_end - rest, rest
        self.t_rests: float | None = None  # when the tool came to rest at the item
        self.along = np.array([1.0, 0.0, 0.0])
        if plan.tracking is not None:
            self.along = world.cell.carriers[plan.tracking.conveyor].T_world_carrier[:3, 0]
        self.slip, self.offset = 0.0, np.inf
        self.t_held: float | None = None

    def after_step(self, world: World) -> None:
        """Look at tool and item after a step.

        Args:
            world: The world.
        """
        if self.t_held is None and world.held == self.item:
            self.t_held = world.t
        if self.t_rests is not None and world.t > self.t_rests + self.rest:
            return
        tip, last = world.tip, world.robot.tool.last_link
        T_world_place = world.engine.pose(self.item) @ self.T_item_tip
        off = inverse(T_world_place) @ tip
        linear, _ = world.engine.relative_velocity(self.item, ROBOT, last, tip[:3, 3])
        is_over = float(np.hypot(off[0, 3], off[1, 3])) < NEAR
        is_there = is_over and off[2, 3] > -TOUCH and abs(float(linear @ tip[:3, 2])) < RESTING
        if self.t_rests is None and (is_there or self.t_held is not None):
            self.t_rests = world.t
        if self.t_rests is None:
            return
        if world.t != self.t_held:
            self.slip = max(self.slip, abs(float(linear @ self.along)))
        self.offset = float(np.hypot(off[0, 3], off[1, 3]))

    def measured(self, t_start: float) -> MeetingRecord | None:
        """Return the measurement.

        Args:
            t_start: s of the stream at which the plan started.

        Returns:
            How the item was met; None if the tool never held it.
        """
        if self.t_held is None:
            return None
        return MeetingRecord(t_start + self.t_planned, self.t_held - self.t_planned, self.slip, self.offset)
