"""What every query of one process shares: the cell, its models and the precomputed files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache, partial

from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import Scene
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.model import CollisionModel
from pickcli.kinematics.arm import Arm
from pickcli.planning.settings import DEFAULTS, PickSettings
from pickcli.roadmap.database import TrajectoryDatabase
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.lesson import Lesson
from pickcli.roadmap.space import JointSpace

NONE: frozenset[str] = frozenset()
N_CHECKERS = 64  # that are kept: more than one query needs
RESERVE = 0.003  # m that coarse motions are planned with on top of the clearance: they are fast, and blended


@dataclass(eq=False)
class Planner:
    """A warm planner. ``stored`` and ``database`` may be absent: then every coarse query is planned.

    learned: motions that are asked for where ``database`` has none
    lessons: where it is a list, coarse queries add what they found that was not stored
    """

    cell: Cell
    stored: Roadmap | None = None
    database: TrajectoryDatabase | None = None
    settings: PickSettings = DEFAULTS
    learned: TrajectoryDatabase | None = None
    lessons: list[Lesson] | None = None
    roadmap: Roadmap = field(init=False)
    space: JointSpace = field(init=False)
    arm: Arm = field(init=False)
    model: CollisionModel = field(init=False)
    _checkers: Callable[..., SceneChecker] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.roadmap = self.stored or Roadmap.empty(self.cell.robot.joint_names)
        self.space = JointSpace.of(self.cell.robot, self.cell.speed_scale)
        self.arm = Arm(self.cell.robot)
        self.model = CollisionModel(self.cell)
        # By identity of scene and held item, as the boxes of a scene are kept.
        self._checkers = lru_cache(maxsize=N_CHECKERS)(partial(SceneChecker, self.model))

    def checker(
        self,
        scene: Scene,
        pivot: PivotState,
        held: AttachedItem | None = None,
        without: frozenset[str] = NONE,
        touching: AllowedContacts = NO_CONTACTS,
        reserve: float = 0.0,
        opening: frozenset[tuple[str, str]] = frozenset(),
    ) -> SceneChecker:
        """A checker of the scene for one pivot state, held item and set of planned contacts.

        reserve: m on top of the cell's clearance. opening: pairs that are not tested, see SceneChecker
        """
        margin = self.cell.clearance + reserve
        return self._checkers(scene, pivot, held, without, touching, margin, opening)
