"""Plans, verifies and executes the attempts of a trial, with a clock and perception.

A runner uses only what a robot could know: perceived scenes (perception takes time), the tool's measurements
of its hold, and the causes of stops. True poses are recorded for the score, and influence no decision.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import Failures, NoExtractionError, NoPlanError, Reason
from pickcli.motion.plan import Grasp, GraspKind, Plan
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery
from pickcli.scene.scene import TOTE, Scene
from pickcli.seeds import derived_seed
from pickcli.statics.pushing import pushable
from pickcli.statics.supports import supports_of
from pickcli.trial.camera_motion import bring_cameras
from pickcli.trial.certifier import Certifier
from pickcli.trial.jam_memory import JamMemory
from pickcli.trial.tote_shift import ToteTouches
from pickcli.trial.trial_clock import TrialClock
from pickcli.trial.trial_interfaces import ARRIVAL, ExecutionResult, TrialInterfaces
from pickcli.trial.trial_perception import PerceptionKind, Touched
from pickcli.trial.trial_result import Attempt, Outcome
from pickcli.trial.trial_settings import TrialSettings


class AttemptRunner:
    """Runs attempts through a trial's interfaces, with a clock and perception.

    Args:
        interfaces: Planner, verifier and arena.
        settings: Settings of the trial.
        limit: Time limit of the trial, s.
        say: Called with the attempt and a text when its stage changes.

    Attributes:
        clock: The clock of the trial.
        n_looks: Number of looks so far.
        perception: Makes the perceived scene.
        tote: What touching the tote told; None if it was not touched.
        is_current: Whether the last perceived scene is current: nothing may have moved since the last look.
        stuck: Why the arm could not be brought to a safe place before the end of time, "" if it was.
        cut_short: What the end of time interrupted although it was possible, "" if nothing.
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
        self.is_current = False
        self.perception = settings.perceiving(interfaces.arena.now())
        self.tote: ToteTouches | None = None
        self._touched = Touched()
        self._is_stopped = False  # the arm is where a motion was stopped, and not where one was to end
        self._jams = JamMemory()
        self._seen = self.look()

    def scene(self) -> Scene:
        """Return the scene as last perceived.

        Looks first if something may have moved since, and if there is time.

        Returns:
            The perceived scene.
        """
        if not self.is_current:
            self.look_again()
        return self._seen

    @property
    def last_scene(self) -> Scene:
        """The scene as last perceived, even if something may have moved since."""
        return self._seen

    def look_again(self) -> bool:
        """Look again if there is time.

        Returns:
            Whether there was.
        """
        has_time = self.clock.has_time_for(self.settings.reality.look_time)
        if has_time:
            self.look()
        return has_time

    def look(self) -> Scene:
        """Look at what is seen from where the arm is, then bring the cameras to where there is more to see.

        That takes time. If the tote is to be touched, that comes before the first motion to look. Cameras are
        not moved while the tool may hold something, or the arm is where it was stopped: then places are taken
        to be as they were seen before.

        Returns:
            The perceived scene.
        """
        arena, perception = self.interfaces.arena, self.perception
        self.wait(self.settings.reality.look_time)
        self.n_looks += 1
        self._seen = self._with_tote(perception.look(arena.now(), self.n_looks, self._touched))
        self._touched = Touched()
        if self.settings.touches_tote and self.tote is None:
            self._touch_tote()
        viewpoints = perception.viewpoints()
        if viewpoints and not self._is_stopped and not arena.is_holding():
            reached = bring_cameras(self, viewpoints)
            self._seen = self._with_tote(perception.look_from(arena.now(), self.n_looks, reached))
        self.is_current = True
        return self._seen

    def _touch_tote(self) -> None:
        """Locate the tote by touching it; the clock is charged for its motions and planning calls."""
        seed = derived_seed("touch tote", self.settings.seed)
        self.tote = self.interfaces.locate_tote(self._seen, seed)
        self.clock = self.clock.moved(self.tote.duration)
        for _ in range(self.tote.n_planned):
            self.charge()
        self._seen = self._with_tote(self._seen)

    def _with_tote(self, scene: Scene) -> Scene:
        """A perceived scene with the tote where it was felt: that tells more than the estimate."""
        if self.tote is None:
            return scene
        return replace(scene, carriers={**scene.carriers, TOTE: self.tote.at})

    @property
    def has_time_to_plan(self) -> bool:
        """Whether there is time for one more planning call."""
        return self.clock.has_time_for(self.clock.charge)

    def has_time_for(self, plan: Plan, afterwards: float = 0.0) -> bool:
        """Whether a plan can be carried out in time.

        Args:
            plan: The plan.
            afterwards: s that must be left after it.

        Returns:
            True if it ends within the limit.
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
        """Name of the active arm, all others being parked; empty with a single arm."""
        return self._seen.cell.arm

    def let_move(self, arm: str) -> None:
        """Switch to another arm. The perceived scene stays valid, as parking an arm moves no item.

        Args:
            arm: Name of the arm.

        Raises:
            InputError: The previous arm is not parked.
        """
        cell = self.interfaces.cells[arm]
        self.interfaces.arena.let_move(cell)
        self._seen = replace(self._seen, cell=cell)
        self.is_current = True

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
        """Call planner and verifier, charged to the clock: once, or for each suitable arm until one succeeds.

        If items of the same open box are in the way, they are called again for a plan on which the item may
        push others aside. If some lean on the item, that comes first: friction may lift them along with it.
        Among others between which the item jammed it is not tried again.

        Args:
            scene: The perceived scene.
            attempt: The item, its place and destination, and the ranked arms.
            exclude: Grasps and kinds of grasps to exclude.
            certifier: Calls the verifier and keeps rejected plans; None to create one.

        Returns:
            The plan with its certificate.

        Raises:
            NoExtractionError: No grasp leads the item out of its place, even if it may push others aside.
            NoPlanError: There is no plan that the verifier accepts; with the reasons of both calls.
        """
        query, certifier = _query(attempt, exclude), certifier or self.certifier()
        if not self._may_push(scene, attempt):
            return self._first_plan(scene, attempt, query, certifier)
        pushing, is_leant_on = replace(query, neighbours=Neighbours.PUSH), _is_leant_on(scene, attempt)
        first, second = (pushing, query) if is_leant_on else (query, pushing)
        try:
            return self._first_plan(scene, attempt, first, certifier)
        except NoPlanError as error:
            may_differ = is_leant_on or _is_in_a_heap(scene, attempt, error.in_the_way)
            if not (self.has_time_to_plan and may_differ):
                raise
            failed = error
        try:
            return self._first_plan(scene, attempt, second, certifier)
        except NoPlanError as error:
            avoiding, pushed = (error, failed) if is_leant_on else (failed, error)
            is_stuck = all(isinstance(each, NoExtractionError) for each in (avoiding, pushed))
            error_type = NoExtractionError if is_stuck else NoPlanError
            raise error_type(avoiding.query, avoiding.failures + pushed.failures) from None

    def _may_push(self, scene: Scene, attempt: Attempt) -> bool:
        """Whether the item of an attempt did not jam too often among what it would push aside."""
        if not self._jams.jams or attempt.item not in {placed.id for placed in scene.items}:
            return True
        return self._jams.may_push(attempt.item, pushable(supports_of(scene), attempt.item))

    def _first_plan(self, scene: Scene, attempt: Attempt, query: PickQuery, certifier: Certifier) -> Plan:
        """Return the plan of a query by the first arm that has one.

        Raises NoExtractionError if no arm can take the item out of its place, NoPlanError if none has a plan.
        """
        seed = self._seed(attempt)
        if not attempt.arms:
            self.charge()
            return self.interfaces.plan(scene, query, self._start(scene.cell), seed, certifier.within(scene))
        failures = Failures(tuple(arm.reason for arm in attempt.arms if not arm.is_able))
        error_type: type[NoPlanError] = NoExtractionError
        for arm in attempt.arms:
            if arm.is_able and not self.has_time_to_plan:
                failures += Reason("no time", f"arm {arm.arm}", "no time is left to plan with it")
                error_type = NoPlanError
            elif arm.is_able:
                self.charge()
                seen = self._seen_by(arm.arm, scene)
                try:
                    return self.interfaces.plan(
                        seen, query, self._start(seen.cell), seed, certifier.within(seen)
                    )
                except NoPlanError as error:
                    failures += error.failures.within(f"arm {arm.arm}")
                    error_type = error_type if isinstance(error, NoExtractionError) else NoPlanError
        raise error_type(f"pick {attempt.item} from {attempt.out_of}", failures)

    def certifier(self) -> Certifier:
        """Create a certifier for one query's plans.

        Returns:
            A certifier without rejected plans.
        """
        return Certifier(self.interfaces.verify)

    def ranked(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Rank the arms for an attempt if there are several.

        Args:
            attempt: The item, its place and destination.
            scene: The perceived scene.

        Returns:
            The attempt with the arms in the order in which to try them.
        """
        scenes = [self._seen_by(arm, scene) for arm in self.interfaces.cells]
        return replace(attempt, arms=self.interfaces.rank(scenes, _query(attempt), self._seed(attempt)))

    def _seen_by(self, arm: str, scene: Scene) -> Scene:
        """The scene as seen by an arm; unchanged with a single arm."""
        return replace(scene, cell=self.interfaces.cells[arm]) if self.interfaces.cells else scene

    def _start(self, cell: Cell) -> Start:
        """Start state of a cell's arm: measured for the active arm, parked for others."""
        if cell.arm == self.arm:
            arena = self.interfaces.arena
            return Start(arena.q, arena.tool_state)
        parked = next(state for state in self._seen.cell.others if state.arm == cell.arm)
        return Start(parked.q, parked.tool_state)

    def _seed(self, attempt: Attempt) -> int:
        names = (attempt.item, attempt.number, *(() if attempt.into == TOTE else (attempt.into,)))
        return derived_seed("plan", self.settings.seed, *names)

    def planned(self, attempt: Attempt, scene: Scene, exclude: Sequence[Grasp | GraspKind] = ()) -> Attempt:
        """Plan an attempt and have the plan certified.

        Args:
            attempt: The item, its place and destination.
            scene: The perceived scene.
            exclude: Grasps and kinds of grasps to exclude.

        Returns:
            The attempt with its certified plan, or with the reason for failure.
        """
        began, certifier = time.perf_counter(), self.certifier()
        attempt = self.ranked(attempt, scene)
        try:
            plan = self.plan(scene, attempt, exclude, certifier)
            attempt = replace(attempt, plan=plan, seen=self._seen_by(plan.arm or self.arm, scene))
        except NoPlanError as error:
            outcome = Outcome.REJECTED if certifier.rejected else Outcome.NO_PLAN
            self._touched = self._touched.doubting(attempt.out_of)
            attempt = replace(
                attempt, outcome=outcome, reason=error.summary(), in_the_way=error.in_the_way,
                reasons=error.reasons, has_way_out=not isinstance(error, NoExtractionError),
            )  # fmt: skip
        verifying = 1e3 * certifier.seconds
        statistics = {} if attempt.plan is None else dict(attempt.plan.statistics)
        statistics["planning_ms"] = _ms_since(began) - verifying
        statistics |= {"verification_ms": verifying} if verifying else {}
        rejected = (*attempt.rejected, *certifier.rejected)
        return replace(attempt, rejected=rejected, statistics=statistics)

    def toppling(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Plan to topple the item of an attempt, and have the plan certified.

        Cups push: of several arms those with a cup are tried, the active one first.

        Args:
            attempt: The item and its place.
            scene: The perceived scene.

        Returns:
            The attempt with its certified plan, or with the reason for failure.
        """
        certifier = self.certifier()
        try:
            plan = self._first_push(scene, attempt, certifier)
        except NoPlanError as error:
            outcome = Outcome.REJECTED if certifier.rejected else Outcome.NO_PLAN
            return replace(
                attempt, outcome=outcome, reason=error.summary(), in_the_way=error.in_the_way,
                reasons=error.reasons, rejected=tuple(certifier.rejected),
            )  # fmt: skip
        seen = self._seen_by(plan.arm or self.arm, scene)
        return replace(attempt, plan=plan, seen=seen, statistics=dict(plan.statistics))

    def _first_push(self, scene: Scene, attempt: Attempt, certifier: Certifier) -> Plan:
        """Return the plan to topple an item by the first arm that has one. Raises NoPlanError if none has."""
        query, failures = TopplingQuery(attempt.out_of, attempt.item), Failures()
        cells = self.interfaces.cells
        pushing = [arm for arm, cell in cells.items() if cell.robot.tool.grip.holds_by_vacuum]
        for arm in sorted(pushing, key=lambda arm: arm != self.arm) or [self.arm]:
            if failures.parts and not self.has_time_to_plan:
                break
            self.charge()
            seen = self._seen_by(arm, scene)
            start = self._start(seen.cell)
            try:
                return self.interfaces.topple(seen, query, start, self._seed(attempt), certifier.within(seen))
            except NoPlanError as error:
                failures += error.failures
        raise NoPlanError(f"topple {attempt.item} in {attempt.out_of}", failures)

    def certified(self, plan: Plan, scene: Scene, stopped: Trajectory | None = None) -> Plan | Failures:
        """Request a certificate from the verifier.

        Args:
            plan: The plan.
            scene: The scene for which it was planned.
            stopped: Trajectory along which a recovery leads back after a stop; None for other plans.

        Returns:
            The plan with its certificate, or every reason why the verifier rejects it.
        """
        verdict = self.interfaces.verify(plan, scene, stopped)
        if verdict.certificate is None:
            return Failures(verdict.reasons)
        return replace(plan, certificate=verdict.certificate)

    def execute(self, plan: Plan) -> ExecutionResult:
        """Carry out a certified plan; the perceived scene is outdated afterwards.

        Args:
            plan: The plan with its certificate.

        Returns:
            The record of the execution.
        """
        execution = self._timed(self.interfaces.arena.execute(plan))
        if self.settings.perception is PerceptionKind.CAMERA:
            has_left = execution.stop_cause is not None and execution.stop_cause.has_left_item
            self._touched = self._touched.also(plan, self._seen.cell, self._seen, has_left)
        self._is_stopped = bool(execution.stopped)
        self._jams.note(plan, execution)
        return execution

    def let_go(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Release the item at the present configuration.

        Args:
            open_to: State to which fingers open; None for the widest.

        Returns:
            The record of the execution.
        """
        return self._timed(self.interfaces.arena.release(open_to))

    def _timed(self, execution: ExecutionResult) -> ExecutionResult:
        self.clock = self.clock.moved(execution.duration)
        self.is_current = False
        return execution


def _is_in_a_heap(scene: Scene, attempt: Attempt, in_the_way: Collection[str]) -> bool:
    """Whether any of the items that are in the way lies in the same open box as the item of an attempt."""
    place = scene.cell.places.get(attempt.out_of)
    if place is None or not place.is_open_box:
        return False
    return any(placed.id in in_the_way for placed in scene.in_location(place.name))


def _is_leant_on(scene: Scene, attempt: Attempt) -> bool:
    """Whether items of the same open box lean on the item of an attempt, and slump when it is lifted."""
    if attempt.item not in {placed.id for placed in scene.items}:
        return False
    supports = supports_of(scene)
    touching = {contact.b for contact in supports.graph.touching[attempt.item]}
    return not touching.isdisjoint(supports.slumping(attempt.item))


def _query(attempt: Attempt, exclude: Sequence[Grasp | GraspKind] = ()) -> PickQuery:
    return PickQuery(attempt.out_of, attempt.item, attempt.into, tuple(exclude))


def _ms_since(began: float) -> float:
    return 1e3 * (time.perf_counter() - began)
