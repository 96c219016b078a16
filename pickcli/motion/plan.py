"""What a query returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.motion.event import Event
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory

MAX_DURATION = 300.0  # s, of any plan: at a tenth of full speed a pick takes two minutes
MAX_NUMBER = 1e6  # in any unit of a plan: nothing that an arm does is near it


@dataclass(frozen=True, eq=False)
class Grasp:
    """A cup pose on an item.

    kind: "frontal", "top-down" or "side"; face names the face of the item's shape, e.g. "-x"
    """

    item: str  # id in the scene
    kind: str
    face: str
    tool_state: ToolState
    T_item_tip: Array  # (4, 4) tool frame in the item frame; tip on the face, +z into the item
    score: float  # smaller is better
    moment: float  # Nm of bending about the cup, worst over gravity and planned acceleration; so all below
    pull: float  # N
    shear: float  # N
    twist: float  # Nm about the cup's axis
    load_ratio: float  # of all of them together over what the cup bears on that face, at any one time


@dataclass(frozen=True)
class GraspKind:
    """All grasps from one side of one face, wherever on it: what failed once is not tried just beside."""

    kind: str
    face: str


class RecoveryLevel(StrEnum):
    """What a motion that frees a stopped arm claims, the strictest first. See docs/recovery.md.

    From OPENING on, contact that is there when the motion begins may open, and never deepen.
    """

    AS_PLANNED = "as planned"  # by the rules of every plan
    OPENING = "opening"  # out of what is near at the start
    BACKWARDS = "backwards"  # along the motion that stopped, from where it stands to where it came from
    SLOWLY = "slowly"  # at a tenth of the speed, items where they were seen, without the bound of the error
    JOG = "jog"  # as slowly, over a few millimetres, away from what is nearest


@dataclass(frozen=True)
class Certificate:
    """What the verifier checked, how finely, and of which bytes.

    It guards against accidents and is no signature: whoever can edit a plan can certify it, too.
    May claim no more than: in this model (fingerprint), every state keeps clearance at least
    ``min_clearance`` and limits below the ratios. It is not a statement of safety.
    """

    motion_hash: str  # SHA-256 of trajectory, segments, events and grasp
    scene_hash: str  # SHA-256 of what was checked against
    cell_fingerprint: str
    n_states: int
    max_step: float  # m, farthest any point of the robot moves between two checked states
    min_clearance: float  # m, over all pairs that are not planned contacts
    max_velocity_ratio: float  # worst |v| / limit at every ms
    max_acceleration_ratio: float
    max_jerk_ratio: float
    checks: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Plan:
    """Segments, one trajectory over all of them, events, grasp; valid for one cell and scene.

    ``seed`` and everything but ``statistics`` are a pure function of the query: same bytes every time.
    """

    query: str  # e.g. "pick crayola_24_ct from bin_B"
    cell_fingerprint: str
    scene_hash: str
    seed: int
    segments: tuple[Segment, ...]
    trajectory: Trajectory
    events: tuple[Event, ...]
    grasp: Grasp | None = None
    speed_scale: float = 1.0
    certificate: Certificate | None = None
    statistics: dict[str, float] = field(default_factory=dict)  # wall-clock figures, nowhere else
    recovery: RecoveryLevel | None = None  # what it claims as a way out of a stop; None for every other plan
