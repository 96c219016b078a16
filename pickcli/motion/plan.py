"""Plans: results of queries."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import Failures
from pickcli.geometry import Array
from pickcli.motion.event import Event
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory

MAX_DURATION = 300.0  # s, of any plan: at a tenth of full speed a pick takes two minutes
ROUNDING = 1e-9  # tenths of a mm, of floats that are whole tenths
MAX_NUMBER = 1e6  # in any unit of a plan: far beyond any quantity of an arm


@dataclass(frozen=True, eq=False)
class Grasp:
    """A pose of the tool on an item, and the load on cup or finger pads while the item is carried.

    All loads are the worst over gravity and planned acceleration. The axis of the load is that of the cup, or
    the one along which fingers close.

    Attributes:
        item: Id in the scene.
        kind: "frontal", "top-down" or "side".
        face: Face of the item that the cup is put on, e.g. "-x", or "+z/bowl" for the bottom of a hollow; or
            that fingers pinch: "x" for both faces across that axis, "mantle" or "sphere".
        tool_state: State of the tool that the grasp is made with.
        T_item_tip: (4, 4) tool frame in the item frame: of a cup on the face, +z into the item; of fingers
            between the pads.
        score: Smaller is better.
        moment: Nm of bending about the tip.
        pull: N along the axis.
        shear: N across the axis.
        twist: Nm about the axis.
        load_ratio: All of them at one time over what cup or pads bear there.
        envelope: Name of the envelope in which a region query found it; empty for a fixed candidate.
    """

    item: str
    kind: str
    face: str
    tool_state: ToolState
    T_item_tip: Array
    score: float
    moment: float
    pull: float
    shear: float
    twist: float
    load_ratio: float
    envelope: str = field(default="", kw_only=True)

    def __str__(self) -> str:
        """Return the name of the grasp in reasons, that of all grasps of its kind."""
        return str(GraspKind(self.kind, self.face))


@dataclass(frozen=True)
class GraspKind:
    """All grasps of one kind on one face: after a failure, none of them is tried at a neighbouring point.

    Attributes:
        kind: "frontal", "top-down" or "side".
        face: Face of the item's shape, e.g. "-x", or the axis across which fingers close, e.g. "x".
    """

    kind: str
    face: str

    def __str__(self) -> str:
        """Return the name in reasons."""
        return f"{self.kind} grasp on face {self.face}"

    @classmethod
    def named_in(cls, text: str) -> GraspKind | None:
        """Find the first name of grasps in the text of a reason, as written by ``str``.

        Args:
            text: The text, e.g. "top-down grasp on face +z, lift".

        Returns:
            The kind and face, or None if no grasp is named.
        """
        found = _NAME.search(text)
        return None if found is None else cls(found["kind"], found["face"])


_NAME = re.compile(r"(?P<kind>[\w-]+) grasp on face (?P<face>[+-]?\w+(?:/\w+)?)")


class RecoveryLevel(StrEnum):
    """Rules that a recovery motion for a stopped arm keeps to, the strictest first. See docs/recovery.md.

    From OPENING on, contact that exists at the start of the motion may open, but never deepen.
    """

    AS_PLANNED = "as planned"  # by the usual rules
    OPENING = "opening"  # away from solids that are near at the start
    BACKWARDS = "backwards"  # back along the motion that stopped
    SLOWLY = "slowly"  # at a tenth of the speed, items at their perceived poses without error bounds
    JOG = "jog"  # as slow, over a few millimetres, away from the nearest solid


@dataclass(frozen=True)
class Certificate:
    """What the verifier checked, how finely, and the hashes of the checked data.

    It guards against accidents and is not a signature: anyone who can edit a plan can also certify it. It
    states only that in this model (fingerprint) every state keeps at least ``min_clearance``, and the limits
    with the stated ratios. It is not a statement of safety.

    Attributes:
        motion_hash: SHA-256 of all that ``plan_file.motion_hash`` covers.
        scene_hash: SHA-256 of the scene that the plan was checked in.
        cell_fingerprint: Fingerprint of the cell.
        n_states: Number of checked states.
        max_step: m, farthest that any point of the robot moves between two checked states.
        min_clearance: m, over all pairs that are not planned contacts.
        max_velocity_ratio: Upper bound over all time of |v| over its limit.
        max_acceleration_ratio: Upper bound over all time of |a| over its limit.
        max_jerk_ratio: Upper bound over all time of |jerk| over its limit.
        checks: Descriptions of the checks.
    """

    motion_hash: str
    scene_hash: str
    cell_fingerprint: str
    n_states: int
    max_step: float
    min_clearance: float
    max_velocity_ratio: float
    max_acceleration_ratio: float
    max_jerk_ratio: float
    checks: tuple[str, ...]

    @property
    def clearance_mm(self) -> float:
        """The least clearance in mm, rounded down to a tenth: "at least" that much is kept."""
        return math.floor(1e4 * self.min_clearance + ROUNDING) / 10.0


@dataclass(frozen=True)
class LineTracking:
    """The running conveyor that a plan takes its item from (FANUC, ABB: line tracking).

    The item rides along +x of the conveyor at ``speed`` from the start of the plan on; from the pre-approach
    to the retreat the arm moves relative to it as if the belt stood, and the time of the plan is told by the
    travel of the belt. Before and after that the motion is free wherever the belt brings what rides on it.

    Attributes:
        conveyor: Name of the conveyor.
        speed: m/s of the belt.
        speed_error: m/s, bound of the error of the speed.
        deviation: m by which the belt may be ahead of the plan, or behind it, while the tool works on it.
        t_stream: s of the stream at which the plan starts.
    """

    conveyor: str
    speed: float
    speed_error: float = 0.0
    deviation: float = 0.0
    t_stream: float = 0.0

    def brought_by(self, end: float, t_left: float, most_speed: float) -> float:
        """Compute how far the belt may bring what comes until a plan ends.

        Args:
            end: s of the plan at its end.
            t_left: s of the plan until which the tool works on the belt.
            most_speed: m/s that the conveyor never exceeds.

        Returns:
            m from the start of the plan on.
        """
        return self.speed * t_left + self.deviation + most_speed * (end - t_left)


def times_at_work(segments: Sequence[Segment]) -> tuple[float, float]:
    """Find when the tool works on the item that it takes: from its lines towards it to the transfer.

    Args:
        segments: The segments of a plan with a contact and a transfer after it.

    Returns:
        s of the plan.
    """
    t_works = next(s.t_start for s in segments if s.kind is not SegmentKind.TRANSIT)
    t_contact = next(s.t_end for s in segments if s.kind is SegmentKind.CONTACT)
    t_left = next(s.t_start for s in segments if s.kind is SegmentKind.TRANSFER and s.t_start >= t_contact)
    return t_works, t_left


@dataclass(frozen=True, eq=False)
class Plan:
    """Segments, one trajectory over all of them, events and grasp; valid for one cell and scene.

    Everything except ``statistics`` is a pure function of the query: the same bytes every time.

    Attributes:
        query: The query, e.g. "pick crayola_24_ct from bin_B".
        cell_fingerprint: Fingerprint of the cell that it is valid for.
        scene_hash: Hash of the scene that it is valid for.
        seed: Seed of all random choices.
        segments: The parts of the motion, contiguous in time.
        trajectory: The motion.
        events: Resolved events.
        grasp: None for a move.
        speed_scale: Factor on the speed limits while the item is carried.
        certificate: None for a plan that was not verified.
        statistics: Wall-clock times and other measurements.
        recovery: Level of a recovery motion; None for every other plan.
        arm: Name of the moving arm; empty in a cell with one arm.
        others: States of all other arms during the motion.
        tracking: The running conveyor that the item rides on when the plan starts; None where items stand.
        upright: rad, the most that the held item is tilted from how it stood when it was taken (MoveIt:
            orientation path constraint); turns about the vertical are none. None for any.
    """

    query: str
    cell_fingerprint: str
    scene_hash: str
    seed: int
    segments: tuple[Segment, ...]
    trajectory: Trajectory
    events: tuple[Event, ...]
    grasp: Grasp | None = None
    speed_scale: float = 1.0
    certificate: Certificate | None = None
    statistics: Mapping[str, float] = field(default_factory=dict)
    recovery: RecoveryLevel | None = None
    arm: str = ""
    others: tuple[ArmState, ...] = ()
    tracking: LineTracking | None = None
    upright: float | None = None

    def with_statistics(self, **values: float) -> Plan:
        """Return the plan with further measurements.

        Args:
            values: Measurements by name, times in ms.

        Returns:
            The plan, the same except for ``statistics``.
        """
        return replace(self, statistics={**self.statistics, **values})


Certify = Callable[[Plan], Plan | Failures]  # returns the certified plan, or why it is rejected


def other_arm_elsewhere(plan: Plan, cell: Cell) -> str:
    """Explain why a plan does not fit the arms of a cell: another arm moves, or one stands elsewhere.

    Args:
        plan: The plan.
        cell: The cell as the moving arm sees it.

    Returns:
        One sentence, empty if the plan has the same arms in the same states.
    """
    if plan.arm != cell.arm:
        return f"made for {_called(plan.arm)}, this is {_called(cell.arm)}; plan it again"
    here = {state.arm: state for state in cell.others}
    for state in plan.others:
        found = here.pop(state.arm, None)
        if found is None:
            return f"made beside an arm {state.arm!r}, which the cell does not have; plan it again"
        if not state.is_at(found):
            return (
                f"made while arm {state.arm} stood at {state}, it stands at {found}; plan it again, or say "
                "where it stands"
            )
    return "".join(f"made without the arm {name!r} of the cell; plan it again" for name in list(here)[:1])


def _called(arm: str) -> str:
    return f"arm {arm}" if arm else "a cell with one arm"
