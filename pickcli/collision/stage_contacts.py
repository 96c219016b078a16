"""Allowed contacts of each stage of a motion; all sets of allowed contacts are built here.

The target of a pick is in contact with its support and neighbours; a cup is pressed on it, and its bellows
give way. Each stage of the pick is one method of ``PickContacts``. A stage that is traversed backwards, as
for setting an item down in a bin, has the contacts of the stage itself. Items that the held target may push
aside count for it in no stage from the lift on; before, and for the tool, they are items like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.collision_world import Entered
from pickcli.collision.free_flyer import LINE_FOLLOWING_RESERVE
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.statics.solid_contact import SolidContact
from pickcli.statics.supports import Supports, supports_of

LINE_DEVIATION = 0.001  # m that the target may go deeper into solids than at rest: deviation from lines
# m, for the target without the arm, which leaves the arm the rest of LINE_DEVIATION
ALONE_LINE_DEVIATION = 0.0005
# m, besides what lines need: an edge that begins nearer to that is not proven, however far it leads away
PROOF_RESERVE = 0.0001
ANGLE_ERROR_SHARE = 0.5  # share of the depth that an angular pose error adds over the first stretch

Outward = tuple[float, float, float]


@dataclass(frozen=True)
class CupPress:
    """Press of a cup on an item.

    Attributes:
        outward: Unit normal, in the world, of the face under the cup; None if it is curved.
        axis: Unit vector, in the world, along which the cup is pressed.
        depth: m along it that the item may be inside of the cup's model at rest.
        overtravel: m that the tool travels beyond the surface.
        face: Name of the face under the cup.
    """

    outward: Outward | None
    axis: tuple[float, float, float]
    depth: float
    overtravel: float
    face: str = ""

    @property
    def way(self) -> Array:
        """(3,) m in the world by which the pressed solid is shifted away."""
        return (self.depth + LINE_DEVIATION) * np.array(self.axis)


def while_resting_on(floor: Iterable[str], item: str) -> AllowedContacts:
    """Return the contacts of a free item when it is set down.

    Args:
        floor: Names of the bodies that it may touch, but not enter.
        item: Its id; it is absent from its place in the scene.

    Returns:
        The contacts.
    """
    return AllowedContacts.of(item=dict.fromkeys(floor, np.zeros(3)), absent=frozenset({item}))


def while_coming_free(
    touched: frozenset[str] = frozenset(), opening_pairs: frozenset[tuple[str, str]] = frozenset()
) -> AllowedContacts:
    """Return the contacts of a recovery motion.

    Args:
        touched: Names that the cup is near at the start, and may touch on its way from there.
        opening_pairs: Pairs of a part of the robot and a solid near it that are only separated.

    Returns:
        The contacts.
    """
    free = AllowedContacts.at_any_depth(touched)
    return AllowedContacts(free.item, free.tool, opening_pairs=opening_pairs)


def at_object(item: str) -> AllowedContacts:
    """Return the contacts of an empty tool at an object that its cup or fingers may touch anywhere.

    Args:
        item: Id of the object.

    Returns:
        The contacts.
    """
    return AllowedContacts(tool=((item, None),))


def while_touching(bodies: Iterable[str]) -> AllowedContacts:
    """Return the contacts of an empty tool that touches solids of the cell with its cup or fingers alone.

    Args:
        bodies: Names of the solids.

    Returns:
        The contacts.
    """
    return AllowedContacts(tool=tuple((name, None) for name in sorted(bodies)))


def while_toppling(pushed: frozenset[str]) -> AllowedContacts:
    """Return the contacts of the empty tool that pushes an item over, and of its way back from there.

    Args:
        pushed: Ids of the item and of all that lies on it, which may be anywhere in the box afterwards.

    Returns:
        The contacts.
    """
    return AllowedContacts(pushed=pushed)


def while_in_segment(
    touching: Iterable[str],
    absent: frozenset[str],
    left_out: frozenset[tuple[str, str]],
    pushed: frozenset[str],
) -> AllowedContacts:
    """Return the contacts of a segment of a plan, by the names that the plan states.

    Args:
        touching: Names that tool and held item may touch, at any depth.
        absent: Ids of items that are absent.
        left_out: Pairs of a part of the robot and a solid that are not tested.
        pushed: Ids of items that the held item, or the empty tool, may push aside.

    Returns:
        The contacts.
    """
    stated = AllowedContacts.at_any_depth(touching, absent)
    return AllowedContacts(stated.item, stated.tool, absent, pushed, left_out)


@dataclass(frozen=True, eq=False)
class PickContacts:
    """The allowed contacts of one pick, stage by stage.

    Attributes:
        scene: The planning scene.
        target: The item that is picked.
        floor: Names of the bodies that form the floor below it.
        ignored: Ids of neighbours that are ignored.
        first_stretch: m, length of the first stretch of the lift, in which the target may touch its support.
        pushed: Ids of neighbours that the target may push aside once it is held.
    """

    scene: Scene
    target: PlacedItem
    floor: frozenset[str]
    ignored: frozenset[str]
    first_stretch: float
    pushed: frozenset[str] = frozenset()

    def while_approaching(self, face: str = "") -> AllowedContacts:
        """Return the contacts of the empty tool on its way to the target, or away from it.

        Args:
            face: Name of the face that the cup is put on.

        Returns:
            No contacts; ignored neighbours are absent. The hollow with that bottom, if it is one, is open.
        """
        return AllowedContacts(absent=self.ignored, entered=self._entered(face))

    def tool_while_pressing(self, outward: Outward | None, face: str = "") -> AllowedContacts:
        """Return the contacts of the tool without the arm at the target.

        The depth of the cup is checked later, in the proof of the whole arm.

        Args:
            outward: Unit normal, in the world, of the face under the cup; None if it is curved.
            face: Name of that face.

        Returns:
            The contacts, at any depth.
        """
        contacts = AllowedContacts.at_any_depth(self.met_by_cup(outward), self.ignored)
        return replace(contacts, entered=self._entered(face))

    def while_pressing(self, press: CupPress) -> AllowedContacts:
        """Return the contacts while the cup meets the target, or leaves it.

        Once held, the target still touches its support.

        Args:
            press: How the cup is pressed on the target.

        Returns:
            The contacts.
        """
        cup = dict.fromkeys(self.met_by_cup(press.outward), press.way)
        contacts = AllowedContacts.of(self._given_way(LINE_DEVIATION), cup, self.ignored)
        return replace(contacts, entered=self._entered(press.face))

    def while_closing(self) -> AllowedContacts:
        """Return the contacts of fingers that close on the target, or open from it.

        Returns:
            The target, at any depth: the swept volume of the closing fingers overlaps it.
        """
        return AllowedContacts.at_any_depth({self.target.id}, self.ignored)

    def while_lifting_pinched(self) -> AllowedContacts:
        """Return the contacts in the first stretch of the lift with fingers.

        Returns:
            Those of the target with the solids that it leaves; the fingers keep clear of these.
        """
        return self._pushing(self._left_behind(LINE_DEVIATION))

    def while_lifting(self, press: CupPress) -> AllowedContacts:
        """Return the contacts in the first stretch of the lift with a cup.

        Target and cup leave the solids that they touch, and go no deeper.

        Args:
            press: How the cup is pressed on the target.

        Returns:
            The contacts.
        """
        item, met = self._left_behind(LINE_DEVIATION), self.met_by_cup(press.outward)
        cup = {name: press.way if name in met else np.zeros(3) for name in self.near}
        return self._pushing(item, cup)

    def while_carrying(self) -> AllowedContacts:
        """Return the contacts of the held target inside its bin, after its last contact.

        Returns:
            No contacts but those with pushed neighbours; the target and ignored neighbours are absent.
        """
        return self._pushing()

    def while_transferring(self) -> AllowedContacts:
        """Return the contacts outside of the target's place, with it or after it was dropped.

        No neighbour is ignored there.

        Returns:
            No contacts; the target is absent from its place.
        """
        return AllowedContacts(absent=frozenset({self.target.id}))

    def item_while_lifting(self) -> AllowedContacts:
        """Return the contacts of the target as a free flyer in the first stretch of the lift.

        Returns:
            The contacts.
        """
        return self._pushing(self._left_behind(ALONE_LINE_DEVIATION))

    def rolling_along(self) -> tuple[AllowedContacts, ...]:
        """Return the contacts of the free target with the ground and one neighbour that may roll along.

        Returns:
            The contacts with each such neighbour.
        """
        others = frozenset(placed.id for placed in self.scene.items)
        ground = {body.name for body, _ in self.scene.standing}
        near = self.near.keys() - self.pushed
        rolling = [p.id for p in self.scene.items if p.id in near and p.can_roll]
        return tuple(AllowedContacts.at_any_depth(ground, others - {name}) for name in rolling)

    @property
    def near_off_floor(self) -> frozenset[str]:
        """Names of all solids near the target at rest, except the floor."""
        return frozenset(self.near) - self.floor

    def met_by_cup(self, outward: Outward | None) -> frozenset[str]:
        """Find what the cup may touch at a face: the target, the floor, and solids behind a thin target.

        Args:
            outward: Unit normal of the face in the world, None if it is curved.

        Returns:
            Names of items and bodies.
        """
        return self._met_by_cup_at(outward)

    @cached_property
    def near(self) -> Mapping[str, SolidContact]:
        """Contacts within the clearance of the target at rest: its support, walls and neighbours."""
        reach = self.scene.cell.clearance + LINE_FOLLOWING_RESERVE + PROOF_RESERVE
        found = {c.b: c for c in self.supports.graph.near(self.target.id, reach, self.floor)}
        # An item near the bend of the floor rests on either side of it; one that hangs in the air on neither.
        limit = reach + self.scene.bound(self.target)
        off_floor = self.floor if all(found[name].gap >= limit for name in self.floor) else frozenset()
        return {name: c for name, c in found.items() if name not in self.ignored | off_floor}

    @cached_property
    def supports(self) -> Supports:
        """The relation "rests on" of the items in the scene."""
        return supports_of(self.scene)

    def _entered(self, face: str) -> Entered | None:
        """Return the target and its hollow with a bottom, None if the face is one of its outer shape."""
        return None if self.target.item.hollow_at(face) is None else (self.target.id, face)

    @property
    def _without_target(self) -> frozenset[str]:
        return self.ignored | {self.target.id}

    def _pushing(
        self, item: Mapping[str, Array] | None = None, tool: Mapping[str, Array] | None = None
    ) -> AllowedContacts:
        """Return the contacts of the held target, which may push neighbours aside."""
        return replace(AllowedContacts.of(item, tool, self._without_target), pushed=self.pushed)

    def _left_behind(self, slip: float) -> dict[str, Array]:
        """Return the shifts (3,), by name, of the near solids that the held target may not push aside."""
        return {name: way for name, way in self._given_way(slip).items() if name not in self.pushed}

    def _given_way(self, slip: float) -> dict[str, Array]:
        """Return, by name, the shift (3,) of each near solid out of the target's way.

        Real solids do not overlap: if their stated poses do, by no more than the pose errors, one of them is
        elsewhere.

        Args:
            slip: m that the target may go deeper than that, or come nearer to solids that it is clear of and
                still touch them, because lines are followed only approximately.
        """
        turned = ANGLE_ERROR_SHARE * self.scene.noise_of(self.target).angle * self.first_stretch
        deep = {name: max(0.0, slip + turned - c.gap) for name, c in self.near.items()}
        deep |= {name: slip - self.near[name].gap for name in self._not_touched}
        return {name: deep[name] * c.normal for name, c in self.near.items()}

    @cached_property
    def _not_touched(self) -> frozenset[str]:
        """Near solids off the floor that the target is clear of at rest, if only by less than lines need."""
        clearance = self.scene.cell.clearance
        return frozenset(name for name in self.near_off_floor if self._apart(name) > clearance)

    def _apart(self, name: str) -> float:
        """Return the distance in m of a near solid, less what errors of both poses may take of it."""
        bound = {placed.id: self.scene.bound(placed) for placed in self.scene.items}.get(name, 0.0)
        return self.near[name].gap - self.scene.bound(self.target) - bound

    @cached_property
    def _met_by_cup_at(self) -> Callable[[Outward | None], frozenset[str]]:
        """Contacts of the cup by normal of the face, cached because many grasps share a face."""
        return cache(self._find_met_by_cup)

    def _find_met_by_cup(self, outward: Outward | None) -> frozenset[str]:
        behind = {name for name in self.near if outward is not None and self._is_behind(name, outward)}
        return frozenset({self.target.id}) | (frozenset(self.near) & self.floor) | behind

    def _is_behind(self, name: str, outward: Outward) -> bool:
        """Whether a solid lies wholly behind a flat face of the target, so that it is met only through it."""
        solids, across = self.supports.graph.solids, np.array(outward)
        k, other = solids.names.index(self.target.id), solids.names.index(name)
        target, width = solids.half_widths(np.array([k, other]), np.tile(across, (2, 1, 1)))[:, 0]
        return bool(across @ (solids.T[other, :3, 3] - solids.T[k, :3, 3]) + width <= target)
