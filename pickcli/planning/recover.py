"""A safe way out from wherever a motion stopped, on one of several levels. See docs/recovery.md.

Delft's and KTH's systems start over from a place in front of the shelf; a robot that stopped on a proven
path gets there by lines and coarse motions that are proven again, for the tool as it is now. Where the rules
of every plan leave no way, each level gives up a little more of them, and says so in the plan.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from pickcli.cartesian.follow import follow_line
from pickcli.cartesian.keyposes import PREAPPROACH_DISTANCE
from pickcli.cartesian.line import shifted
from pickcli.cell.scene import PoseNoise, Scene
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assemble import assemble_pieces
from pickcli.planning.coarse import plan_coarse
from pickcli.planning.context import NONE, Planner
from pickcli.planning.pick import Start
from pickcli.planning.pieces import COARSE_BLEND, Piece
from pickcli.planning.retrace import StoppedMotion, back_to_start
from pickcli.seeds import derived_seed

SAFE = "home"

# m up, or back along the tool, in which the cup may still touch what it touches. Up over what it lies on is
# the shortest; a cup that came from the side would scrape along.
FIRST_UP = (0.02,)
FIRST_BACK = (0.02, 0.04)
ASIDE = 0.02  # m to either side, or down, on the levels that take apart what is near

RISES = (0.0, 0.02, 0.04, 0.07, 0.10)  # m from there, tried in this order
MOST_WAYS_HOME = (
    3  # ways out of the pod from which a way home is searched: one that fails costs a whole search
)

SLOW_LEVELS = (RecoveryLevel.SLOWLY, RecoveryLevel.JOG)
SLOW = 0.095  # of all limits, where the verifier allows a tenth of the velocity
JOG = 0.012  # m that the link or tool that moves farthest goes in a jog
JOG_STEP = 1e-4  # rad or m, of the differences that give the direction of a jog
JOG_GAIN = 0.001  # m that the nearest pair must come apart by a jog
CLOSING = 5e-4  # m that the nearest pair may come nearer on a way out, sampled as below
SAMPLES = 6  # between two waypoints
TOUCH_MARGIN = 2e-4  # m that slow motions keep from what they are not near to
MOST_NEAR = 24  # pairs


@dataclass(frozen=True, eq=False)
class _Rules:
    """What holds on one level from one start.

    scene: as it is seen now. touching: what the cup may touch on the first line
    opening: pairs that are near at the start and need only come apart
    reserve: m on top of the cell's clearance. scale: of all limits
    """

    planner: Planner
    scene: Scene
    start: Start
    level: RecoveryLevel
    touching: frozenset[str] = NONE
    opening: frozenset[tuple[str, str]] = frozenset()
    reserve: float = 0.0
    scale: float = 1.0

    @property
    def seen(self) -> Scene:
        """The scene in which what is near at the start must open: on a slow level items as they were seen."""
        return replace(self.scene, noise=PoseNoise()) if self.level in SLOW_LEVELS else self.scene

    def checker(self, touching: frozenset[str] = NONE) -> SceneChecker:
        """Of the empty tool as it stands."""
        return self.planner.checker(
            self.scene,
            self.start.pivot,
            touching=AllowedContacts.anyhow(touching),
            reserve=self.reserve,
            opening=self.opening,
        )

    def closes(self, waypoints: Array) -> Reason | None:
        """Why a polyline brings together what is near at the start; None where it does not."""
        if not self.opening:
            return None
        all_pairs = self.planner.checker(self.seen, self.start.pivot, reserve=self.reserve)
        s = np.linspace(0.0, 1.0, SAMPLES, endpoint=False)[:, None]
        dense = [a + s * (b - a) for a, b in pairwise(waypoints)]
        Q = np.ascontiguousarray(np.vstack([*dense, waypoints[-1:]]))
        distances = np.minimum(all_pairs.kernel.clearances(Q, all_pairs.margin), all_pairs.margin)
        before = np.maximum.accumulate(distances)
        if (worst := float((before - distances).max())) <= CLOSING:
            return None
        i = int(np.argmax(before - distances))
        contact = all_pairs.clearance(Q[i])
        return Reason("closes again", "way out", f"{contact} by {worst * 1e3:.1f} mm", contact.item)


def plan_recovery(
    planner: Planner,
    scene: Scene,
    start: Start,
    seed: int = 0,
    level: RecoveryLevel = RecoveryLevel.AS_PLANNED,
    stopped: StoppedMotion | None = None,
) -> Plan:
    """Plan from rest, with the empty tool, away from where a motion stopped.

    Args:
        planner: The planning context.
        scene: The scene as it is seen now.
        start: Configuration (n,) and pivot state in which the robot stands.
        seed: Seed of the coarse motion.
        level: What the plan may claim. ``AS_PLANNED`` and ``OPENING`` lead home; ``BACKWARDS`` to where the
            stopped motion began; ``SLOWLY`` out of the pod; ``JOG`` some millimetres away from what is near.
        stopped: The motion that stopped, which ``BACKWARDS`` goes along.

    Returns:
        The plan, uncertified, with ``level`` as its claim.

    Raises:
        NoPlanError: Nothing was found on that level.
    """
    label = f"recover {level}"
    found: Plan | list[Reason]
    if level is RecoveryLevel.BACKWARDS:
        found = [Reason("nothing to go back along", label)]
        if stopped is not None:
            back = back_to_start(stopped, scene, planner.arm.limits, seed)
            found = [back] if isinstance(back, Reason) else back
    else:
        rules = _rules(planner, scene, start, level)
        if isinstance(rules, Reason):
            found = [rules]
        elif level is RecoveryLevel.JOG:
            found = _jogged(rules, label, seed)
        else:
            found = _out(rules, label, seed)
    if isinstance(found, list):
        raise NoPlanError(label, found)
    # The robot stands in the scene as it is, whatever the level makes of it.
    return replace(found, scene_hash=_hash(scene), recovery=level)


def _hash(scene: Scene) -> str:
    from pickcli.cell.scene_file import scene_hash

    return scene_hash(scene)


def _rules(planner: Planner, scene: Scene, start: Start, level: RecoveryLevel) -> _Rules | Reason:
    """What the level allows where the robot stands."""
    rules = _Rules(planner, scene, start, level)
    if level is RecoveryLevel.AS_PLANNED:
        touching = _near_the_cup(rules)
        return touching if isinstance(touching, Reason) else replace(rules, touching=touching)
    if level in SLOW_LEVELS:
        depth = float((inverse(scene.T_world_pod) @ planner.arm.tip(start.q, start.pivot))[0, 3])
        if depth <= 0.0 and rules.checker().is_free(start.q):
            outside = "outside of the pod, near to nothing"
            return Reason("nothing to come free of", "where the robot stopped", outside)
        rules = replace(rules, reserve=TOUCH_MARGIN - planner.cell.clearance, scale=SLOW)
    opening = _near(rules)
    return opening if isinstance(opening, Reason) else replace(rules, opening=opening)


def _out(rules: _Rules, label: str, seed: int) -> Plan | list[Reason]:
    """Out of the pod by lines, and home; slowly only out, for from there the stricter levels go on."""
    planner, reasons = rules.planner, list[Reason]()
    n_ways_home = 0
    for out in _ways_out_of_the_pod(rules):
        if isinstance(out, Reason):
            reasons.append(out)
            continue
        pieces, q = out
        if rules.level is not RecoveryLevel.SLOWLY:
            n_ways_home += 1
            way = _home(rules, q, derived_seed(seed, label))
            if isinstance(way, Reason):
                reasons.append(way)
                if n_ways_home == MOST_WAYS_HOME:
                    break
                continue
            pieces = [*pieces, way]
        plan = assemble_pieces(planner, rules.scene, pieces, label, seed)
        if not isinstance(plan, Reason):
            return plan
        reasons.append(plan)
    return reasons


def _home(rules: _Rules, q: Array, seed: int) -> Piece | Reason:
    """The coarse motion home, by the rules of every plan where the arm is clear by now."""
    planner, pivot = rules.planner, rules.start.pivot
    checker = planner.checker(rules.scene, pivot)
    if not checker.is_free(q):
        checker = rules.checker()
    goal = planner.cell.configurations[SAFE].q
    coarse = plan_coarse(planner, checker, q, goal[None], [0.0], seed, "way home")
    if isinstance(coarse, Reason):
        return coarse
    if (closes := rules.closes(coarse.waypoints)) is not None:
        return closes
    return Piece(SegmentKind.TRANSIT, coarse.waypoints, pivot, checker, blend=COARSE_BLEND)


def _ways_out_of_the_pod(rules: _Rules) -> Iterator[tuple[list[Piece], Array] | Reason]:
    """Lines up and out along the pod's axis, the least rise first; none where nothing is near."""
    planner, start, T_world_pod = rules.planner, rules.start, rules.scene.T_world_pod
    tip = planner.arm.tip(start.q, start.pivot)
    depth = float((inverse(T_world_pod) @ tip)[0, 3]) + PREAPPROACH_DISTANCE
    if depth <= 0.0 and not rules.touching and not rules.opening:
        yield [], start.q
    for first, rise in product(_first_steps(rules, tip), RISES):
        yield _risen_and_out(rules, tip, first, rise, max(depth, 0.0))


def _first_steps(rules: _Rules, tip: Array) -> list[Array]:
    """Ways (3,) in the world that may free the tool from what it is near to."""
    T_world_pod = rules.scene.T_world_pod
    out, left, up, back = -T_world_pod[:3, 0], T_world_pod[:3, 1], T_world_pod[:3, 2], -tip[:3, 2]
    steps = [length * up for length in FIRST_UP] + [length * back for length in FIRST_BACK]
    if rules.level is not RecoveryLevel.AS_PLANNED:
        steps += [ASIDE * way for way in (out, left, -left, -up, out + up, out - up, out + left, out - left)]
        steps.append(np.zeros(3))
    return steps


def _risen_and_out(
    rules: _Rules, tip: Array, first: Array, rise: float, depth: float
) -> tuple[list[Piece], Array] | Reason:
    """First away from what is near, then up, then out."""
    planner, start, T_world_pod = rules.planner, rules.start, rules.scene.T_world_pod
    freed = shifted(tip, first)
    lifted = shifted(freed, rise * T_world_pod[:3, 2])
    stages = [
        (SegmentKind.DEPART, freed, rules.touching),
        (SegmentKind.RETREAT, lifted, NONE),
        (SegmentKind.RETREAT, shifted(lifted, -depth * T_world_pod[:3, 0]), NONE),
    ]
    pieces, q, here = list[Piece](), start.q, tip
    for kind, there, allowed in stages:
        if np.allclose(there, here):
            continue
        checker = rules.checker(allowed)
        line = follow_line(planner.arm, checker, here, there, start.pivot, q, "way out")
        if isinstance(line, Reason):
            return line
        if (closes := rules.closes(line.waypoints)) is not None:
            return closes
        speed = planner.settings.lift_speed
        pieces.append(
            Piece(
                kind, line.waypoints, start.pivot, checker, touching=allowed, max_tool_speed=speed,
                scale=rules.scale,
            )
        )  # fmt: skip
        q, here = np.asarray(line.waypoints[-1]), there
    return pieces, q


def _near_the_cup(rules: _Rules) -> frozenset[str] | Reason:
    """What is within the clearance of the cup where the robot stopped."""
    touching: frozenset[str] = frozenset()
    for _ in range(MOST_NEAR):
        checker = rules.checker(touching)
        if checker.is_free(rules.start.q):
            return touching
        near = checker.clearance(rules.start.q)
        if near.b in touching or near.kind == "robot":
            break
        touching |= {near.b}
    return rules.checker(touching).explain(rules.start.q).at("where the robot stopped")


def _near(rules: _Rules) -> frozenset[tuple[str, str]] | Reason:
    """The pairs of a link and what stands within the clearance of it where the robot stopped."""
    opening: frozenset[tuple[str, str]] = frozenset()
    for _ in range(MOST_NEAR):
        checker = replace(rules, opening=opening).checker()
        if checker.is_free(rules.start.q):
            return opening
        near = checker.clearance(rules.start.q)
        if near.kind in ("robot", ""):
            break
        opening |= {(near.a, near.b)}
    return replace(rules, opening=opening).checker().explain(rules.start.q).at("where the robot stopped")


def _jogged(rules: _Rules, label: str, seed: int) -> Plan | list[Reason]:
    """A short straight edge in joint space that takes the nearest pair apart farthest."""
    q, pivot = rules.start.q, rules.start.pivot
    all_pairs = rules.planner.checker(rules.seen, pivot, reserve=rules.reserve)
    before = all_pairs.clearance(q)
    ranked = []
    for step in _jogs(rules, all_pairs):
        there = q + step
        gain = all_pairs.clearance(there).distance - before.distance
        if gain >= JOG_GAIN:
            ranked.append((-gain, tuple(there.tolist())))
    reasons = [Reason("no jog", "where the robot stopped", f"none takes {before} apart", before.item)]
    checker = rules.checker()
    for _, end in sorted(ranked):
        edge = np.stack([q, np.array(end)])
        if not checker.edge_is_free(edge[0], edge[1]):
            reasons.append(checker.explain_edge(edge[0], edge[1]))
        elif (closes := rules.closes(edge)) is not None:
            reasons.append(closes)
        else:
            piece = Piece(SegmentKind.TRANSIT, edge, pivot, checker, scale=rules.scale)
            plan = assemble_pieces(rules.planner, rules.scene, [piece], label, seed)
            if not isinstance(plan, Reason):
                return plan
            reasons.append(plan)
    return reasons


def _jogs(rules: _Rules, all_pairs: SceneChecker) -> Iterator[Array]:
    """Joint steps (n,) within the limits: up the gradient of the least distance, and the tool every way."""
    arm, q, pivot = rules.planner.arm, rules.start.q, rules.start.pivot
    unit = np.eye(arm.n)
    ahead = np.array([all_pairs.clearance(q + JOG_STEP * e).distance for e in unit])
    behind = np.array([all_pairs.clearance(q - JOG_STEP * e).distance for e in unit])
    jacobian = np.linalg.pinv(arm.jacobian(q, pivot), rcond=1e-3)
    axes = rules.scene.T_world_pod[:3, :3]
    ways = [sign * axes[:, k] for k in range(3) for sign in (1.0, -1.0)]
    ways.append(-arm.tip(q, pivot)[:3, 2])
    directions = [ahead - behind, *(jacobian @ np.concatenate([way, np.zeros(3)]) for way in ways)]
    directions += [sign * e for e in unit for sign in (1.0, -1.0)]
    for direction in directions:
        farthest = _farthest(rules, direction * JOG_STEP / max(float(np.abs(direction).max()), 1e-12))
        if farthest <= 1e-9:
            continue
        step = direction * JOG_STEP / float(np.abs(direction).max()) * JOG / farthest
        if ((q + step > arm.limits.lower) & (q + step < arm.limits.upper)).all():
            yield step


def _farthest(rules: _Rules, step: Array) -> float:
    """m that a small joint step (n,) moves the frame, or the tool, that goes farthest."""
    arm, q, pivot = rules.planner.arm, rules.start.q, rules.start.pivot
    chain = arm.chain(pivot)
    moved = np.asarray(chain.fk(q + step))[:, :3, 3] - np.asarray(chain.fk(q))[:, :3, 3]
    tool = arm.tip(q + step, pivot)[:3, 3] - arm.tip(q, pivot)[:3, 3]
    return float(np.linalg.norm(np.vstack([moved, tool]), axis=1).max())
