"""What plans, verifies and executes the attempts of a trial, with a clock and eyes.

A runner knows what a robot could know: what it perceives when it looks (which takes time), what the tool
measures of its hold and why a motion stopped. Where things truly are is noted beside it for the score, and
decides nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import Failures, NoPlanError
from pickcli.motion.plan import Grasp, GraspKind, Plan
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.trial.certifier import Certifier
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.trial.stow_assignment import StowRule
from pickcli.trial.target_selection import TrialClock
from pickcli.trial.trial_interfaces import ARRIVAL, ExecutionResult, TrialInterfaces
from pickcli.trial.trial_result import Attempt, Outcome


@dataclass(frozen=True)
class TrialSettings:
    """How a trial is played.

    Attributes:
        seed: Every random choice follows from it.
        noise: Bounds of the error of the item poses that are perceived.
        reality: Levels at which the simulated world differs from its model.
        time_limit: s; None for that of the order's year.
        stow_rule: How bins are chosen for what is stowed.
    """

    seed: int = 0
    noise: PoseNoise = DEFAULT_NOISE
    reality: Reality = DEFAULT
    time_limit: float | None = None
    stow_rule: StowRule = StowRule.POINTS


class AttemptRunner:
    """The interfaces of a trial with a clock and eyes.

    Args:
        interfaces: Who plans, verifies and carries out.
        settings: How the trial is played.
        limit: Time limit of the trial, s.
        say: Told what happens now.

    Attributes:
        clock: The clock of the trial.
        n_looks: Number of looks so far.
        has_seen: Whether nothing that was seen last may have moved since.
        stuck: Why the arm was where it could not be brought out of when the time ended, "" if it was not.
        cut_short: What the end of the time left undone although there was a way, "" if nothing.
    """

    def __init__(
        self,
        interfaces: TrialInterfaces,
        settings: TrialSettings,
        limit: float,
        say: Callable[[Attempt, str], None],
    ) -> None:
        self.interfaces, self.settings, self.say = interfaces, settings, say
        self.clock = TrialClock(limit)
        self.n_looks = 0
        self.stuck = self.cut_short = ""
        self.has_seen = False  # nothing that was seen last may have moved since
        self._seen = self.look()

    def scene(self) -> Scene:
        """Give the scene as it was last perceived.

        Looks first where something may have moved since, if there is time for a look.

        Returns:
            The scene as it is seen.
        """
        return self._seen if self.has_seen else self.look_again()

    def look_again(self) -> Scene:
        """Look, if there is time for it.

        Returns:
            The scene as it is seen; what was seen last, if there is no time.
        """
        return self.look() if self.clock.has_time_for(self.settings.reality.look_time) else self._seen

    def look(self) -> Scene:
        """Look at pod and tote, which takes time, and keep what is perceived.

        Returns:
            The scene as it is seen.
        """
        self.wait(self.settings.reality.look_time)
        self.n_looks += 1
        how = self.settings
        self._seen = perceive(self.interfaces.arena.now(), how.noise, how.seed, self.n_looks, how.reality)
        self.has_seen = True
        return self._seen

    @property
    def has_time_to_plan(self) -> bool:
        """Whether one more planning call ends in time."""
        return self.clock.has_time_for(self.clock.charge)

    def has_time_for(self, plan: Plan, afterwards: float = 0.0) -> bool:
        """Tell whether a plan can be carried out in time.

        Args:
            plan: The plan.
            afterwards: s that must be left after it.

        Returns:
            Whether it ends within the limit.
        """
        return self.clock.has_time_for(plan.trajectory.duration + ARRIVAL + afterwards)

    def wait(self, duration: float) -> None:
        """Let time pass.

        Args:
            duration: Simulated s.
        """
        self.interfaces.arena.wait(duration)
        self.clock = self.clock.moved(duration)

    @property
    def arm(self) -> str:
        """Name of the arm that may move, all others being parked; empty where there is only one."""
        return self._seen.cell.arm

    def let_move(self, arm: str) -> None:
        """Let another arm move from now on. What was seen stays seen: a move that parks an arm moves nothing.

        Args:
            arm: Name of the arm.

        Raises:
            InputError: The one that moved does not stand where it is parked.
        """
        cell = self.interfaces.cells[arm]
        self.interfaces.arena.let_move(cell)
        self._seen = replace(self._seen, cell=cell)
        self.has_seen = True

    def charge(self) -> None:
        """Charge one more planning call to the clock."""
        self.clock = self.clock.planned()

    def plan(
        self,
        scene: Scene,
        attempt: Attempt,
        exclude: Sequence[Grasp | GraspKind] = (),
        certifier: Certifier | None = None,
    ) -> Plan:
        """Call planner and verifier, charged to the clock: once, or for one able arm after the other.

        Args:
            scene: The scene as it is seen.
            attempt: What is to be moved, from where and where to, and the arms as they are ranked for it.
            exclude: Grasps and kinds of grasps that are not to be used.
            certifier: Asks the verifier, and keeps what it refuses; None for one of its own.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: There is none that the verifier accepts; with the reasons.
        """
        query, seed = _query(attempt, exclude), self._seed(attempt)
        certifier = certifier or self.certifier()
        if not attempt.arms:
            self.charge()
            return self.interfaces.plan(scene, query, self._start(scene.cell), seed, certifier.within(scene))
        failures = Failures(tuple(arm.reason for arm in attempt.arms if not arm.is_able))
        for arm in attempt.arms:
            if arm.is_able and self.has_time_to_plan:
                self.charge()
                seen = self._seen_by(arm.arm, scene)
                try:
                    return self.interfaces.plan(
                        seen, query, self._start(seen.cell), seed, certifier.within(seen)
                    )
                except NoPlanError as error:
                    failures += error.failures.within(f"arm {arm.arm}")
        raise NoPlanError(f"pick {attempt.item} from {attempt.out_of}", failures)

    def certifier(self) -> Certifier:
        """What asks the verifier for the certificates of one query's plans.

        Returns:
            One that has refused nothing yet.
        """
        return Certifier(self.interfaces.verify)

    def ranked(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Rank the arms for an attempt, if there are several.

        Args:
            attempt: What is to be moved, from where and where to.
            scene: The scene as it is seen.

        Returns:
            The attempt with the arms in the order in which they are to be tried.
        """
        scenes = [self._seen_by(arm, scene) for arm in self.interfaces.cells]
        return replace(attempt, arms=self.interfaces.rank(scenes, _query(attempt), self._seed(attempt)))

    def _seen_by(self, arm: str, scene: Scene) -> Scene:
        """A scene as an arm sees it; the same one where there is only one arm."""
        return replace(scene, cell=self.interfaces.cells[arm]) if self.interfaces.cells else scene

    def _start(self, cell: Cell) -> Start:
        """Where the arm of a cell stands: as measured if it is the one that may move, else parked."""
        if cell.arm == self.arm:
            arena = self.interfaces.arena
            return Start(arena.q, arena.tool_state)
        parked = next(state for state in self._seen.cell.others if state.arm == cell.arm)
        return Start(parked.q, parked.tool_state)

    def _seed(self, attempt: Attempt) -> int:
        names = (attempt.item, attempt.number, *(() if attempt.into == TOTE else (attempt.into,)))
        return derived_seed("plan", self.settings.seed, *names)

    def planned(self, attempt: Attempt, scene: Scene, exclude: Sequence[Grasp | GraspKind] = ()) -> Attempt:
        """Plan an attempt, and have the plan certified.

        Args:
            attempt: What is to be moved, from where and where to.
            scene: The scene as it is seen.
            exclude: Grasps and kinds of grasps that are not to be used.

        Returns:
            The attempt with its certified plan, or with the reason why there is none.
        """
        began, certifier = time.perf_counter(), self.certifier()
        attempt = self.ranked(attempt, scene)
        try:
            attempt = replace(attempt, plan=self.plan(scene, attempt, exclude, certifier))
        except NoPlanError as error:
            outcome = Outcome.REJECTED if certifier.rejected else Outcome.NO_PLAN
            attempt = replace(
                attempt, outcome=outcome, reason=error.summary(), in_the_way=error.in_the_way,
                reasons=error.reasons,
            )  # fmt: skip
        verifying = 1e3 * certifier.seconds
        statistics = {} if attempt.plan is None else dict(attempt.plan.statistics)
        statistics["planning_ms"] = _ms_since(began) - verifying
        statistics |= {"verification_ms": verifying} if verifying else {}
        rejected = (*attempt.rejected, *certifier.rejected)
        return replace(attempt, rejected=rejected, statistics=statistics)

    def certified(self, plan: Plan, scene: Scene, stopped: Trajectory | None = None) -> Plan | str:
        """Ask the verifier for a certificate.

        Args:
            plan: The plan.
            scene: The scene that it was planned in.
            stopped: What a way back after a stop leads along; None for other plans.

        Returns:
            The plan with its certificate, or why the verifier refuses it.
        """
        verdict = self.interfaces.verify(plan, scene, stopped)
        if verdict.certificate is None:
            return NoPlanError(plan.query, verdict.reasons).summary()
        return replace(plan, certificate=verdict.certificate)

    def execute(self, plan: Plan) -> ExecutionResult:
        """Carry out a certified plan; what was seen before is no longer known to be so.

        Args:
            plan: The plan with its certificate.

        Returns:
            The record of the execution.
        """
        return self._timed(self.interfaces.arena.execute(plan))

    def let_go(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Let go where the robot stands.

        Args:
            open_to: State to which fingers open; None for as wide as they go.

        Returns:
            The record of the execution.
        """
        return self._timed(self.interfaces.arena.release(open_to))

    def _timed(self, execution: ExecutionResult) -> ExecutionResult:
        self.clock = self.clock.moved(execution.duration)
        self.has_seen = False
        return execution


def _query(attempt: Attempt, exclude: Sequence[Grasp | GraspKind] = ()) -> PickQuery:
    return PickQuery(attempt.out_of, attempt.item, attempt.into, tuple(exclude))


def _ms_since(began: float) -> float:
    return 1e3 * (time.perf_counter() - began)
