"""Settings of a trial: its seed, how the world and perception deviate from the model, and the strategy."""

from __future__ import annotations

from dataclasses import dataclass, field

from pickcli.perception.textures.sift_views import SiftRule
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.strategy.strategy_file import DEFAULT_STRATEGY, load_strategy
from pickcli.strategy.strategy_tree import Strategy
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.stow_assignment import StowRule
from pickcli.trial.trial_perception import BoundedErrors, Perception, PerceptionKind, true_poses


@dataclass(frozen=True)
class TrialSettings:
    """Settings of a trial.

    Attributes:
        seed: Seed of all random choices.
        noise: Bounds of the errors of perceived item poses.
        reality: Levels of the deviations of the simulated world from its model.
        time_limit: s; None for that of the order's year.
        stow_rule: Rule by which bins are chosen for stowed items.
        strategy: Decides what is tried next.
        perception: Source of the perceived scene.
        sift: For which items cameras look for prints, and how.
        touches_tote: Whether the robot begins by touching the tote to locate it.
    """

    seed: int = 0
    noise: PoseNoise = DEFAULT_NOISE
    reality: Reality = DEFAULT
    time_limit: float | None = None
    stow_rule: StowRule = StowRule.POINTS
    strategy: Strategy = field(default_factory=lambda: load_strategy(DEFAULT_STRATEGY))
    perception: PerceptionKind = PerceptionKind.NOISE
    sift: SiftRule = SiftRule.NONE
    touches_tote: bool = False

    def perceiving(self, true: Scene) -> Perception:
        """Return what makes the perceived scene.

        Args:
            true: The true scene at the start.

        Returns:
            The perception.

        Raises:
            InputError: A place is to be seen by a camera, and none sees it; or prints are looked for, and
                OpenCV is not installed.
        """
        if self.perception is PerceptionKind.TRUTH:
            return true_poses(self.seed)
        bounded = BoundedErrors(self.noise, self.seed, self.reality)
        if self.perception is PerceptionKind.NOISE:
            return bounded
        # They render, which other trials need not load.
        from pickcli.perception.items.routing import PrintSearch
        from pickcli.trial.camera_looks import CameraLooks
        from pickcli.trial.simulated_cameras import PRINTS_OF_TRIALS

        prints = PrintSearch(self.sift, PRINTS_OF_TRIALS)
        return CameraLooks(true, bounded, self.reality.hand_eye, self.reality.deformed_looks, prints)
