"""Retracing of a motion that stopped: back along its path, or on to its release.

The path that a robot just followed is the shortest proven way to safety as long as nothing has moved, and the
verifier checks whether it has.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from pickcli.cell.robot import Limits, Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import LimitError, NoPlanError, Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.method_choice import grasp_method
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.grip_load import carried_load
from pickcli.scene.scene import HeldItem, PlacedItem, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.stopping_trajectory import resume

SAMPLE_TIME = 1e-3  # s between samples by which times of two trajectories along one path are matched
LEAST_WAY = 1e-3  # joint units; a shorter way counts as no motion

# Kind of each segment when it is traversed backwards with the empty tool.
_BACKWARDS = {
    SegmentKind.PREAPPROACH: SegmentKind.RETREAT,
    SegmentKind.APPROACH: SegmentKind.RETREAT,
    SegmentKind.CONTACT: SegmentKind.DEPART,
    SegmentKind.PUSH: SegmentKind.RETREAT,
    SegmentKind.LIFT: SegmentKind.RETREAT,
    SegmentKind.TRANSFER: SegmentKind.TRANSIT,
    SegmentKind.INSERT: SegmentKind.RETREAT,
    SegmentKind.PLACE: SegmentKind.RETREAT,
}


class ItemRecovery(StrEnum):
    """Destination of an item that may be in the cup after a stop."""

    ON = "on"  # to where the stopped motion would have released it
    BACK = "back"  # to where it was taken


@dataclass(frozen=True, eq=False)
class StoppedMotion:
    """A plan whose execution stopped.

    Attributes:
        plan: The executed plan.
        path_time: s, time of the plan's trajectory at which the robot came to rest.
    """

    plan: Plan
    path_time: float

    @property
    def taken_at(self) -> float | None:
        """Time in s of the plan's trajectory from which on it carries its item, None if it never does."""
        return next((s.t_start for s in self.plan.segments if s.held is not None), None)

    @property
    def let_go_at(self) -> float | None:
        """Time in s of the plan's trajectory at which it releases its item, None if it never does."""
        held = [s.t_end for s in self.plan.segments if s.held is not None]
        return held[-1] if held else None

    @property
    def holding_state(self) -> ToolState | None:
        """State of the tool that carries the item where the motion stopped, None if it carries none.

        The tool ends a change of its state even if the motion stops during it.
        """
        held = [s for s in self.plan.segments if s.held is not None]
        later = [s.tool_state for s in held if s.t_end > self.path_time and s.tool_state != MOVING]
        return (*later, held[-1].tool_state)[0] if held else None

    @property
    def has_moved(self) -> bool:
        """Whether the robot came to rest away from the start of the motion."""
        if self.path_time < SAMPLE_TIME:
            return False
        return bool(_way(_cut(self.plan.trajectory, 0.0, self.path_time), 0.0)[-1] >= LEAST_WAY)

    def held_item(self, robot: Robot, placed: PlacedItem) -> HeldItem:
        """Return the item that the motion grasped, assuming that it was grasped as planned.

        Args:
            robot: The robot.
            placed: The item as placed when the motion was planned.

        Returns:
            The item, with its pose in the tool frame, which includes the press of the cup.
        """
        assert self.plan.grasp is not None
        T_tip_item = inverse(self.plan.grasp.T_item_tip)
        for segment in self.plan.segments:
            if segment.kind is SegmentKind.CONTACT:
                q = self.plan.trajectory.sample(segment.t_end)
                tip = Arm(robot).tip(np.ravel(q), segment.tool_state)
                T_tip_item = np.asarray(inverse(tip) @ placed.T_world_item)
        return HeldItem(placed.id, placed.item, T_tip_item, placed.noise)


def back_to_start(
    stopped: StoppedMotion, tool_state: ToolState, scene: Scene, limits: Limits, seed: int
) -> Plan | Reason:
    """Plan with the empty tool back along the whole path, to the start of the stopped plan.

    Args:
        stopped: The motion that stopped.
        tool_state: Current state of the tool; fingers that held something were opened since.
        scene: The current scene.
        limits: Limits of the joints.
        seed: Seed recorded in the plan.

    Returns:
        The plan, uncertified, or why there is none.
    """
    where = f"back along {stopped.plan.query}"
    return _retraced(stopped, scene, limits, seed, until=0.0, empty=tool_state, where=where)


def bring_item(
    stopped: StoppedMotion, bringing: ItemRecovery, scene: Scene, limits: Limits, seed: int
) -> Plan:
    """Plan with the item to where it can be released; at the end it is still held, at rest.

    Args:
        stopped: The motion that stopped, presumably while it carried its item, possibly after the planned
            release.
        bringing: To the planned release, or back to where the item was taken.
        scene: The current scene, with the item that the cup holds.
        limits: Limits of the joints.
        seed: Seed recorded in the plan.

    Returns:
        The plan, uncertified.

    Raises:
        NoPlanError: If the motion carries nothing where it stopped, the tool would have to change its state
            on the way, or the cup would not bear the item.
    """
    where = f"{bringing} with the item of {stopped.plan.query}"
    taken, let_go = stopped.taken_at, stopped.let_go_at
    if taken is None or let_go is None or not taken < stopped.path_time:
        raise NoPlanError(where, [Reason("nothing to bring", where, "it is not carried where it stopped")])
    until = let_go if bringing is ItemRecovery.ON else taken
    found = _retraced(stopped, scene, limits, seed, until=until, empty=None, where=where)
    if not isinstance(found, Reason):
        found = _loaded(found, scene)
    if isinstance(found, Reason):
        raise NoPlanError(where, [found])
    return found


def _loaded(plan: Plan, scene: Scene) -> Plan | Reason:
    """Add the load of this motion to the plan; it differs from that of the one that stopped."""
    assert plan.grasp is not None and scene.held is not None
    robot, grasp = scene.cell.robot, plan.grasp
    noise = scene.noise_of(scene.held)
    hold = grasp_method(robot.tool).hold(scene.held.item, grasp.face, scene.held.T_tip_item, noise)
    load = carried_load(Arm(robot), plan.segments[0].tool_state, plan.trajectory, hold)
    if load.ratio > 1.0:
        return Reason("does not hold", plan.query, f"{load}, {load.ratio:.2f} of the limit")
    return replace(plan, grasp=load.of(grasp))


def _retraced(
    stopped: StoppedMotion,
    scene: Scene,
    limits: Limits,
    seed: int,
    *,
    until: float,
    empty: ToolState | None,
    where: str,
) -> Plan | Reason:
    """Plan from rest where the motion stopped to rest at another time of its trajectory, without events.

    empty: state of the tool if it no longer carries anything; None for a tool that still carries its item
    """
    plan, at = stopped.plan, stopped.path_time
    is_back = until < at
    whole = _cut(plan.trajectory, 0.0, max(at, until))
    if is_back:
        whole = _reversed(_cut(plan.trajectory, until, plan.trajectory.duration))
    begin = plan.trajectory.duration - at if is_back else at
    if _way(whole, begin)[-1] < LEAST_WAY:
        return Reason("nothing to do", where, "it stands there already")
    try:
        trajectory = resume(whole, begin, limits).trajectory
    except LimitError as error:
        return Reason("not timed", where, str(error))
    passed = [s for s in plan.segments if (s.t_start < at if is_back else s.t_end > at)]
    passed = [s for s in passed if (s.t_end > until if is_back else s.t_start < until)]
    state = empty or stopped.holding_state
    if empty is None:
        passed = [s for s in passed if not _is_change_stopped_in(s, at)]
        if any(s.tool_state != state for s in passed if s.held is not None):
            return Reason("no way with this state of the tool", where, f"it holds the item, {state}")
    if is_back:
        passed.reverse()
    times_passed = [plan.trajectory.duration - s.t_start if is_back else s.t_end for s in passed]
    held = None if empty is not None else next((s.held for s in plan.segments if s.held is not None), None)
    assert state is not None
    ends = _times(trajectory, whole, begin, times_passed)
    segments = _segments(passed, ends, is_back, held, state, {placed.id for placed in scene.items})
    if not segments:
        return Reason("nothing to do", where, "the way is too short")
    grasp = plan.grasp if empty is None else None
    level = RecoveryLevel.BACKWARDS if is_back else RecoveryLevel.AS_PLANNED
    return Plan(
        query=where, cell_fingerprint=plan.cell_fingerprint, scene_hash=scene_hash(scene), seed=seed,
        segments=segments, trajectory=trajectory, events=(), grasp=grasp, speed_scale=plan.speed_scale,
        recovery=level, arm=plan.arm, others=plan.others,
    )  # fmt: skip


def _is_change_stopped_in(segment: Segment, at: float) -> bool:
    """Whether a motion that stopped at a time stopped while the tool changed its state with the item."""
    is_change = segment.held is not None and segment.tool_state == MOVING
    return is_change and segment.t_start < at < segment.t_end


def _segments(
    passed: Sequence[Segment],
    ends: Sequence[float],
    is_back: bool,
    held: str | None,
    tool_state: ToolState,
    seen: Collection[str],
) -> tuple[Segment, ...]:
    """Return the traversed segments with their new times; those without any duration are left out.

    seen: ids of the items that are perceived. On its way out an item goes on pushing what it was to push
    before; on its way back, which leads down, it pushes nothing.
    """
    carries = held is not None
    segments: list[Segment] = []
    t = 0.0
    for old, end in zip(passed, ends, strict=True):
        if end <= t:
            continue
        kind = old.kind
        if is_back and not carries:
            kind = _BACKWARDS.get(old.kind, old.kind)
        elif is_back and kind is SegmentKind.DEPART:  # an item that was not released is set down again
            kind = SegmentKind.PLACE
        is_off = kind is SegmentKind.DEPART and not segments
        keeps_contact = carries or is_off
        touching = old.touching if keeps_contact else ()
        pushing = tuple(name for name in old.pushing if name in seen) if carries and not is_back else ()
        segments.append(Segment(kind, t, end, tool_state, held, touching, pushing))
        t = end
    return tuple(segments)


def _times(new: Trajectory, whole: Trajectory, begin: float, times_passed: Sequence[float]) -> list[float]:
    """Return when ``new``, which follows ``whole`` from ``begin``, passes its states at ``times_passed``.

    Both follow one path, so the path length identifies the positions; the last time is the end.
    """
    there = _way(whole, begin)
    old_times = np.linspace(begin, whole.duration, len(there))
    here = _way(new, 0.0)
    here *= there[-1] / max(here[-1], 1e-12)
    new_times = np.linspace(0.0, new.duration, len(here))
    ways = np.interp(times_passed, old_times, there)
    moves = np.concatenate([[True], np.diff(here) > 1e-12])  # of a rest, the time at which it ends
    times = [float(t) for t in np.interp(ways, here[moves], new_times[moves])]
    return [*times[:-1], new.duration]


def _way(trajectory: Trajectory, begin: float) -> Array:
    """Return (N,) path length in joint units since ``begin``, at even times to the end."""
    n = max(2, int(np.ceil((trajectory.duration - begin) / SAMPLE_TIME)) + 1)
    q = trajectory.sample(np.linspace(begin, trajectory.duration, n))
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])


def _cut(trajectory: Trajectory, t0: float, t1: float) -> Trajectory:
    """Return the part between two times, starting at time 0; an end within a rest is at rest."""
    inner = (trajectory.times > t0 + SAMPLE_TIME / 2) & (trajectory.times < t1 - SAMPLE_TIME / 2)
    times = np.concatenate([[t0], trajectory.times[inner], [t1]])
    q, v, a = (trajectory.sample(times, d) for d in range(3))
    return Trajectory(trajectory.joint_names, times - t0, q, v, a)


def _reversed(trajectory: Trajectory) -> Trajectory:
    """Reverse a trajectory in time."""
    return replace(
        trajectory,
        times=trajectory.duration - trajectory.times[::-1],
        positions=trajectory.positions[::-1],
        velocities=-trajectory.velocities[::-1],
        accelerations=trajectory.accelerations[::-1],
    )
