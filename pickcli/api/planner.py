"""``Planner``: all functions on motions in one cell, for scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pickcli.api.arm_states import refuse_standing, states_of
from pickcli.api.configurations import Configuration, goals_of, start_of, state_named
from pickcli.api.obstacle_check import check_obstacles
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.shapes import Body
from pickcli.cell.station import Obstacles
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, InputError, NoPlanError, UnknownNameError
from pickcli.kinematics.continuous_joints import ways_round
from pickcli.motion.path import JointPath
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.coarse_path import COARSE_LIMITS
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import DropPlace, GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.precompute.artifact_cache import read_stored
from pickcli.scene.scene import TOTE, Scene, empty_scene
from pickcli.seeds import derived_seed
from pickcli.verification.verify import certify

if TYPE_CHECKING:
    from pickcli.perception.items.perceived_file import Perceived
    from pickcli.simulation.execution import Execution


@dataclass(frozen=True, eq=False)
class Planner:
    """Plans, times, verifies and executes motions in one cell, and looks into its places.

    It caches models, but has no other state.

    If a method is called without a scene, the cell is empty. Every failure is an ``ApcError``; the same seed
    gives the same motion.

    Attributes:
        context: The cell, its models and its precomputed files.
    """

    context: PlanningContext

    @classmethod
    def load(
        cls,
        cell: Cell | str | Path,
        roadmap: Path | None = None,
        trajectories: Path | None = None,
        arm: str | None = None,
        standing: Mapping[str, Configuration] | None = None,
    ) -> Planner:
        """Make the planner of a cell, with its precomputed files if they are built.

        Args:
            cell: The cell, the name of one that ships with the package, or the path of a cell's folder.
            roadmap: File of its roadmap; None for the one in the user's cache, if it exists.
            trajectories: File of its trajectory database; None for the one in the user's cache, if it exists.
            arm: Name of the arm that moves; None in a cell with one arm.
            standing: Configurations of other arms during the motion, by name of the arm; arms that are not
                named are parked.

        Returns:
            The planner.

        Raises:
            InputError: The cell or a file cannot be read; the cell has several arms and none is named; or an
                arm is named for a cell that is given as one of its arms sees it.
            UnknownNameError: There is no such cell, arm, or configuration.
            StaleError: A file was made for another cell.
            DamagedError: The content of a file is not what was written.
        """
        if isinstance(cell, Cell):
            if arm is not None or standing:
                raise InputError(
                    f"cell {cell.name}: is given as one arm sees it; name it to choose another arm"
                )
        else:
            workcell = load_workcell(cell)
            cell = workcell.cell(arm, states_of(workcell, standing or {}))
        return cls(PlanningContext(cell, *read_stored(cell, roadmap, trajectories)))

    @property
    def cell(self) -> Cell:
        """The cell of this planner."""
        return self.context.cell

    @cached_property
    def scene(self) -> Scene:
        """The empty cell."""
        return empty_scene(self.cell)

    def _seen(self, scene: Scene | None) -> Scene:
        """Return a scene as this arm sees it, even if it was made with another; the empty cell for None."""
        if scene is None:
            return self.scene
        is_own = scene.cell.fingerprint == self.cell.fingerprint
        is_same = scene.cell.scene_fingerprint == self.cell.scene_fingerprint
        return replace(scene, cell=self.cell) if is_same and not is_own else scene

    def among(self, obstacles: Sequence[Body]) -> Planner:
        """Return a planner for the same cell with more obstacles: another cell, with its own fingerprint.

        Args:
            obstacles: Static solids, in the world frame; boxes, cylinders or spheres.

        Returns:
            The planner.

        Raises:
            InputError: A name is already used, or a solid is of another kind, inside out or not finite.
        """
        cell = self.cell
        taken = {link.name for link in cell.robot.links} | {body.name for body, _ in self.scene.standing}
        check_obstacles(obstacles, taken)
        grown = replace(cell, obstacles=Obstacles((*cell.obstacles.bodies, *obstacles)))
        return Planner(replace(self.context, cell=replace(grown, fingerprint=fingerprint(grown))))

    def perceive(
        self,
        scene: Scene,
        camera: str,
        at: Configuration = "home",
        places: Sequence[str] = (),
        sift: str = SiftRule.AUTO,
        textures: int = 1,
        seed: int = 0,
    ) -> Perceived:
        """Find the items of places in a look of a simulated camera: the same answers as ``apc perceive``.

        Models of items are kept: the second look of a process that needs them takes a fraction of the time.

        Args:
            scene: The scene, which is seen by the camera alone; what is listed in each place is known.
            camera: Name of a depth camera of the cell.
            at: Where the arm is.
            places: Names of the places to look into; none for all with items of whose room half is seen.
            sift: For which items prints are looked for: "auto", "none", "all-views" or "each-view".
            textures: Seed of the prints on the items.
            seed: Seed of the noise.

        Returns:
            An answer for each item, by place, with its route; ``write_perceived`` writes it.

        Raises:
            UnknownNameError: The cell has no such camera, configuration or place, or there is no such rule.
            InputError: The camera measures no depth, too little of a place is seen, an item has no model, or
                prints are looked for and OpenCV is not installed.
        """
        from pickcli.api.camera_look import CameraLook, perceived_by

        rules = [each.value for each in SiftRule]
        if sift not in rules:
            raise UnknownNameError("sift", sift, rules)
        look = CameraLook(camera, at, tuple(places), SiftRule(sift), textures, seed)
        return perceived_by(self._seen(scene), look)

    def plan_path(
        self,
        start: Configuration,
        goals: Configuration | Sequence[Configuration],
        obstacles: Sequence[Body] = (),
        scene: Scene | None = None,
        tool_state: str | None = None,
        seed: int = 0,
    ) -> JointPath:
        """Plan a geometric path of the empty tool, proven free at every point, without timing.

        Args:
            start: Start configuration.
            goals: Goal configurations; the path leads to the one that is reached in the least time.
            obstacles: Additional obstacles, as in ``among``, whose planner also times the path.
            scene: The scene; None for the empty cell.
            tool_state: Name of the tool state; None for the one of the start.
            seed: Seed of all random choices.

        Returns:
            The path, which ends in one of the goals; continuous joints up to whole turns.

        Raises:
            NoPlanError: Start or all goals are not free, or no path was found; with the reasons.
            InputError: The start, a goal or an obstacle is not valid.
            StaleError: The scene is of another cell.
        """
        if obstacles:
            there = self.among(obstacles)
            here = None if scene is None else replace(scene, cell=there.cell)
            return there.plan_path(start, goals, (), here, tool_state, seed)
        begin, wanted = start_of(self.cell, start, tool_state), goals_of(self.cell, goals)
        checker = self.context.checker_for(self._seen(scene), Mode(begin.tool_state))
        free = [q for q in wanted if checker.is_valid(q)]
        if not checker.is_valid(begin.q):
            raise NoPlanError("path", [checker.explain(begin.q).at("start")])
        if not free:
            raise NoPlanError("path", [checker.explain(q).at(f"goal {i}") for i, q in enumerate(wanted)])
        ends = np.concatenate([ways_round(self.context.arm.limits, q, begin.q) for q in free])
        found = plan_coarse(
            self.context, checker, begin.q, ends, [0.0] * len(ends), derived_seed(seed, "path"), "path"
        )
        if isinstance(found, Failures):
            raise NoPlanError("path", found)
        return JointPath(self.cell.robot.joint_names, found.waypoints)

    def time_path(
        self, path: JointPath, scene: Scene | None = None, tool_state: str | None = None, seed: int = 0
    ) -> Plan:
        """Time a path under all limits, from rest to rest, with blended corners, and prove it free again.

        Args:
            path: The path.
            scene: The scene; None for the empty cell.
            tool_state: Name of the tool state; None for its default state.
            seed: Seed recorded in the plan.

        Returns:
            The plan, uncertified.

        Raises:
            NoPlanError: The path does not move, or its timed motion cannot be proven; with the reasons.
            InputError: The path has other joints.
        """
        names = self.cell.robot.joint_names
        if path.joint_names != names:
            raise InputError(f"path: is of {', '.join(path.joint_names)}, the cell plans {', '.join(names)}")
        mode = Mode(start_of(self.cell, path.start, tool_state).tool_state)
        segment = MotionSegment(SegmentKind.TRANSIT, path.waypoints, COARSE_LIMITS, mode=mode)
        plan = stitch_run(self.context, self._seen(scene), [segment], "path", seed)
        if isinstance(plan, Failures):
            raise NoPlanError("path", plan)
        return plan

    def plan_move(
        self,
        start: Configuration,
        goal: Configuration,
        scene: Scene | None = None,
        seed: int = 0,
        tool_state: str | None = None,
    ) -> Plan:
        """Plan a timed move of the empty tool from rest to rest (KTH's primitive).

        Args:
            start: Start configuration.
            goal: Goal configuration.
            scene: The scene; None for the empty cell.
            seed: Seed of all random choices.
            tool_state: Name of the tool state at the goal; None to keep that of the start.

        Returns:
            The plan, uncertified.

        Raises:
            NoPlanError: No motion was found; with the reasons.
            InputError: The start or the goal is not valid, or another arm is in collision.
        """
        (q_goal,) = goals_of(self.cell, goal)
        begin, here = start_of(self.cell, start), self._seen(scene)
        refuse_standing(here, begin)
        state = None if tool_state is None else state_named(self.cell, tool_state)
        return plan_move(self.context, here, begin, MoveGoal(q_goal, state), seed)

    def plan_pick(
        self,
        scene: Scene,
        item: str,
        into: str = TOTE,
        start: Configuration = "home",
        seed: int = 0,
        approach: str = GraspApproach.LINES,
        drop_from: str = DropPlace.INSIDE,
    ) -> Plan:
        """Plan a pick, from the start configuration to the release of the item.

        Args:
            scene: The scene with the items.
            item: Name of the item, or id of one of several.
            into: Name of the place that it is brought to.
            start: Start configuration.
            seed: Seed of all random choices.
            approach: Where grasps come from: "lines", "region", "reactive" or "lines-then-region".
            drop_from: From where the item is dropped into an open box: "inside" or "rim".

        Returns:
            The plan, uncertified.

        Raises:
            NoPlanError: No candidate leads to a complete motion; with every reason.
            InputError: The cell has no places, the cup holds something, a name is unknown, or another arm is
                in collision.
        """
        known: dict[str, tuple[str, list[str]]] = {
            "approach": (approach, [*GraspApproach]), "drop_from": (drop_from, [*DropPlace])
        }  # fmt: skip
        for what, (name, names) in known.items():
            if name not in names:
                raise UnknownNameError(what, name, [str(each) for each in names])
        self.cell.require_places()
        if scene.held is not None:
            raise InputError(f"{scene.held.id} is in the cup, and a pick begins with an empty one")
        target = scene.find(item)
        query = PickQuery(target.location, target.id, into=into)
        begin, here = start_of(self.cell, start), self._seen(scene)
        refuse_standing(here, begin)
        context = self.context.with_approach(GraspApproach(approach)).dropping_from(DropPlace(drop_from))
        return plan_pick(context, here, query, begin, seed)

    def verify(self, plan: Plan, scene: Scene | None = None) -> Plan:
        """Verify a plan by the independent verifier.

        Args:
            plan: The plan.
            scene: The scene in which it is to be executed.

        Returns:
            The plan with its certificate.

        Raises:
            RejectedError: The verifier rejects it; with every reason.
            StaleError: It was made for another cell or scene.
        """
        return certify(plan, self._seen(scene))

    def execute(self, plan: Plan, scene: Scene | None = None, seed: int = 0) -> Execution:
        """Execute a plan in simulation, from its start. It is verified first, even if it has a certificate.

        Args:
            plan: The plan.
            scene: The scene.
            seed: Seed of all random effects of the simulated world.

        Returns:
            The record of the execution.

        Raises:
            RejectedError: The verifier rejects the plan; nothing moves.
            StaleError: It was made for another cell or scene.
        """
        from pickcli.simulation.execute import execute
        from pickcli.simulation.world import World

        here = self._seen(scene)
        trusted = self.verify(plan, here)
        first, tool = plan.segments[0].tool_state, self.cell.robot.tool
        at_start = tool.default_state if first == MOVING else first
        world = World(here, plan.trajectory.positions[0], at_start, seed=seed)
        try:
            return execute(trusted, world)
        finally:
            world.close()
