"""Everything that a trial of a stream depends on."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import PoseNoise
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.stream_trials.belt_camera import BeltCamera
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.trial.pose_noise import DEFAULT_NOISE

SPEED_ERROR = 0.0008  # m/s, standard deviation of the PR2's estimate of its belt's speed, here as a bound


@dataclass(frozen=True, eq=False)
class StreamTrialRequest:
    """Everything that a trial of a stream depends on.

    Attributes:
        stream: The true stream.
        noise: Bounds of the errors of perceived poses.
        speed_error: m/s, bound of the error of the perceived speed.
        camera: Camera by whose tracks the items are known, instead of by poses with these errors; None for
            those.
        reality: Levels of the deviations of the simulated world from its model.
        rule: Where items are met, and by which arm.
        seed: Seed of all random choices.
    """

    stream: ItemStream
    noise: PoseNoise = DEFAULT_NOISE
    speed_error: float = SPEED_ERROR
    camera: BeltCamera | None = None
    reality: Reality = DEFAULT
    rule: StreamRule = StreamRule.EARLIEST
    seed: int = 0
