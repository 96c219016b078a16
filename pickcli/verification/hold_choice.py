"""Selection of the grasp and event checks by the kind of the tool; no other module of the verifier asks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from pickcli.cell.tool import Tool
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene
from pickcli.verification.finger_events import check_finger_events
from pickcli.verification.grasp_check import check_kind, check_seal, cup_loads
from pickcli.verification.pinch_check import check_pinch, pad_loads
from pickcli.verification.strayed_pinch_check import check_strayed_pinch
from pickcli.verification.vacuum_events import TimedEvent, check_vacuum_events


@dataclass(frozen=True)
class HoldChecks:
    """The checks of one kind of tool.

    Attributes:
        grasp: Checks a plan with a grasp, given the pose (4, 4) of the item in the tool frame.
        events: Checks the commands that grasp and release.
        loads: Loads of wrenches (..., 6) on the held item, as shares of what the tool bears.
    """

    grasp: Callable[[Plan, Scene, Array], tuple[Reason, ...]]
    events: Callable[[Plan, Scene, Sequence[TimedEvent]], Iterable[Reason]]
    loads: Callable[[Plan, Scene, Array], Array]


def _check_grasp_of_fingers(plan: Plan, scene: Scene, T_tip_item: Array) -> tuple[Reason, ...]:
    assert plan.grasp is not None
    # An item held from the start, after a stop, is in no place that would define the grasp's kind.
    kind = () if plan.segments[0].held is not None else check_kind(scene, plan.grasp)
    return (*check_pinch(plan, scene, T_tip_item), *check_strayed_pinch(plan, scene, T_tip_item), *kind)


SUCTION = HoldChecks(check_seal, check_vacuum_events, cup_loads)
PINCH = HoldChecks(
    _check_grasp_of_fingers, lambda plan, scene, _: check_finger_events(plan, scene), pad_loads
)


def hold_checks(tool: Tool) -> HoldChecks:
    """Select the checks for a tool.

    Args:
        tool: The tool. A bare flange holds nothing; its plans have neither grasp nor contact.

    Returns:
        The checks.
    """
    return PINCH if isinstance(tool.grip, ParallelGripper) else SUCTION


def check_hold(plan: Plan, scene: Scene, T_tip_item: Array | None) -> tuple[Reason, ...]:
    """Check everything that concerns the tool and the item that it holds.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the held item in the tool frame.

    Returns:
        The faults; () for a plan without a grasp.
    """
    if plan.grasp is None or T_tip_item is None:
        return ()
    return hold_checks(scene.cell.robot.tool).grasp(plan, scene, T_tip_item)


def load_ratios(plan: Plan, scene: Scene, wrenches: Array) -> Array:
    """Compute the load on the tool.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene.
        wrenches: (..., 6) that the tool exerts on the held item at the tip, in the tool frame.

    Returns:
        The loads (...) as shares of what the tool bears.
    """
    return hold_checks(scene.cell.robot.tool).loads(plan, scene, wrenches)
