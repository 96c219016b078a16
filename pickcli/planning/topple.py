"""``plan_topple``: turn an item that stands on edge in an open box or a bin over, with the empty tool.

The tool comes straight down beside the item and pushes its upper part, or presses on its upper side and turns
with it, until the item falls by itself, and leaves straight up. An item that no push turns over onto a face
that seals is pushed off the items that it lies on. In a bin the tool comes in level and presses on the upper
side of what turns over to a side. What is pushed may be anywhere in the box afterwards: take
another look before the next plan.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, pairwise

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.cell.place import Place
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.collision.stage_contacts import while_toppling
from pickcli.errors import Failures, NoPlanError, Reason, UnknownNameError
from pickcli.geometry import Array
from pickcli.motion.plan import Certify, Plan
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.stitching import stitch_runs
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.planning.sliding_poses import poses_behind
from pickcli.planning.start_state import Start
from pickcli.planning.toppling_poses import PushPoses, poses_from_above, poses_from_beside
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_seed
from pickcli.statics.sliding import Slide, slides
from pickcli.statics.supports import supports_of
from pickcli.statics.toppling import Topple, loaded_on, topples

SLIPS = "it slips off below the tool"
TOO_LOW = "it is too low for the cup, or begins too far behind where it is met"
# m/s of a push that turns an item over, and of one that moves it off: the rigid side of the cup knocks at
# what jams with a force in proportion to that.
TOPPLE_SPEED, SLIDE_SPEED = 0.03, 0.02
LED_IN = np.cos(np.radians(20.0))  # of the angle between lance and way in, in a bin
N_SEEDS = 12  # random seeds of inverse kinematics


@dataclass(frozen=True)
class TopplingQuery:
    """An item that is to be toppled.

    Attributes:
        out_of: The open box or bin in which it stands.
        item: Its instance id or name.
    """

    out_of: str
    item: str


def plan_topple(
    context: PlanningContext,
    scene: Scene,
    query: TopplingQuery,
    start: Start,
    seed: int = 0,
    recorder: ExperienceRecorder | None = None,
    certify: Certify | None = None,
) -> Plan:
    """Plan one push that topples an item so that a face that seals comes on top, or moves it off others.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived; their noise bounds inflate the shapes.
        query: The item.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        recorder: Records experience of coarse queries; None discards it.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified.

    Returns:
        The plan; it ends above the box.

    Raises:
        UnknownNameError: If the place or the item does not exist.
        NoPlanError: If no push topples the item or moves it off others, or none can be carried out; with
            every reason.
    """
    began = time.perf_counter()
    if query.out_of not in scene.cell.places:
        raise UnknownNameError("place", query.out_of, list(scene.cell.places))
    place, item = scene.cell.places[query.out_of], scene.find(query.item, query.out_of).id
    label = f"topple {item} in {place.name}"
    tool = context.cell.robot.tool
    is_above = place.access.is_from_above
    if (state := tool.pushing_state if is_above else tool.rolling_state) is None:
        how = "in line with its lance pushes" if is_above else "across its lance turns items over in a bin"
        raise NoPlanError(
            label, [Reason("cannot be toppled", item, f"only a cup {how}, not a {tool.grip.kind}")]
        )
    standing = context.checker_for(scene, Mode(start.tool_state))
    if not standing.is_valid(start.q):
        raise NoPlanError(label, [standing.explain(start.q).at("start")])
    failures = Failures()
    for push in _pushes(scene, item):
        if isinstance(push, Reason):
            failures += push
            continue
        planner = _PushPlanner(context, scene, place, push, state, seed)
        named = f"push {item} off others in {place.name}" if isinstance(push, Slide) else label
        plan = planner.plan(named, start, recorder or ExperienceRecorder())
        if isinstance(plan, Plan):
            plan = plan.with_statistics(planning_ms=1e3 * (time.perf_counter() - began))
            certified = plan if certify is None else certify(plan)
            if not isinstance(certified, Failures):
                return certified
            plan = certified
        failures += plan
    raise NoPlanError(label, failures)


def _pushes(scene: Scene, item: str) -> Iterator[Topple | Slide | Reason]:
    """Yield the pushes that topple an item, then those that move it off others, or why there are none.

    In a bin none is moved off others: there is no room behind it.
    """
    supports = supports_of(scene)
    kinds = (topples, slides) if supports.rim(item) is not None else (topples,)
    for found in (kind(supports, item) for kind in kinds):
        yield from (found,) if isinstance(found, Reason) else found


@dataclass(frozen=True, eq=False)
class _PushPlanner:
    """Plans the motion of one push.

    Attributes:
        context: The cell, its models and its precomputed files.
        scene: The planning scene.
        place: The box.
        push: The push.
        state: State of the tool while it pushes.
        seed: Seed of all random choices.
    """

    context: PlanningContext
    scene: Scene
    place: Place
    push: Topple | Slide
    state: ToolState
    seed: int

    def plan(self, label: str, start: Start, recorder: ExperienceRecorder) -> Plan | Failures:
        """Return the fastest of the first few motions that the arm can follow, or why there is none."""
        found: list[tuple[MotionSegment, ...]] = []
        failures = Failures()
        for poses in self._poses():
            lines = self._lines(poses)
            if isinstance(lines, Failures):
                failures += lines
                continue
            found.append(lines)
            if len(found) == self.context.settings.wanted:
                break
        if not found:
            why = TOO_LOW if isinstance(self.push, Slide) else self.push.sliding or SLIPS
            return failures if failures.parts else Failures.of(Reason("no push", self.where, why))
        return self._reached(found, label, start, recorder)

    def _poses(self) -> Iterator[PushPoses]:
        """Return the poses of the tool at the push, the preferred first."""
        if isinstance(self.push, Slide):
            return poses_behind(self.scene, self.place, self.push)
        from_above = poses_from_above(self.scene, self.place, self.push)
        if not self.place.access.is_from_above:
            return (poses for poses in from_above if self._is_led_in(poses.first))
        return chain(poses_from_beside(self.scene, self.place, self.push), from_above)

    def _is_led_in(self, T_world_tip: Array) -> bool:
        """Whether the lance points into the bin at a pose (4, 4) of the tool."""
        inwards = self.scene.T_world_place(self.place)[:3, 0]
        lance = T_world_tip[:3, :3] @ self.context.cell.robot.tool.lance_axis(self.state)
        return bool(inwards @ lance >= LED_IN)

    @property
    def where(self) -> str:
        """Name of the push in reasons."""
        if isinstance(self.push, Slide):
            x, y, _ = self.push.direction
            return f"push towards {np.degrees(np.arctan2(y, x)):.0f} degrees"
        return f"push on face {self.push.face}"

    @property
    def pushed(self) -> frozenset[str]:
        """Ids of the item and of all that lies on it."""
        return frozenset({self.push.item, *loaded_on(supports_of(self.scene), self.push.item)})

    def _lines(self, poses: PushPoses) -> tuple[MotionSegment, ...] | Failures:
        """Follow the way in and the push, from the first configuration beside the item that allows it."""
        settings = self.context.settings
        solutions = self.context.arm.solve(poses.first, self.state, self._seeds())
        if len(solutions) == 0:
            x, y, z = poses.first[:3, 3]
            at = f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
            return Failures.of(Reason("no inverse-kinematics solution", self.where, at))
        failures = Failures()
        for q in solutions[: settings.solutions_per_grasp]:
            lines = self._lines_from(q, poses)
            if not isinstance(lines, Failures):
                return lines
            failures += lines
        return failures

    def _lines_from(self, q: Array, poses: PushPoses) -> tuple[MotionSegment, ...] | Failures:
        """Follow the way in, the push and the way out from a configuration (n,) at the end of the way in."""
        kind = SegmentKind
        down = self._followed(kind.PREAPPROACH, (poses.first, poses.above), q, self._free)
        if isinstance(down, Failures):
            return down
        lines = [down.backwards(kind.PREAPPROACH)]
        ends = (poses.first, *poses.pushes, *poses.out)
        kinds = (*(kind.PUSH for _ in poses.pushes), *(kind.DEPART for _ in poses.out))
        for of, line in zip(kinds, pairwise(ends), strict=True):
            followed = self._followed(of, line, lines[-1].end, self._pushing)
            if isinstance(followed, Failures):
                return followed
            lines.append(followed)
        return tuple(lines)

    def _followed(
        self, kind: SegmentKind, ends: tuple[Array, Array], q: Array, mode: Mode
    ) -> MotionSegment | Failures:
        """Follow a line between two poses (4, 4), from the configuration (n,) at the first."""
        settings = self.context.settings
        speeds = {
            SegmentKind.PREAPPROACH: settings.preapproach_speed,
            SegmentKind.PUSH: SLIDE_SPEED if isinstance(self.push, Slide) else TOPPLE_SPEED,
        }
        speed = speeds.get(kind, settings.push_speed)
        limits = SegmentLimits(max_tool_speed=speed)
        if np.allclose(*ends):
            return MotionSegment(kind, np.stack([q, q]), limits, mode=mode)
        checker, where = self.context.checker_for(self.scene, mode), f"{self.where}, {kind}"
        line = follow_line(self.context.arm, checker, *ends, self.state, q, where)
        return line if isinstance(line, Failures) else MotionSegment(kind, line, limits, mode=mode)

    def _reached(
        self,
        motions: list[tuple[MotionSegment, ...]],
        label: str,
        start: Start,
        recorder: ExperienceRecorder,
    ) -> Plan | Failures:
        """Plan the transit to the fastest of some motions, and time all of it."""
        context, scene = self.context, self.scene
        mode = Mode(self.state if self.state == start.tool_state else MOVING, reserve=COARSE_RESERVE)
        if not context.checker_for(scene, mode).is_valid(start.q):
            mode = replace(mode, reserve=0.0)
        goals = np.stack([motion[0].start for motion in motions])
        extra = [sum(estimated_duration(context.space, s.waypoints) for s in motion) for motion in motions]
        seed = derived_seed(self.seed, "transit", self.push.item, self.where)
        checker = context.checker_for(scene, mode)
        coarse = plan_coarse(context, checker, start.q, goals, extra, seed, "transit")
        if isinstance(coarse, Failures):
            return coarse
        recorder.record(coarse.experience)
        inward, *after = motions[coarse.goal]
        pushes = [segment for segment in after if segment.kind is SegmentKind.PUSH]
        out = [segment for segment in after if segment.kind is SegmentKind.DEPART]
        transit = coarse.segment(SegmentKind.TRANSIT, replace(mode, reserve=0.0))
        runs = ([transit, inward, *pushes], out)
        return stitch_runs(context, scene, runs, label, self.seed, context.settings.push_rest)

    @property
    def _free(self) -> Mode:
        return Mode(self.state)

    @property
    def _pushing(self) -> Mode:
        return Mode(self.state, contacts=while_toppling(self.pushed))

    def _seeds(self) -> Array:
        """Return configurations (N, n) over the box, and random ones."""
        fronts = self.context.configurations_at(self.place)
        rng = np.random.default_rng(derived_seed(self.seed, "topple", self.push.item))
        drawn = self.context.arm.random_seeds(rng, N_SEEDS)
        return np.vstack([*(q[None] for q in fronts), drawn])
