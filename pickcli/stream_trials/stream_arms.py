"""The arms of a trial of a stream: where each stands, until when it moves, and where it brings items to.

Plans are made for one arm in the cell as it sees it, with the others parked. Truly the others rest where they
brought their last item, or are on their way; so what one arm does is proven apart from what the others do
(``reserved_motion``). Whether they move at the same time is a matter of the trial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene, empty_scene
from pickcli.simulation.motion_recorder import joint_positions
from pickcli.stream_trials.reserved_motion import ReservedMotion

LATE = 0.04  # s by which one arm may be late against another, besides what the error of the belt's speed adds
STRAYING = 0.003  # m by which each arm may be beside its plan, beyond the cell's clearance
AS_PLANNED = 0.01  # rad or m by which each joint may be off where its plan has it within that time


@dataclass(eq=False)
class StreamArm:
    """One arm of a trial.

    Attributes:
        context: The cell as it sees it, its models and its precomputed files.
        start: Where it is at rest, at the end of its last motion.
        free_at: s of the stream from which on it rests, and may move.
        reserved: What it is to do until then, which others keep out of.
        measured: What it did, until then.
    """

    context: PlanningContext
    start: Start
    free_at: float
    reserved: ReservedMotion
    measured: ReservedMotion

    @classmethod
    def at_home(cls, context: PlanningContext, home: Start) -> StreamArm:
        """Return an arm that has not moved yet.

        Args:
            context: Its context.
            home: Where it stands.

        Returns:
            The arm.
        """
        rests = ReservedMotion.resting(context.model, home.q)
        return cls(context, home, 0.0, rests, rests)

    def rest(self, start: Start, free_at: float) -> None:
        """Let it rest somewhere, as if it had always been there.

        Args:
            start: Where.
            free_at: s of the stream from which on it may move.
        """
        self.start, self.free_at = start, free_at
        self.reserved = self.measured = ReservedMotion.resting(self.context.model, start.q)

    def note_measured(self, poses: Sequence[tuple[float, Array]], late: float) -> None:
        """Note what it did. Others keep out of that if it was not as planned, within some time.

        Args:
            poses: s of the stream, increasing, each with the measured configuration (n,).
            late: s by which it may have been late, or early.
        """
        times, q = np.array([t for t, _ in poses]), np.array([at for _, at in poses])
        self.measured = ReservedMotion.measured(self.context.model, times, q, self.reserved.taken)
        when = np.arange(times[0], max(self.measured.t_end, self.reserved.t_end) + late, 0.01)
        near = np.stack([self.reserved.at(when + off) for off in np.linspace(-late, late, 9)])
        is_as_planned = (self.measured.at(when) >= near.min(axis=0) - AS_PLANNED) & (
            self.measured.at(when) <= near.max(axis=0) + AS_PLANNED
        )
        if not is_as_planned.all():
            self.reserved = self.measured


class StreamArms:
    """The arms of one trial.

    Args:
        contexts: Of each arm, the preferred one first.
        move_together: Whether several of them may move at the same time.

    Attributes:
        all: The arms, the preferred one first.
    """

    def __init__(self, contexts: Sequence[PlanningContext], move_together: bool) -> None:
        self._contexts, self._move_together = tuple(contexts), move_together
        self._into = {context.cell.arm: destination_of(context.cell) for context in contexts}
        self.all = tuple(StreamArm.at_home(context, self.home(context)) for context in contexts)

    @property
    def destinations(self) -> frozenset[str]:
        """Places that items are brought to by any arm."""
        return frozenset(self._into.values())

    @property
    def positions(self) -> dict[str, float]:
        """Where the joints of all arms and tools stand at the start, in rad or m by joint."""
        found: dict[str, float] = {}
        for context in self._contexts:
            start = self.home(context)
            found |= joint_positions(context.cell.robot, start.q, start.tool_state)
        return found

    def free(self, t: float) -> tuple[StreamArm, ...]:
        """Return the arms that may begin to move.

        Args:
            t: s of the stream.

        Returns:
            Those at rest; none while another one moves, if they do not move together.
        """
        resting = tuple(arm for arm in self.all if arm.free_at <= t)
        return resting if self._move_together or len(resting) == len(self.all) else ()

    def overlap(self, t_start: float, t_end: float) -> float:
        """Return for how long arms that began before still move while another one does.

        Args:
            t_start: s of the stream at which it begins.
            t_end: s of the stream at which it rests.

        Returns:
            s in which more than one moves.
        """
        return max(0.0, min(t_end, max(arm.free_at for arm in self.all)) - t_start)

    def next_rest(self, t: float) -> float:
        """Return when the next of the arms that move comes to rest.

        Args:
            t: s of the stream.

        Returns:
            s of the stream; infinite if none moves.
        """
        return min((arm.free_at for arm in self.all if arm.free_at > t), default=np.inf)

    @property
    def next_free(self) -> float:
        """Time (s) of the stream at which arms may begin to move."""
        ends = [arm.free_at for arm in self.all]
        return min(ends) if self._move_together else max(ends)

    def home(self, context: PlanningContext) -> Start:
        """Return where an arm stands at the start.

        Args:
            context: That of the arm.

        Returns:
            Configuration and tool state.
        """
        stands = next(
            (state for each in self._contexts for state in each.cell.others if state.arm == context.cell.arm),
            context.cell.home,
        )
        return Start(stands.q, stands.tool_state)

    def bring_home(self, arm: StreamArm, takes: float) -> None:
        """Let an arm be brought home by hand, once all others rest.

        Args:
            arm: The arm.
            takes: s that it takes.
        """
        t = max(each.free_at for each in self.all) + takes
        arm.rest(self.home(arm.context), t)
        for each in self.all:
            each.free_at = max(each.free_at, t)

    def why_not_apart(self, arm: StreamArm, plan: Plan, scene: Scene, t: float, late: float) -> Reason | None:
        """Explain why a motion of one arm is not proven apart from what the others do.

        Args:
            arm: The arm.
            plan: The plan of the motion.
            scene: The scene at its start.
            t: s of the stream at which it starts.
            late: s by which either may be late against the other.

        Returns:
            The reason; None if it is proven.
        """
        if len(self.all) == 1:
            return None
        motion, keep = ReservedMotion.planned(arm.context.model, plan, scene, t), arm.context.cell.clearance
        each = (
            motion.why_not_apart(other.reserved, t, keep + 2.0 * STRAYING, late)
            for other in self.all
            if other is not arm
        )
        return next((why for why in each if why is not None), None)

    def why_met(self, arm: StreamArm, t: float) -> Reason | None:
        """Explain why an arm may have met another one in its last motion, as both were measured.

        Args:
            arm: The arm.
            t: s of the stream at which that motion started.

        Returns:
            The reason; None if they were apart.
        """
        each = (
            arm.measured.why_not_apart(other.measured, t, 0.0, 0.0) for other in self.all if other is not arm
        )
        return next((why for why in each if why is not None), None)


def destination_of(cell: Cell) -> str:
    """Return the place that an arm brings items to: the tote; without one the open box nearest to it.

    Args:
        cell: The cell as the arm sees it.

    Returns:
        Name of the place.

    Raises:
        InputError: The cell has none.
    """
    if TOTE in cell.places:
        return TOTE
    boxes = {name: place for name, place in cell.places.items() if place.is_open_box}
    if not boxes:
        raise InputError(
            f"{cell.path / 'cell.yaml'}: has neither a tote nor a box to bring the items of a stream to; add "
            "a place of kind box (docs/formats/cell.md)"
        )
    scene = empty_scene(cell)
    far = {
        name: float(np.linalg.norm(scene.T_world_place(place)[:2, 3] - cell.robot.shoulder[:2]))
        for name, place in boxes.items()
    }
    return min(boxes, key=far.__getitem__)
