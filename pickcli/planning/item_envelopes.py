"""Envelopes of an item in a scene: what checks tool and arm there, and which share of them is reached."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import at_object
from pickcli.errors import NoPlanError, Reason
from pickcli.grasping.envelope import Envelope
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene

SEEDS = 4  # of inverse kinematics for each pose


@dataclass(frozen=True, eq=False)
class ItemEnvelopes:
    """Envelopes of an item in a scene.

    Attributes:
        target: The item.
        tool_state: State of the tool.
        envelopes: In which it can be grasped, if nothing is in the way.
        tool: Checks the tool without the arm; cup or fingers may touch the item.
        arm: Checks the arm, with the same contacts.
    """

    target: PlacedItem
    tool_state: ToolState
    envelopes: tuple[Envelope, ...]
    tool: FreeToolChecker
    arm: SceneChecker

    @classmethod
    def of(
        cls, context: PlanningContext, scene: Scene, target: PlacedItem, state: ToolState
    ) -> ItemEnvelopes:
        """Make the envelopes of an item for one state of the tool.

        Args:
            context: The cell and its models.
            scene: The scene.
            target: The item, in it.
            state: State of the tool.

        Returns:
            The envelopes.

        Raises:
            NoPlanError: The tool cannot grasp it from any side.
        """
        contacts = at_object(target.id)
        axes = context.cell.T_world_place(context.cell.places[target.location])[:3, :3]
        tool = context.checkers.tool(scene, state, axes, contacts)
        envelopes = context.method.envelopes(target.item, tool.depth)
        if not envelopes:
            raise NoPlanError("envelopes", [without_envelopes(target)])
        return cls(
            target, state, envelopes, tool, context.checkers.robot(scene, Mode(state, contacts=contacts))
        )

    def reached(
        self, context: PlanningContext, envelope: Envelope, n: int, rng: np.random.Generator
    ) -> float:
        """Estimate which share of an envelope the arm reaches, free of everything.

        Args:
            context: The cell and its models.
            envelope: Whole or truncated.
            n: Number of poses that are tried.
            rng: Source of poses and seeds.

        Returns:
            The share of the poses with a free configuration.
        """
        arm, n_reached = context.arm, 0
        for T in self.target.T_world_item @ envelope.sample(rng, n):
            found = arm.solve(T, self.tool_state, arm.random_seeds(rng, SEEDS))
            n_reached += len(found) > 0 and bool(self.arm.are_valid(found).any())
        return n_reached / n


def without_envelopes(target: PlacedItem) -> Reason:
    """Explain why an item has no envelopes.

    Args:
        target: The item.

    Returns:
        The reason.
    """
    why = target.item.why_not or "it is too large for the tool, or no face takes it"
    return Reason("nothing to grasp", target.id, why)
