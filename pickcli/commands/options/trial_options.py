"""Shared by the commands that play trials: their options as one value, and the arms that play."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.core import ParameterSource

from pickcli.commands.options.arm_options import arm_option
from pickcli.commands.options.artifact_options import artifact_options, load_context
from pickcli.commands.options.build_options import jobs_option
from pickcli.commands.options.common_options import (
    CELL_HELP,
    DEFAULT_CELL,
    advised,
    approach_option,
    drop_from_option,
    items_option,
    passed_as,
    reality_option,
    stow_rule_option,
    strategy_option,
)
from pickcli.commands.options.named_camera import refuse_missing_opencv, sift_option
from pickcli.commands.options.pod_shift import pod_shift_option, tote_shift_option
from pickcli.errors import InputError
from pickcli.perception.textures.sift_views import SiftRule

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.cell.workcell import Workcell
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.roadmap.query_experience import ExperienceRecorder
    from pickcli.scene.scene import PoseNoise
    from pickcli.simulation.reality import Reality
    from pickcli.trial.order import Order
    from pickcli.trial.played_trial import TrialConditions
    from pickcli.trial.simulated_cell import TrialArm
    from pickcli.trial.trial_perception import PerceptionKind

F = TypeVar("F", bound=Callable[..., Any])
MAX_NOISE = (50.0, 45.0)  # mm, degrees: larger errors make poses meaningless
MINUTE_NOISE = (0.1, 0.05)  # mm, degrees: smaller errors are probably in m and rad


def pose_noise_option(function: F) -> F:
    """Give a command the option --pose-noise MM,DEG.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--pose-noise", metavar="MM,DEG", callback=parse_noise, default="2,1", show_default=True,
        help="Bounds of the errors of perceived poses, in mm and degrees.",
    )(function)  # fmt: skip


def perception_option(function: F) -> F:
    """Give a command the option --perception.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--perception", type=click.Choice(["truth", "noise", "camera"]),
        help="How the robot sees: exactly, with errors within --pose-noise, or by the cameras of the cell.  "
             "[default: camera in pick orders, if they see into all bins and no --pose-noise is given; "
             "else noise]",
    )(function)  # fmt: skip


def locate_tote_option(function: F) -> F:
    """Give a command the option --locate-tote.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--locate-tote", is_flag=True,
        help="Begin by touching the tote with the cup to locate it; else it is known by an estimate.",
    )(function)  # fmt: skip


def parse_noise(ctx: click.Context | None, param: click.Parameter | None, value: str) -> PoseNoise:
    """Parse the value of --pose-noise.

    Args:
        ctx: Context of click.
        param: The option.
        value: Millimetres and degrees with a comma, from the command line.

    Returns:
        Bounds of the error of item poses in m and rad.

    Raises:
        BadParameter: The value is not two numbers, or they are out of range.
    """
    from pickcli.scene.scene import PoseNoise

    try:
        millimetres, degrees = (float(part) for part in value.split(","))
    except ValueError:
        what = f"{value!r}: expected two numbers, millimetres and degrees, e.g. 2,1"
        raise click.BadParameter(what, ctx, param) from None
    if not (0.0 <= millimetres <= MAX_NOISE[0] and 0.0 <= degrees <= MAX_NOISE[1]):
        what = f"{value!r}: expected 0..{MAX_NOISE[0]:g} mm and 0..{MAX_NOISE[1]:g} degrees"
        raise click.BadParameter(what, ctx, param)
    if 0.0 < millimetres < MINUTE_NOISE[0] or 0.0 < degrees < MINUTE_NOISE[1]:
        click.echo(
            f"note: --pose-noise {value}: {millimetres:g} mm and {degrees:g} degrees are a tiny error; "
            "the units are mm and degrees, not m and rad",
            err=True,
        )
    return PoseNoise(millimetres / 1000.0, math.radians(degrees))


@dataclass(frozen=True)
class TrialOptions:
    """The shared options of a command that plays trials.

    Attributes:
        perception: Source of the perceived scene: "truth", "noise" or "camera"; None for that of the cell.
        sift: For which items cameras look for prints, and how.
        pose_noise: Bounds of the error of item poses.
        strategy_name: Name or file of the strategy.
        stow_rule: Name of the rule by which bins are chosen.
        approach: Where grasps come from.
        drop_from: From where items are dropped into a tote.
        pod_shift: Displacement of the pod in m and rad, "random" or "none"; None if not stated.
        tote_shift: Displacement of the tote, alike.
        locate_tote: Whether the robot begins by touching the tote to locate it.
        reality_path: File of the levels of reality; None for the default levels.
        cell_name: Name or folder of the cell.
        items_path: The user's own items.
        arm: The arm that plays; None for all.
        roadmap: File of the roadmap; None for that of the cache.
        trajectories: File of the trajectory database; None for that of the cache.
        jobs: Number of parallel processes; None for one per core.
    """

    perception: str | None
    sift: SiftRule
    pose_noise: PoseNoise
    strategy_name: str
    stow_rule: str
    approach: str
    drop_from: str
    pod_shift: Displacement | str | None
    tote_shift: Displacement | str | None
    locate_tote: bool
    reality_path: Path | None
    cell_name: str
    items_path: Path | None
    arm: str | None
    roadmap: Path | None
    trajectories: Path | None
    jobs: int | None

    @property
    def inputs(self) -> tuple[Path | str | None, ...]:
        """Files that the command reads besides orders, and the cell by its name or folder."""
        stored = self.roadmap, self.trajectories
        return self.reality_path, self.cell_name, self.items_path, self.strategy_name, *stored

    def cells(self, workcell: Workcell) -> list[Cell]:
        """Select the arms that play.

        Args:
            workcell: The cell with all its arms.

        Returns:
            The cell as seen by each arm that plays, the preferred one first.

        Raises:
            InputError: A stored file is named, and several arms play; or the cell has no places.
        """
        is_one = self.arm is not None or not workcell.parked
        for option, path in (("--roadmap", self.roadmap), ("--trajectories", self.trajectories)):
            if path is not None and not is_one:
                raise InputError(
                    f"{option}: a file is for one arm, but cell {workcell.name} plays with "
                    f"{' and '.join(workcell.arms)}; name one with --arm, or use the files in the cache"
                )
        cells = [workcell.cell(self.arm)] if is_one else list(workcell.arms.values())
        for cell in cells:
            cell.require_places()
            _ = cell.home  # refused before any work if the cell has none
        return cells

    def planning_contexts(self, cells: Sequence[Cell]) -> list[PlanningContext]:
        """Load the planning context of each arm; missing artifacts are built in the cache.

        Args:
            cells: The cell as seen by each arm that plays.

        Returns:
            The contexts, in the same order.
        """
        from pickcli.planning.pick_settings import DropPlace, GraspApproach

        approach, drop_from = GraspApproach(self.approach), DropPlace(self.drop_from)
        contexts = (
            load_context(cell, self.roadmap, self.trajectories, build_missing=True, jobs=self.jobs)
            for cell in cells
        )
        return [context.with_approach(approach).dropping_from(drop_from) for context in contexts]

    def refuse_misplaced(self, reality: Reality, cell: Cell, orders: Iterable[Order], seed: int) -> None:
        """Refuse, before any work, a pod or a tote beyond their bounds, and a tote that cannot be touched.

        Args:
            reality: Levels of reality, as read from the file.
            cell: The cell as seen by the arm that moves first.
            orders: The orders that are to be played.
            seed: Seed of the first trial.

        Raises:
            InputError: One of them is.
        """
        from pickcli.trial.pod_shift import standing
        from pickcli.trial.tote_shift import refuse_touches, tote_stands

        standing(self.pod_shift, reality, cell, seed)
        tote_stands(self.tote_shift, reality, cell, seed)
        if self.locate_tote:
            for order in orders:
                refuse_touches(cell, order)

    def conditions(self, reality: Reality, cell: Cell, orders: Iterable[Order]) -> TrialConditions:
        """Return the conditions of trials of orders.

        Args:
            reality: Levels of reality, as read from the file.
            cell: The cell as seen by the arm that moves first.
            orders: The orders that are to be played.

        Returns:
            The conditions.

        Raises:
            InputError: There is no such strategy, or its file is invalid; or prints are looked for, and the
                library for it is not installed.
            UsageError: An option was stated that does not apply to this perception.
        """
        from pickcli.scene.scene import PoseNoise
        from pickcli.strategy.strategy_file import load_strategy
        from pickcli.trial.played_trial import TrialConditions
        from pickcli.trial.stow_assignment import StowRule
        from pickcli.trial.trial_perception import PerceptionKind

        strategy = load_strategy(self.strategy_name)
        rule, kind, noise = StowRule(self.stow_rule), self._perception_in(cell, orders), self.pose_noise
        if kind is not PerceptionKind.NOISE and is_stated("pose_noise"):
            is_truth = kind is PerceptionKind.TRUTH
            why = "there are no errors with" if is_truth else "pictures have errors of their own with"
            raise click.UsageError(f"--pose-noise: {why} --perception {kind}; leave it out")
        if kind is PerceptionKind.TRUTH:
            noise = PoseNoise()
        return TrialConditions(
            noise, reality, self.pod_shift, rule, strategy, kind, self._sift_of(kind, cell), self.tote_shift,
            self.locate_tote,
        )  # fmt: skip

    def _perception_in(self, cell: Cell, orders: Iterable[Order]) -> PerceptionKind:
        """As stated, or by the kind of all orders and what the cell has."""
        from pickcli.perception.viewpoints import refuse_unseen_bins, sees_all_bins
        from pickcli.trial.order import OrderKind
        from pickcli.trial.trial_perception import PerceptionKind

        if self.perception is not None:
            kind = PerceptionKind(self.perception)
            if kind is PerceptionKind.CAMERA:
                with advised(", or play with --perception noise"):
                    refuse_unseen_bins(cell)
            return kind
        if is_stated("pose_noise") or any(order.kind is not OrderKind.PICK for order in orders):
            return PerceptionKind.NOISE
        return PerceptionKind.CAMERA if sees_all_bins(cell) else PerceptionKind.NOISE

    def _sift_of(self, kind: PerceptionKind, cell: Cell) -> SiftRule:
        """How prints are looked for; what does that is missed before any work."""
        from pickcli.perception.viewpoints import sees_all_bins
        from pickcli.trial.trial_perception import PerceptionKind

        if kind is not PerceptionKind.CAMERA:
            if self.sift is not SiftRule.NONE and is_stated("sift"):
                blind = f"those of cell {cell.name} do not see all its bins; leave it out"
                advice = "add --perception camera" if sees_all_bins(cell) else blind
                raise click.UsageError(f"--sift: prints are looked for by cameras; {advice}")
            return SiftRule.NONE
        refuse_missing_opencv(self.sift, ", or cameras with --perception noise")
        return self.sift


def refuse_stow_rule(orders: Iterable[Order]) -> None:
    """Refuse --stow-rule, before any work, if no order is one to stow.

    Args:
        orders: The orders that are to be played.

    Raises:
        UsageError: The rule was stated and applies to none of them.
    """
    from pickcli.trial.order import OrderKind

    kinds = {order.kind for order in orders}
    if is_stated("stow_rule") and OrderKind.STOW not in kinds:
        raise click.UsageError(f"--stow-rule is for stow orders, this is a {min(kinds)} order; leave it out")


def is_stated(name: str) -> bool:
    """Tell whether an option was stated on the command line.

    Args:
        name: Name of its parameter.

    Returns:
        Whether it was.
    """
    return click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE


def refuse_options_of_orders(names: Iterable[str], kind: str) -> None:
    """Refuse options that apply to trials of orders, but not to one of another kind.

    Args:
        names: Names of their parameters.
        kind: What is played instead, in the plural.

    Raises:
        UsageError: One of them was stated.
    """
    context = click.get_current_context()
    stated = [
        next(opt for param in context.command.params if param.name == name for opt in param.opts)
        for name in names
        if is_stated(name)
    ]
    if stated:
        verb = "apply" if len(stated) > 1 else "applies"
        raise click.UsageError(f"{' and '.join(stated)} {verb} to orders, not to {kind}; leave it out")


def _cell_option(function: F) -> F:
    """Give a command the option --cell NAME|FOLDER, whose default depends on what is played."""
    return click.option(
        "--cell", "cell_name", metavar="NAME|FOLDER", default=DEFAULT_CELL,
        help=f"{CELL_HELP}  [default: {DEFAULT_CELL}; of a stream, pallet or commission its own]",
    )(function)  # fmt: skip


def trial_options(function: F) -> F:
    """Give a command the options of every command that plays trials.

    Args:
        function: The command.

    Returns:
        The command with the options, which are passed to it as ``options``, a ``TrialOptions``.
    """
    function = passed_as("options", TrialOptions)(function)
    for option in (  # the last is the first in the help
        jobs_option, artifact_options, arm_option("all of the cell's, one at a time"), items_option,
        _cell_option, reality_option, locate_tote_option,
        tote_shift_option("none, unless --reality says otherwise"),
        pod_shift_option("random, unless --reality says otherwise"),
        approach_option, drop_from_option("rim"), stow_rule_option, strategy_option, pose_noise_option,
        sift_option(" by camera"), perception_option,
    ):  # fmt: skip
        function = option(function)
    return function


def trial_arm(
    workcell: Workcell, context: PlanningContext, recorder: ExperienceRecorder | None = None
) -> TrialArm:
    """Combine what one arm of a cell plays a trial with.

    Args:
        workcell: The cell with all its arms.
        context: Planning context of the arm.
        recorder: Records experience of its queries; None discards it.

    Returns:
        The arm.
    """
    from pickcli.trial.simulated_cell import TrialArm

    arm = context.cell.arm
    return TrialArm(context, recorder, workcell.parked.get(arm), workcell.preferences.get(arm, 0))
