"""Rules of one level of recovery, for the place where a motion stopped. See docs/recovery.md."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import while_coming_free
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import RecoveryLevel
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene

SLOW_LEVELS = (RecoveryLevel.SLOWLY, RecoveryLevel.JOG)
SLOW_SHARE = 0.095  # of all limits; the verifier allows a tenth of the velocity
CLOSING_TOLERANCE = 5e-4  # m that the nearest pair may come nearer on a recovery motion, sampled as below
SAMPLES = 6  # between two waypoints
TOUCH_MARGIN = 2e-4  # m that slow motions keep from solids that they are not near at the start
MOST_NEAR = 24  # pairs


@dataclass(frozen=True, eq=False)
class RecoveryRules:
    """Rules of one level of recovery from one start.

    Attributes:
        context: The cell, its models and its precomputed files.
        scene: The current scene.
        start: State of the stopped robot.
        level: The level.
        touching: Names that the cup may touch on the first line; never closing again, if an opening pair.
        opening_pairs: Pairs (part of the robot, solid) that are near at the start and need only come apart.
        reserve: m on top of the cell's clearance.
        scale: Factor of all limits.
    """

    context: PlanningContext
    scene: Scene
    start: Start
    level: RecoveryLevel
    touching: frozenset[str] = frozenset()
    opening_pairs: frozenset[tuple[str, str]] = frozenset()
    reserve: float = 0.0
    scale: float = 1.0

    @property
    def seen(self) -> Scene:
        """The scene in which near pairs must open: on a slow level, without errors of item poses."""
        return replace(self.scene, noise=PoseNoise()) if self.level in SLOW_LEVELS else self.scene

    def mode(self, touching: frozenset[str] = frozenset()) -> Mode:
        """Return the mode of the empty tool in its current state.

        Args:
            touching: Names that the cup may touch.

        Returns:
            The mode.
        """
        return Mode(
            self.start.tool_state, None, while_coming_free(touching, self.opening_pairs), self.reserve
        )

    def checker(self, touching: frozenset[str] = frozenset()) -> SceneChecker:
        """Return the checker for motions of the empty tool in its current state.

        Args:
            touching: Names that the cup may touch.

        Returns:
            The checker.
        """
        return self.context.checker_for(self.scene, self.mode(touching))

    @property
    def after_first_line(self) -> RecoveryRules:
        """The rules from the end of the first line on: on the level ``OPENING`` the cup is free by then.

        A lip that is bent against a body would slide along it.
        """
        if self.level is not RecoveryLevel.OPENING:
            return self
        cup = _cup_links(self.context)
        links = frozenset(pair for pair in self.opening_pairs if pair[0] not in cup)
        return replace(self, touching=frozenset(), opening_pairs=links)

    @property
    def all_pairs(self) -> SceneChecker:
        """The checker that measures all near pairs, also those that are allowed to be near."""
        mode = Mode(self.start.tool_state, reserve=self.reserve)
        return self.context.checker_for(self.seen, mode)

    @cached_property
    def entry(self) -> Entry:
        """The entry of the pod, or of the place in which the tool stopped."""
        return entry_at(self.scene, self.context.arm.tip(self.start.q, self.start.tool_state))

    def closes(self, waypoints: Array) -> Reason | None:
        """Explain if a polyline brings pairs together that are near at the start.

        Args:
            waypoints: (N, n) configurations.

        Returns:
            The pair that comes nearer, and by how much; None if none does.
        """
        if not self.opening_pairs:
            return None
        all_pairs = self.all_pairs
        s = np.linspace(0.0, 1.0, SAMPLES, endpoint=False)[:, None]
        dense = [a + s * (b - a) for a, b in pairwise(waypoints)]
        Q = np.ascontiguousarray(np.vstack([*dense, waypoints[-1:]]))
        distances = np.minimum(all_pairs.kernel.clearances(Q, all_pairs.margin), all_pairs.margin)
        before = np.maximum.accumulate(distances)
        if (worst := float((before - distances).max())) <= CLOSING_TOLERANCE:
            return None
        i = int(np.argmax(before - distances))
        contact = all_pairs.clearance(Q[i])
        return Reason("closes again", "way out", f"{contact} by {worst * 1e3:.1f} mm", contact.item)


@dataclass(frozen=True, eq=False)
class Entry:
    """The way into the pod, or into a place of a cell without a pod: backwards it is the way out.

    Attributes:
        T_world_entry: (4, 4) frame whose x leads straight in: of the pod, or of the access of the place.
        up: (3,) unit vector in the world.
        depth: m from the plane of the mouths to the tip, along the way in; not positive outside.
    """

    T_world_entry: Array
    up: Array
    depth: float


def entry_at(scene: Scene, T_world_tip: Array) -> Entry:
    """Find the entry through which the tool is led out.

    Args:
        scene: The current scene.
        T_world_tip: (4, 4) pose of the tool.

    Returns:
        That of the pod if the cell has one. Else of the place whose room the tip is in; if it is in none, of
        the one whose mouth it is least far beside, as seen along the way in.
    """
    places = scene.cell.places.values()
    if scene.cell.pod.bins or not places:
        T = scene.T_world_pod
        return Entry(T, T[:3, 2], float((inverse(T) @ T_world_tip)[0, 3]))
    found: list[tuple[bool, float, Entry]] = []
    for place in places:
        T_world_place = scene.T_world_place(place)
        is_outside = not place.holds((inverse(T_world_place) @ T_world_tip)[:3, 3])
        T = np.asarray(T_world_place @ place.T_place_entry)
        x, y, z = (inverse(T) @ T_world_tip)[:3, 3]
        access = place.access
        beside = max(0.0, abs(y) - access.width / 2, -z, z - access.height)
        up = -T[:3, 0] if access.is_from_above else T[:3, 2]
        depth = float(x) if beside == 0.0 else min(float(x), 0.0)
        found.append((is_outside, beside, Entry(T, up, depth)))
    return min(found, key=lambda each: (each[0], each[1], -each[2].depth))[2]


def rules_at(
    context: PlanningContext, scene: Scene, start: Start, level: RecoveryLevel
) -> RecoveryRules | Reason:
    """Determine the rules of a level where the robot stopped.

    Args:
        context: The cell, its models and its precomputed files.
        scene: The current scene.
        start: State of the stopped robot.
        level: The level.

    Returns:
        The rules, or why the level does not apply.
    """
    rules = RecoveryRules(context, scene, start, level)
    if level is RecoveryLevel.AS_PLANNED:
        touching = _near_the_cup(rules)
        return touching if isinstance(touching, Reason) else replace(rules, touching=touching)
    if level in SLOW_LEVELS:
        entry = rules.entry
        if entry.depth <= 0.0 and rules.checker().is_valid(start.q):
            inside = "the pod" if scene.cell.pod.bins else "every place"
            outside = f"outside of {inside}, near to nothing"
            return Reason("nothing to come free of", "where the robot stopped", outside)
        rules = replace(rules, reserve=TOUCH_MARGIN - context.cell.clearance, scale=SLOW_SHARE)
    opening_pairs = _near(rules)
    if isinstance(opening_pairs, Reason):
        return opening_pairs
    cup = _cup_links(context)
    # A bent lip stays in contact until the cup has come as far as it was pressed in.
    touching = frozenset(solid for link, solid in opening_pairs if link in cup)
    return replace(rules, opening_pairs=opening_pairs, touching=touching)


def _cup_links(context: PlanningContext) -> frozenset[str]:
    """Return the links of the tool that a lip is part of; none of fingers."""
    tool = context.cell.robot.tool
    return frozenset() if tool.grip.takes_widths else frozenset(tool.contact_links)


def _near_the_cup(rules: RecoveryRules) -> frozenset[str] | Reason:
    """Return the names within the clearance of the cup where the robot stopped."""
    touching: frozenset[str] = frozenset()
    for _ in range(MOST_NEAR):
        checker = rules.checker(touching)
        if checker.is_valid(rules.start.q):
            return touching
        near = checker.clearance(rules.start.q)
        if near.b in touching or near.kind == "robot":
            break
        touching |= {near.b}
    return rules.checker(touching).explain(rules.start.q).at("where the robot stopped")


def _near(rules: RecoveryRules) -> frozenset[tuple[str, str]] | Reason:
    """Return the pairs of a link and a solid within its clearance where the robot stopped."""
    opening_pairs: frozenset[tuple[str, str]] = frozenset()
    for _ in range(MOST_NEAR):
        checker = replace(rules, opening_pairs=opening_pairs).checker()
        if checker.is_valid(rules.start.q):
            return opening_pairs
        near = checker.clearance(rules.start.q)
        if near.kind in ("robot", ""):
            break
        opening_pairs |= {(near.a, near.b)}
    return (
        replace(rules, opening_pairs=opening_pairs)
        .checker()
        .explain(rules.start.q)
        .at("where the robot stopped")
    )
