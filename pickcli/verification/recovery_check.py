"""Check the permissions of recovery motions, by the level that they state. See docs/recovery.md.

A stopped robot may be nearer to something than the clearance, or in contact with it. From the level
``opening`` on, pairs that are near at the start are not refused but followed one by one: each may open, and
none may come nearer again than the largest distance that it had. On the level ``opening`` a cup has come free
of them at the end of its first line: a lip that is bent against a body would slide along it. Such a motion
must lead out of the pod, in cells without one out of the place, or back along the motion that stopped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.fcl_solids import distances_to_boxes
from pickcli.verification.forward_kinematics import tip_poses
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.quintic import positions_at
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures
from pickcli.verification.straightness_check import every_millisecond

CLOSING_TOLERANCE = 0.001  # m that a pair may come nearer: resolution between two states
SLOW_SHARE = 0.1  # of the velocity limits
JOG_WAY = 0.03  # m that any link and the tool may move in a jog
MAX_INWARD_DEPTH = 0.015  # m deeper into pod or place than before: needed to come free of a lip
OFF_PATH = 0.005  # rad or m, of any joint, between a backward motion and the motion that stopped
LEFT_OUT = 4 * OFF_PATH  # rad or m of that motion that may be skipped at once, at a reversal
PATH_WAY = OFF_PATH / 10  # rad or m between samples of that motion; samples are at least a millisecond apart
IGNORES_ERROR = (RecoveryLevel.SLOWLY, RecoveryLevel.JOG)


@dataclass(frozen=True)
class Opening:
    """Pairs that were near at the start of a recovery motion.

    Attributes:
        pairs: Names (part, fixture), of each segment, that are followed there and may be near; () if no pair
            is followed.
        reasons: Faults of their motion.
    """

    pairs: tuple[frozenset[tuple[str, str]], ...] = ()
    reasons: tuple[Reason, ...] = ()


def needed_clearance(plan: Plan, scene: Scene) -> float:
    """Return the clearance that pairs which are not near at the start keep, on top of pose errors.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        m.
    """
    return 0.0 if plan.recovery in IGNORES_ERROR else scene.cell.clearance


def check_recovery(
    plan: Plan, scene: Scene, states: States, velocity: float, opening: Opening, stopped: Trajectory | None
) -> tuple[Reason, ...]:
    """Check that a plan keeps to its level of recovery, except for its clearances.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: The motion's states.
        velocity: Largest ratio to a velocity limit.
        opening: Pairs that are near at the start.
        stopped: The motion that stopped, which a backward motion follows; None if unknown.

    Returns:
        The faults; () for a plan that is not a recovery motion.
    """
    if plan.recovery is None:
        return ()
    return (*_claims(plan, scene, states, velocity), *_leads(plan, scene, states, opening, stopped))


def _leads(
    plan: Plan, scene: Scene, states: States, opening: Opening, stopped: Trajectory | None
) -> Iterator[Reason]:
    """Check that the motion leads out of pod or place, or back, in order, along the motion that stopped."""
    where = f"recovery {plan.recovery}"
    if plan.recovery is RecoveryLevel.AS_PLANNED:
        return
    if plan.recovery is RecoveryLevel.BACKWARDS and stopped is not None:
        if (strayed := _strayed(states.Q, stopped)) is not None:
            i, how = strayed
            yield Reason("not back the way it came", where, f"at {states.times[i]:.3f} s {how}")
        return
    tips = tip_poses(scene.cell.robot, states.links, plan.segments[0].tool_state)
    depths, around = _depths(scene, tips[:, :3, 3])
    if plan.recovery in IGNORES_ERROR and depths[0] <= 0.0 and not any(opening.pairs):
        yield Reason("not a way out", where, f"it begins outside of the {around}, and near to nothing")
    deeper = depths - np.minimum.accumulate(depths)
    if (worst := float(deeper.max())) > MAX_INWARD_DEPTH:
        at = f"{worst * 1e3:.0f} mm at {states.times[int(np.argmax(deeper))]:.3f} s"
        most = f"at most {MAX_INWARD_DEPTH * 1e3:.0f} mm are allowed"
        detail = f"the tool goes deeper into the {around} again, {at}; {most}"
        if plan.recovery is RecoveryLevel.BACKWARDS:
            detail += ", unless the motion that stopped is known (apc verify --stopped)"
        yield Reason(f"leads into the {around}", where, detail)


def _depths(scene: Scene, points: Array) -> tuple[Array, str]:
    """Return how deep points (N, 3) are in the pod, (N,) m, 0 outside; and the word for what they are in.

    In a cell without a pod it is the place in which a point is deepest. A point is in a place if it is behind
    the mouth, and inside of its edges as seen along the way in.
    """
    if scene.cell.pod.bins:
        T_pod_world = inverse(scene.T_world_pod)
        return np.maximum(0.0, (points @ T_pod_world[:3, :3].T + T_pod_world[:3, 3])[:, 0]), "pod"
    depths = np.zeros(len(points))
    for place in scene.cell.places.values():
        T_mouth_world = inverse(scene.T_world_place(place) @ place.access.T_place_mouth)
        x, y, z = T_mouth_world[:3, :3] @ points.T + T_mouth_world[:3, 3:]
        is_in = (np.abs(y) <= place.access.width / 2) & (np.abs(z) <= place.access.height / 2)
        depths = np.maximum(depths, np.where(is_in, x, 0.0))
    return depths, "place"


def _strayed(Q: Array, stopped: Trajectory) -> tuple[int, str] | None:
    """Find the first of the configurations Q (N, n) that does not go backwards along a trajectory, and why.

    The trajectory may pass the same place more than once, so the possible positions on it are kept as a set:
    all samples that are near enough, not later than a possible position of the configuration before, and
    separated from it by no more of the motion than may be skipped.
    """
    path = positions_at(stopped, every_millisecond(0.0, stopped.duration))
    gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path, axis=0)).max(axis=1))])
    kept = np.unique(np.append(np.unique(gone // PATH_WAY, return_index=True)[1], len(path) - 1))
    path, gone = path[kept], gone[kept]
    steps = np.abs(np.diff(Q, axis=0, prepend=Q[:1])).max(axis=1)
    tree, may_be_at = cKDTree(path), np.arange(len(path))
    for i, q in enumerate(Q):
        near = np.array(tree.query_ball_point(q, OFF_PATH, p=np.inf, return_sorted=True), dtype=np.intp)
        if len(near) == 0:
            off = float(tree.query(q, p=np.inf)[0])
            most = f"at most {OFF_PATH} are allowed"
            return i, f"a joint is {off:.4f} rad or m off the motion that stopped, {most}"
        before = may_be_at[np.minimum(np.searchsorted(may_be_at, near), len(may_be_at) - 1)]
        is_next = (before >= near) & (gone[before] - gone[near] <= steps[i] + LEFT_OUT)
        if not is_next.any():
            return i, "it does not go on backwards along the motion that stopped"
        may_be_at = near[is_next]
    return None


def _claims(plan: Plan, scene: Scene, states: States, velocity: float) -> Iterator[Reason]:
    assert plan.recovery is not None
    where = f"recovery {plan.recovery}"
    if plan.events or any(segment.kind is SegmentKind.CONTACT for segment in plan.segments):
        yield Reason("not a way out", where, "it switches devices or takes an item")
    if plan.recovery in IGNORES_ERROR and any(segment.held is not None for segment in plan.segments):
        yield Reason("not a way out", where, "it carries an item")
    if plan.recovery in IGNORES_ERROR and velocity > SLOW_SHARE * (1.0 + 1e-6):
        yield Reason(
            "not slow", where, f"{velocity:.3f} of the velocity limit, at most {SLOW_SHARE} is allowed"
        )
    if plan.recovery is RecoveryLevel.JOG and (way := _longest_way(plan, scene, states)) > JOG_WAY:
        yield Reason(
            "not a jog", where, f"{way * 1e3:.1f} mm of way, at most {JOG_WAY * 1e3:.0f} are allowed"
        )


def _longest_way(plan: Plan, scene: Scene, states: States) -> float:
    """Return the path length in m of the link origin, or of the tool, that travels farthest."""
    tips = tip_poses(scene.cell.robot, states.links, plan.segments[0].tool_state)
    points = np.concatenate([states.links[:, :, :3, 3], tips[None, :, :3, 3]])
    return float(np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1).max())


def check_opening(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: PlanFixtures,
    exempt: Sequence[Exemptions],
) -> Opening:  # fmt: skip
    """Follow the pairs that are near at the start of a recovery motion to the end of the motion.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: The motion's states.
        moving: Parts that move in each segment.
        world: Static solids of each segment.
        exempt: Exemptions of each segment.

    Returns:
        The pairs, and the faults of their motion.
    """
    if plan.recovery in (None, RecoveryLevel.AS_PLANNED):
        return Opening()
    clearance = scene.cell.clearance
    there = [each for each in world.of(0) if not each.is_wall]
    near = _near_at_start(states, moving[0], there, clearance)
    # Entering an item by no more than its pose error pushes it, at worst, by that much.
    exact = frozenset(placed.id for placed in scene.items) if plan.recovery in IGNORES_ERROR else frozenset()
    # A way back may come nearer to what the motion that stopped was planned to touch: ``check_touch`` bounds
    # the depth. On other levels a cup comes free of what it touches.
    tool = {part.name for part in moving[0] if part.is_cup or part.is_held}
    touched = {(name, other) for name in tool for other in exempt[0].touching}
    touched = touched if plan.recovery is RecoveryLevel.BACKWARDS else set()
    pairs = {pair for pair in near if frozenset(pair) not in exempt[0].allowed} - touched
    free_after = tool if plan.recovery is RecoveryLevel.OPENING else frozenset()
    later = frozenset(pair for pair in pairs if pair[0] not in free_after)
    followed = (frozenset(pairs), *[later] * (len(plan.segments) - 1))
    nearest = dict.fromkeys(sorted(pairs), -np.inf)
    reasons: dict[tuple[str, str], Reason] = {}
    for k, segment in enumerate(plan.segments):
        first, last = states.between(segment.t_start, segment.t_end)
        outer = (each for each in world.of(k) if not each.is_wall)  # walls of a hollow keep the clearance
        fixtures = {f.name: replace(f, slack=0.0) if f.name in exact else f for f in outer}
        for pair in sorted(followed[k]):
            parts = [part for part in moving[k] if part.name == pair[0]]
            if pair[1] in fixtures and parts and pair not in reasons:
                found = _followed(
                    states, parts, fixtures[pair[1]], range(first, last + 1), clearance, nearest
                )
                reasons.update({pair: found.at(f"segment {k} ({segment.kind})")} if found else {})
    return Opening(followed, tuple(reasons.values()))


def _followed(
    states: States, parts: Sequence[Part], fixture: Fixture, at: range, clearance: float,
    nearest: dict[tuple[str, str], float],
) -> Reason | None:  # fmt: skip
    """Follow a pair over some states; ``nearest``: its largest separation so far, up to the clearance."""
    pair = parts[0].name, fixture.name
    travel = states.travel @ np.max([part.reach for part in parts], axis=0)
    i = at.start
    while i < at.stop:
        separation = min(_separation(states, part, fixture, i) for part in parts)
        if separation < nearest[pair] - CLOSING_TOLERANCE:
            apart, before = 1e3 * separation, 1e3 * nearest[pair]
            what = (
                f"{pair[0]} and {pair[1]} at {states.times[i]:.3f} s, {apart:.1f} mm apart after {before:.1f}"
            )
            return Reason("closes again", "", what)
        nearest[pair] = max(nearest[pair], min(separation, clearance))
        # Skip states up to which the two cannot have come near again.
        free = travel[i] + max(0.0, separation - clearance)
        i = max(i + 1, int(np.searchsorted(travel, free, side="right")) - 1)
    return None


def _near_at_start(
    states: States, parts: Sequence[Part], fixtures: Sequence[Fixture], most: float
) -> Iterator[tuple[str, str]]:
    """Yield pairs, by name, that are at most a distance in m apart at the first state.

    Spheres around the parts select the pairs that are measured.
    """
    # In an empty world there are no rows, but the arrays need their shapes.
    T = np.array([fixture.T_world_shape for fixture in fixtures]).reshape(-1, 4, 4)
    half = np.array([fixture.shape.extents for fixture in fixtures]).reshape(-1, 3) / 2
    slack = np.array([fixture.slack for fixture in fixtures])
    for part in parts:
        T_part = states.links[part.link, 0] @ part.T_link_shape
        centers = part.spheres.centers @ T_part[:3, :3].T + T_part[:3, 3]
        apart = distances_to_boxes(centers, T, half).min(axis=0) - part.spheres.radius - part.slack - slack
        for b in np.flatnonzero(apart <= most).tolist():
            if _separation(states, part, fixtures[b], 0) <= most:
                yield part.name, fixtures[b].name


def _separation(states: States, part: Part, fixture: Fixture, i: int) -> float:
    """Return the distance in m of two solids at state i, or minus their depth if they overlap."""
    part.solid.place(states.links[part.link, i] @ part.T_link_shape)
    distance, slack = part.solid.distance(fixture.solid), part.slack + fixture.slack
    return (distance if distance > 0.0 else -part.solid.depth(fixture.solid)) - slack
