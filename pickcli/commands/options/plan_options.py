"""Options that the planning commands share, as one value."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import certified
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.artifact_options import artifact_options, load_context
from pickcli.commands.options.common_options import (
    approach_option,
    drop_from_option,
    json_option,
    output_option,
    passed_as,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.configuration_option import parse_start, start_option
from pickcli.commands.options.experience_session import ExperienceSession, experience_session, learn_option
from pickcli.commands.options.option_types import FiniteRange
from pickcli.commands.options.scene_options import refuse_held, scene_or_empty
from pickcli.commands.options.transit_options import TransitOptions, transit_options
from pickcli.commands.output.report import plan_summary, plan_text

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.grasping.recorded_filters import RemovedGrasp
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class PlanOptions:
    """The shared options of a planning command.

    Attributes:
        scene_path: File of the scene; None for the empty cell.
        cell_name: Name or folder of the cell; None for the one that the scene names.
        items_path: The user's own items.
        start: Start configuration, as written.
        arm: The arm that moves; None if not stated.
        standing: Configurations of other arms, as ``ARM=NAME|q``.
        no_verify: Whether plans are written unverified.
        roadmap: File of the roadmap; None for that of the cache.
        trajectories: File of the trajectory database; None for that of the cache.
        learn: Whether experience is stored.
        seed: Seed of all random choices.
        as_json: Whether JSON is printed.
        output: File of the plan.
        overwrite: Whether an existing file may be replaced.
    """

    scene_path: Path | None
    cell_name: str | None
    items_path: Path | None
    start: str
    arm: str | None
    standing: tuple[str, ...]
    no_verify: bool
    roadmap: Path | None
    trajectories: Path | None
    learn: bool
    seed: int
    as_json: bool
    output: Path
    overwrite: bool

    def arms(self, *goals: str) -> ArmRequest:
        """Return the arms stated on the command line.

        Args:
            *goals: Configurations that the arm must have besides the start.

        Returns:
            The request.
        """
        return ArmRequest(self.arm, self.standing, (self.start, *goals), items=self.items_path)

    def scene(self, *goals: str) -> Scene:
        """Read the scene, or make the empty one, after a check that the plan can be written.

        Args:
            *goals: Configurations that the arm must have besides the start.

        Returns:
            The scene.

        Raises:
            UsageError: Neither a scene nor a cell is named.
            InputError: A file cannot be read or written, or the scene has a held item.
            StaleError: The scene was made for another cell.
        """
        read = self.scene_path, self.cell_name, self.items_path, self.roadmap, self.trajectories
        refuse_output(self.output, self.overwrite, *read)
        scene = scene_or_empty(self.scene_path, self.cell_name, self.arms(*goals))
        refuse_held(scene, self.scene_path)
        return scene

    def begin(self, scene: Scene) -> Start:
        """Return the state of the robot before the motion, after a check of the arms that stand still.

        Args:
            scene: The scene.

        Returns:
            Configuration and tool state.

        Raises:
            InputError: The start is no configuration of the cell, or another arm is in collision.
        """
        from pickcli.api.arm_states import refuse_standing

        start = parse_start(scene.cell, self.start)
        refuse_standing(scene, start)
        return start

    @contextmanager
    def session(self, cell: Cell) -> Iterator[ExperienceSession]:
        """Load what the motion is planned with; ``experience_session`` states the rest.

        Args:
            cell: The cell as the moving arm sees it.

        Yields:
            The session, with the planning context to be used.
        """
        with stage("reading of roadmap and trajectories"):
            context = self._context(cell)
        with experience_session(context, self.roadmap, self.trajectories, self.learn) as session:
            yield session

    def _context(self, cell: Cell) -> PlanningContext:
        return load_context(cell, self.roadmap, self.trajectories)

    def deliver(
        self, plan: Plan, scene: Scene, is_judged: bool = False, ranked: Sequence[ArmSuitability] = (),
        removed: Sequence[RemovedGrasp] = (),
    ) -> None:  # fmt: skip
        """Verify a plan if requested, write it and print its summary.

        Args:
            plan: The plan.
            scene: The scene in which it is to be executed.
            is_judged: Whether it was already verified, if requested.
            ranked: Ranking of the arms, the best first, if the arm was chosen.
            removed: Recorded grasps that filters removed, and why.

        Raises:
            RejectedError: The verifier rejects the plan; nothing is written.
            InputError: The file cannot be written.
        """
        from pickcli.motion.plan_file import write_plan

        if not (is_judged or self.no_verify):
            plan = certified(plan, scene, _advice(plan, scene.cell))
        write_plan(plan, self.output, self.overwrite)
        if self.as_json:
            why = [{**asdict(arm), "against": arm.against and str(arm.against)} for arm in ranked]
            told = [
                {"grasp": each.number, "source": each.source, "by": each.by, "why": each.why}
                for each in removed
            ]
            more = {"arms_ranked": why, "removed_grasps": told}
            emit_json({**plan_summary(plan, self.output), **{key: more[key] for key in more if more[key]}})
        else:
            click.echo("\n".join([*map(str, (*ranked, *removed)), plan_text(plan, self.output)]))


@dataclass(frozen=True)
class PickOptions(PlanOptions):
    """The shared options of a command that plans with grasps.

    Attributes:
        approach: Where the grasps come from.
        drop_from: From where items are dropped into a tote.
    """

    approach: str
    drop_from: str

    def _context(self, cell: Cell) -> PlanningContext:
        from pickcli.planning.pick_settings import DropPlace, GraspApproach

        context = super()._context(cell).with_approach(GraspApproach(self.approach))
        return context.dropping_from(DropPlace(self.drop_from))


@dataclass(frozen=True)
class RecordedPickOptions(PickOptions, TransitOptions):
    """The options of a pick whose grasps may have been recorded.

    Attributes:
        upright: Degrees, the most that the held item is tilted; None for any.
    """

    upright: float | None

    def _context(self, cell: Cell) -> PlanningContext:
        recorded = self.recorded(cell)
        upright = None if self.upright is None else math.radians(self.upright)
        return self.planned_by(super()._context(cell).keeping_upright(upright), recorded)

    def refuse_contradictions(self) -> None:
        """Refuse options that exclude each other, and a plan in place of the file of grasps.

        Raises:
            UsageError: Grasps come from two sources, or an option is stated that another planner has.
            InputError: The plan would replace the file of grasps.
        """
        self.refuse_beside(self.approach)
        if self.grasps_path is not None:
            refuse_output(self.output, self.overwrite, self.grasps_path)


def verify_option(function: F) -> F:
    """Give a command the option --no-verify.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--no-verify", is_flag=True, help="Write the plan unverified, without a certificate."
    )(function)


def pick_options(function: F) -> F:
    """Give a command the options of every command that plans with grasps, besides those of its scene.

    Args:
        function: The command.

    Returns:
        The command with the options, which are passed to it as ``options``, a ``PickOptions``.
    """
    return _pick_options(PickOptions)(function)


def recorded_pick_options(function: F) -> F:
    """Give a command the options of ``pick_options``, --grasps, --upright, --planner and --expansions.

    Args:
        function: The command.

    Returns:
        The command with the options, which are passed to it as ``options``, a ``RecordedPickOptions``.
    """
    function = click.option(
        "--upright", type=FiniteRange(0.0, 90.0, min_open=True), metavar="DEG",
        help="Tilt the held item by no more than this, from how it stands when it is taken.  [default: any]",
    )(_pick_options(RecordedPickOptions)(function))  # fmt: skip
    return transit_options(function)


def _pick_options(kind: type[PickOptions]) -> Callable[[F], F]:
    shared = plan_options("the preferred one of those that hold and reach the item", kind)
    return lambda function: approach_option(drop_from_option("inside")(shared(function)))


def plan_options(default_arm: str, of: type[PlanOptions] = PlanOptions) -> Callable[[F], F]:
    """Give a command the options of every planning command besides those of its scene.

    Args:
        default_arm: The arm if none is named, for the help.
        of: Type of the value that they are passed as.

    Returns:
        A decorator that adds the options, and passes them with those of the scene as ``options``, a
        ``PlanOptions``.
    """

    def decorate(function: F) -> F:
        function = passed_as("options", of)(function)
        for option in (  # the last is the first in the help
            output_option("plan"), json_option, seed_option, learn_option, artifact_options, verify_option,
            standing_option, arm_option(default_arm), start_option,
        ):  # fmt: skip
            function = option(function)
        return function

    return decorate


def _advice(plan: Plan, cell: Cell) -> str:
    """Return advice for a plan that the verifier rejects."""
    from pickcli.motion.plan import MAX_DURATION

    speed = cell.max_tool_speed
    if speed is not None and plan.trajectory.duration > MAX_DURATION:
        return f"the cell's max_tool_speed of {speed:g} m/s makes it too long; raise that"
    return "try another --seed, or look at the plan with --no-verify"
