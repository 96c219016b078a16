"""Computes the robot's clearance along a motion, by the planner's collision model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.collision_world import Entered
from pickcli.collision.kernel_robot import KernelRobot
from pickcli.collision.kernel_validator import Contact
from pickcli.collision.robot_model import CollisionModel
from pickcli.collision.stage_contacts import while_in_segment
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, from_quaternion, inverse, pose
from pickcli.motion.segment import Segment
from pickcli.page.motion_parts import TIME_RESOLUTION
from pickcli.page.page_motion import Carried, PathClearance
from pickcli.scene.scene import Scene

DISTANCE_CAP = 0.15  # m, largest measured distance
DISTANCE_RESOLUTION = 1e-4  # m, resolution of distances
MOST_STEADY = 5  # number of rounds in which steady pairs are excluded
MIN_STEADY_SHARE = 0.15  # share of a motion in which a steady pair is the nearest
STEADY_VARIATION = 0.01  # m, largest variation of its distance
MOST_PRESSED = 0.01  # m that a cup is pressed on a face
_NOTHING = Contact(DISTANCE_CAP, "", "")


def path_clearance(
    scene: Scene, segments: Sequence[Segment], times: Array, Q: Array, carried: Sequence[Carried]
) -> PathClearance:
    """Compute the distance to the nearest solid over time, except for planned contacts.

    Args:
        scene: The scene.
        segments: Segments, for held item and allowed contacts.
        times: (N,) s.
        Q: (N, n) configurations.
        carried: Held items with their poses in the tool.

    Returns:
        The clearance, a lower bound, as links are represented by spheres.
    """
    pairs = NearestPairs(scene.cell.clearance)
    pairs.add(scene, segments, times, Q, carried)
    return pairs.clearance()


class NearestPairs:
    """The nearest pair over time, for one or more motions.

    A link with nearly constant distance to one solid for a long time would hide all others, so such pairs are
    excluded and listed.

    Args:
        clearance: m kept by plans.
    """

    def __init__(self, clearance: float) -> None:
        self._kept = clearance
        self._models: dict[str, CollisionModel] = {}
        self._steady: dict[tuple[str, str], float] = {}
        self._times: list[float] = []
        self._contacts: list[Contact] = []

    def add(
        self, scene: Scene, segments: Sequence[Segment], times: Array, Q: Array, carried: Sequence[Carried]
    ) -> None:
        """Add a motion that is later than the previous ones.

        Args:
            scene: The scene of the motion.
            segments: Segments, for held item and allowed contacts.
            times: (N,) s, increasing.
            Q: (N, n) configurations.
            carried: Held items with their poses in the tool.
        """
        model = self._models.setdefault(scene.cell.fingerprint, _WithoutSelf(scene.cell))
        for _ in range(MOST_STEADY):
            contacts = _nearest(model, scene, segments, times, Q, carried, frozenset(self._steady))
            if not (found := _steady(contacts)):
                break
            self._steady |= found
        if self._times:  # no values between two motions
            self._times += [
                self._times[-1] + TIME_RESOLUTION,
                max(self._times[-1] + 2 * TIME_RESOLUTION, float(times[0]) - TIME_RESOLUTION),
            ]
            self._contacts += [_NOTHING, _NOTHING]
        later = [i for i, t in enumerate(times.tolist()) if not self._times or t > self._times[-1]]
        self._times += [float(times[i]) for i in later]
        self._contacts += [contacts[i] for i in later]

    def clearance(self) -> PathClearance:
        """Return the clearance over all motions so far.

        Returns:
            The clearance, a lower bound.
        """
        names = tuple(sorted({str(contact) for contact in self._contacts if contact.b}))
        index = {name: i for i, name in enumerate(names)}
        numbers = np.array([index.get(str(contact), -1) for contact in self._contacts], dtype=float)
        values = np.array([min(contact.distance, DISTANCE_CAP) for contact in self._contacts])
        return PathClearance(
            packed(np.array(self._times), TIME_RESOLUTION), packed(values, DISTANCE_RESOLUTION),
            packed(numbers, 1.0), names,
            self._kept, DISTANCE_CAP,
            tuple(f"{a} against {b}: {1e3 * distance:.0f} mm" for (a, b), distance in self._steady.items()),
        )  # fmt: skip


class _WithoutSelf(CollisionModel):
    """Collision model without self-collision pairs."""

    def __init__(self, cell: Cell) -> None:
        super().__init__(cell)
        self._alone: dict[ToolState, KernelRobot] = {}

    def state(self, tool_state: ToolState) -> KernelRobot:
        if tool_state not in self._alone:
            whole = super().state(tool_state)
            self._alone[tool_state] = replace(whole, self_pairs=np.zeros((0, 2), dtype=np.int32))
        return self._alone[tool_state]


def _nearest(
    model: CollisionModel,
    scene: Scene,
    segments: Sequence[Segment],
    times: Array,
    Q: Array,
    carried: Sequence[Carried],
    steady: frozenset[tuple[str, str]],
) -> list[Contact]:
    """The nearest pair at every time, without excluded ones."""
    found = [_NOTHING] * len(times)
    for segment, rows in _rows(segments, times):
        checker = _checker(model, scene, segment, carried, steady)
        for i in rows:
            contact = checker.clearance(Q[i], DISTANCE_CAP)
            if contact.distance < found[i].distance:
                found[i] = contact
    return found


def _steady(contacts: Sequence[Contact]) -> dict[tuple[str, str], float]:
    """Pairs that are nearest for long at nearly constant distance, such as a carriage on its rail."""
    by_pair: dict[tuple[str, str], list[float]] = {}
    for contact in contacts:
        is_link = not contact.a.startswith("held ") and contact.kind not in (
            "robot",
            "item",
            "cloud",
            "base",
            "",
        )
        if is_link:
            by_pair.setdefault((contact.a, contact.b), []).append(contact.distance)
    return {
        pair: min(distances)
        for pair, distances in by_pair.items()
        if len(distances) >= MIN_STEADY_SHARE * len(contacts)
        and max(distances) - min(distances) < STEADY_VARIATION
    }


def _rows(segments: Sequence[Segment], times: Array) -> Iterator[tuple[Segment, range]]:
    """Yield each segment with the indices of its samples."""
    for segment in segments:
        first, last = np.searchsorted(
            times, (segment.t_start - TIME_RESOLUTION, segment.t_end + TIME_RESOLUTION)
        )
        yield segment, range(int(first), int(last))


def _entered(carried: Carried, scene: Scene) -> Entered | None:
    """Return an item and its hollow that the tip is at the bottom of while it is held; None if in none."""
    item = scene.item(carried.item)
    tip = inverse(pose(carried.pose[:3], R=from_quaternion(carried.pose[3:])))[:3, 3]
    for hollow in item.hollows:
        low, high = hollow.bounds(item.shape)
        in_front = np.where(np.arange(3) == hollow.axis, np.clip(tip, low, high), tip)
        is_near = abs(float(tip[hollow.axis]) - hollow.height(item.shape)) <= MOST_PRESSED
        if is_near and hollow.contains(item.shape, in_front):
            return carried.item, hollow.bottom
    return None


def _checker(
    model: CollisionModel,
    scene: Scene,
    segment: Segment,
    carried: Sequence[Carried],
    steady: frozenset[tuple[str, str]],
) -> SceneChecker:
    """Create the checker for a segment of a plan, with the contacts that the plan allows."""
    known = {placed.id for placed in scene.items} | {body.name for body, _ in scene.standing}
    held = next((each for each in carried if each.item == segment.held), None)
    absent = frozenset({held.item} if held is not None else ())
    touching, pushed = (n for n in segment.touching if n in known), known & set(segment.pushing)
    contacts = while_in_segment(touching, absent & known, steady, frozenset(pushed))
    entered = (_entered(each, scene) for each in carried if each.item in known - absent)
    contacts = replace(contacts, entered=next((found for found in entered if found is not None), None))
    attached = None
    if held is not None:
        T = pose(held.pose[:3], R=from_quaternion(held.pose[3:]))
        attached = AttachedItem(scene.item(held.item), T, 0.0, held.item)
    return SceneChecker(model, scene, segment.tool_state, attached, contacts)
