"""Plays one trial in simulation, from order and seed to all contents of its folder."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.station import POD
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.progress import ProgressObserver, nobody
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import TOTE, CarrierPose, PoseNoise, Scene
from pickcli.simulation.motion_recorder import MotionRecorder, joint_positions
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.strategy.strategy_file import DEFAULT_STRATEGY, load_strategy
from pickcli.strategy.strategy_tree import Strategy
from pickcli.trial.loop import run_trial
from pickcli.trial.motion_record import RecordedMotion, motion_values, parse_motion
from pickcli.trial.order import Order
from pickcli.trial.pod_shift import standing
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.simulated_cell import SimulatedArena, TrialArm, interfaces_of
from pickcli.trial.stow_assignment import StowRule
from pickcli.trial.tote_shift import tote_stands
from pickcli.trial.trial_folder import pictures_of_looks
from pickcli.trial.trial_perception import PerceptionKind
from pickcli.trial.trial_record import record_digest, trial_record
from pickcli.trial.trial_result import TrialResult
from pickcli.trial.trial_settings import TrialSettings

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class TrialConditions:
    """Conditions of a trial, independent of order and seed.

    Attributes:
        noise: Bounds of the errors of perceived item poses.
        reality: Levels of the deviations of the simulated world from its model.
        pod_shift: Displacement of the pod, "random" or "none"; None to follow ``reality``.
        stow_rule: Rule by which bins are chosen in a stow.
        strategy: Decides what is tried next.
        perception: Source of the perceived scene.
        sift: For which items cameras look for prints, and how.
        tote_shift: Displacement of the tote, "random" or "none"; None to follow ``reality``.
        touches_tote: Whether the robot begins by touching the tote to locate it.
    """

    noise: PoseNoise = DEFAULT_NOISE
    reality: Reality = DEFAULT
    pod_shift: Displacement | str | None = None
    stow_rule: StowRule = StowRule.POINTS
    strategy: Strategy = field(default_factory=lambda: load_strategy(DEFAULT_STRATEGY))
    perception: PerceptionKind = PerceptionKind.NOISE
    sift: SiftRule = SiftRule.NONE
    tote_shift: Displacement | str | None = None
    touches_tote: bool = False


@dataclass(frozen=True)
class TrialRequest:
    """Parameters of a trial.

    Attributes:
        order: The order.
        order_name: Name of its file, for the record.
        conditions: Conditions of the trial.
        seed: Seed of all random choices.
    """

    order: Order
    order_name: str
    conditions: TrialConditions
    seed: int


@dataclass(frozen=True, eq=False)
class PlayedTrial:
    """A trial with all contents of its folder.

    Attributes:
        result: The result.
        record: The result as JSON values.
        pictures: (height, width, 3) RGB, before and after, and of looks.
        motion: Recorded motion as JSON values.
    """

    result: TrialResult
    record: dict[str, Any]
    pictures: Mapping[str, NDArray[np.uint8]]
    motion: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class TrialSnapshot:
    """A trial while it is played.

    Attributes:
        record: The result so far as JSON values.
        recorder: The motion so far.
        cells: The cell as seen by each arm that plays.
    """

    record: dict[str, Any]
    recorder: MotionRecorder
    cells: tuple[Cell, ...]

    def motion(self) -> RecordedMotion:
        """Return the motion so far, as it would be read from its file."""
        return parse_motion(motion_values(self.recorder, self.cells))


def stowed_scene(request: TrialRequest, cell: Cell, on_progress: ProgressObserver = nobody) -> Scene:
    """Create the scene at the start of a trial, with the items of the order in their places.

    Args:
        request: The trial.
        cell: The cell as seen by the arm that moves first.
        on_progress: Called with the number of finished places.

    Returns:
        The true scene.

    Raises:
        InputError: The items do not fit in a place, or pod or tote would be beyond their displacement
            bounds.
    """
    order, conditions = request.order, request.conditions
    T_world_pod, _ = standing(conditions.pod_shift, conditions.reality, cell, request.seed)
    tote, _ = tote_stands(conditions.tote_shift, conditions.reality, cell, request.seed)
    carriers = {POD: CarrierPose(T_world_pod)} | ({} if tote is None else {TOTE: tote})
    leaning_share = conditions.reality.leaning_share
    return make_scene(order.contents, cell, request.seed, order.year, on_progress, carriers, leaning_share)


def play_trial(
    request: TrialRequest,
    scene: Scene,
    arms: Sequence[TrialArm],
    on_progress: ProgressObserver = nobody,
    after_attempt: Callable[[], None] = lambda: None,
    watch: Callable[[TrialSnapshot], None] | None = None,
) -> PlayedTrial:
    """Play an order in simulation to its end.

    Args:
        request: The trial.
        scene: The true scene, from ``stowed_scene``.
        arms: All arms, that of the arm that moves first in front.
        on_progress: Called with the number of finished targets.
        after_attempt: Called after every attempt.
        watch: Called after every attempt with the trial so far.

    Returns:
        The trial.
    """
    first, conditions, seed = arms[0], request.conditions, request.seed
    _, reality = standing(conditions.pod_shift, conditions.reality, first.context.cell, seed)
    _, reality = tote_stands(conditions.tote_shift, reality, first.context.cell, seed)
    cells = tuple(arm.context.cell for arm in arms)
    recorder = MotionRecorder(positions_at_start(arms))
    with closing(SimulatedArena(scene, reality, seed, first.parked, recorder)) as arena:
        before, began = arena.picture(), time.perf_counter()
        settings = TrialSettings(
            seed, conditions.noise, reality, stow_rule=conditions.stow_rule, strategy=conditions.strategy,
            perception=conditions.perception, sift=conditions.sift, touches_tote=conditions.touches_tote,
        )  # fmt: skip
        interfaces = interfaces_of(arms, arena)

        def attempted(so_far: Callable[[], TrialResult]) -> None:
            after_attempt()
            if watch is not None:
                record = trial_record(so_far(), request.order_name, time.perf_counter() - began)
                watch(TrialSnapshot(record, recorder.snapshot(), cells))

        result = run_trial(request.order, interfaces, settings, on_progress, attempted)
        record = trial_record(result, request.order_name, time.perf_counter() - began)
        pictures = {"before": before, "after": arena.picture(), **pictures_of_looks(result.looks)}
    motion = motion_values(recorder, cells) | {"record": record_digest(record)}
    return PlayedTrial(result, record, pictures, motion)


def positions_at_start(arms: Sequence[TrialArm]) -> dict[str, float]:
    """Return where all arms stand when a trial begins.

    Args:
        arms: The arms, each with its parked state; one without stands at home.

    Returns:
        Positions in rad or m by joint, those of the tools included.
    """
    found: dict[str, float] = {}
    for arm in arms:
        robot, state = arm.context.cell.robot, arm.parked or arm.context.cell.home
        found |= joint_positions(robot, state.q, state.tool_state)
    return found
