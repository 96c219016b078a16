"""State that all queries of one process share: the cell, its models and the precomputed files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.collision.checker import SceneChecker
from pickcli.collision.checker_cache import CheckerCache
from pickcli.collision.motion_segment import Mode
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.grasping.grasp_method import GraspMethod
from pickcli.grasping.method_choice import grasp_method
from pickcli.grasping.recorded_grasp import RecordedGrasp
from pickcli.kinematics.arm import Arm
from pickcli.path_planning.lattice_planner import why_no_lattice
from pickcli.path_planning.state_space import JointSpace
from pickcli.planning.pick_settings import DEFAULTS, DropPlace, GraspApproach, PickSettings
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.trajectory_database import TrajectoryDatabase
from pickcli.scene.scene import Scene

COARSE_RESERVE = 0.003  # m of additional clearance for coarse motions: they are fast, and blended


@dataclass(frozen=True, eq=False)
class PlanningContext:
    """Immutable data of online queries; ``dataclasses.replace`` makes one with other files.

    Attributes:
        cell: The cell.
        stored_roadmap: The cell's roadmap; without one, coarse queries have no roadmap to search.
        database: The cell's trajectory database, if it is built.
        settings: Settings of picks.
        learned: Motions that are looked up if ``database`` has none.
        recorded: Grasps that picks choose from, instead of those that ``settings.approach`` names; None for
            those.
    """

    cell: Cell
    stored_roadmap: Roadmap | None = None
    database: TrajectoryDatabase | None = None
    settings: PickSettings = DEFAULTS
    learned: TrajectoryDatabase | None = None
    recorded: tuple[RecordedGrasp, ...] | None = None

    @cached_property
    def roadmap(self) -> Roadmap:
        """The roadmap that coarse queries search, empty if none is stored."""
        return self.stored_roadmap or Roadmap.empty(self.cell.robot.joint_names)

    @cached_property
    def space(self) -> JointSpace:
        """The joints within their limits, at the cell's speed."""
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def arm(self) -> Arm:
        """Kinematics of the cell's arm."""
        return Arm(self.cell.robot)

    @cached_property
    def method(self) -> GraspMethod:
        """The method by which the cell's tool grasps, holds and releases items."""
        return grasp_method(self.cell.robot.tool)

    @cached_property
    def model(self) -> CollisionModel:
        """The collision model of the cell's robot."""
        return CollisionModel(self.cell)

    @cached_property
    def checkers(self) -> CheckerCache:
        """Cache of recently used checkers of the cell's model."""
        return CheckerCache(self.model)

    def with_approach(self, approach: GraspApproach) -> PlanningContext:
        """Return a context whose picks take their grasps from elsewhere.

        Args:
            approach: Where the grasps come from.

        Returns:
            The context, the same except for that.
        """
        return replace(self, settings=replace(self.settings, approach=approach))

    def dropping_from(self, drop_from: DropPlace) -> PlanningContext:
        """Return a context whose picks drop items into open boxes from elsewhere.

        Args:
            drop_from: From where.

        Returns:
            The context, the same except for that.
        """
        return replace(self, settings=replace(self.settings, drop_from=drop_from))

    def keeping_upright(self, upright: float | None) -> PlanningContext:
        """Return a context whose picks keep the held item upright.

        Args:
            upright: rad, the most that it is tilted from how it stood when it was taken; None for any.

        Returns:
            The context, the same except for that.
        """
        return replace(self, settings=replace(self.settings, upright=upright))

    def with_lattice_transits(self, expansions: int | None) -> PlanningContext:
        """Return a context whose picks reach their grasps by ARA* on the lattice of hand poses.

        Args:
            expansions: Most expansions of a search; None for precomputed files and the coarse planner.

        Returns:
            The context, the same except for that.

        Raises:
            InputError: There is no such lattice for the arm.
        """
        if expansions is not None and (few := why_no_lattice(len(self.cell.robot.joint_names))):
            raise InputError(f"cell {self.cell.name}: {few}")
        return replace(self, settings=replace(self.settings, expansions=expansions))

    def configurations_at(self, place: Place) -> list[Array]:
        """Return the configurations that the cell names for a place.

        Args:
            place: The place.

        Returns:
            (n,) each: above a place with access from above, else in front of its mouth. A cell may name none.
        """
        return [named.q for named in self.cell.configurations_at(place)]

    def checker_for(self, scene: Scene, mode: Mode) -> SceneChecker:
        """Return the checker for motions of the robot in one mode in a scene.

        Args:
            scene: The planning scene.
            mode: Tool state, attached item and allowed contacts.

        Returns:
            The checker, from the cache if it is there.
        """
        return self.checkers.robot(scene, mode)
