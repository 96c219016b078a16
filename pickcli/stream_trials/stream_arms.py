"""The arms of a trial of a stream: which one acts, where it stands, and where it brings items to.

As in trials of orders, one arm moves at a time while the others stand in their parking configurations. The
arm that acted takes the next item, too, if it has a plan for it; else it is parked, and another one does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import Failures, InputError, NoPlanError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.belt_sweep import swept_along_belt
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import TOTE, empty_scene
from pickcli.simulation.motion_recorder import joint_positions
from pickcli.verification.verify import certifier

SAME_PLACE = 1e-3  # rad or m of each joint by which an arm stands off its parking configuration at most


class StreamArms:
    """The arms of one trial, and which of them acts.

    Args:
        contexts: Of each arm: the cell as it sees it, its models and its precomputed files.

    Attributes:
        context: That of the arm that acts.
        start: Where that arm is at rest.
    """

    def __init__(self, contexts: Sequence[PlanningContext]) -> None:
        self._contexts = tuple(contexts)
        self._into = {context.cell.arm: destination_of(context.cell) for context in contexts}
        self.context = self._contexts[0]
        self.start = self.home(self.context)

    @property
    def destinations(self) -> frozenset[str]:
        """Places that items are brought to by any arm."""
        return frozenset(self._into.values())

    @property
    def all(self) -> tuple[PlanningContext, ...]:
        """Contexts of all arms, the preferred one first."""
        return self._contexts

    @property
    def others(self) -> tuple[PlanningContext, ...]:
        """Contexts of the arms that stand parked."""
        return tuple(each for each in self._contexts if each is not self.context)

    def home(self, context: PlanningContext) -> Start:
        """Return where an arm stands at the start, and while it is parked.

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

    @property
    def positions(self) -> dict[str, float]:
        """Where the joints of all arms and tools stand at the start, in rad or m by joint."""
        found: dict[str, float] = {}
        for context in self._contexts:
            start = self.home(context)
            found |= joint_positions(context.cell.robot, start.q, start.tool_state)
        return found

    def let_act(self, context: PlanningContext) -> None:
        """Let another arm act, from where it was parked.

        Args:
            context: That of the arm.
        """
        self.context, self.start = context, self.home(context)

    def parking(self, stream: ItemStream, t: float, seed: int) -> Plan | None:
        """Plan the motion of the arm that acts to where it is parked, clear of all that the belt may bring.

        Args:
            stream: The items on the conveyor.
            t: s of the stream at which the motion starts.
            seed: Seed of all random choices.

        Returns:
            The certified plan; None if the arm stands there.

        Raises:
            NoPlanError: There is no such motion.
        """
        context, home = self.context, self.home(self.context)
        off = unwound_towards(context.arm.limits, self.start.q, home.q) - home.q
        if float(np.abs(off).max()) <= SAME_PLACE and self.start.tool_state == home.tool_state:
            return None
        scene = replace(stream.scene_at(t), cell=context.cell)
        scene = swept_along_belt(scene, stream.conveyor) if stream.speed > 0.0 else scene
        label = f"park arm {context.cell.arm}"
        plan = plan_move(context, scene, self.start, MoveGoal(home.q, home.tool_state), seed, label)
        certified = certifier(scene)(plan)
        if isinstance(certified, Failures):
            raise NoPlanError(label, certified)
        return certified


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
