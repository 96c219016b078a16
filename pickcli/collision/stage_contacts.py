"""Who may touch whom on each stage of a motion: the one place where sets of allowed contacts are formed.

The target of a pick lies on something and beside something; a cup is pressed on it, and what it is pressed
on gives way. Each stage of the pick is one method of ``PickContacts``. A stage that is traversed
backwards, as where an item is set down in a bin, has the contacts of the stage itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.free_flyer import FOLLOWING
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_contact import SolidContact
from pickcli.scene.supports import Supports, supports_of

SLIP = 0.001  # m that the target may go deeper into what it touches than it lies: lines are only nearly so
ALONE_SLIP = 0.0005  # m, of the target without the arm, which leaves the arm the rest of SLIP
TURNED = 0.5  # of how far a pose that is off in angle leads deeper over the first stretch

Outward = tuple[float, float, float]


@dataclass(frozen=True)
class CupPress:
    """How a cup is pressed on an item.

    Attributes:
        outward: Unit normal, in the world, of the face it is pressed on; None where that is curved.
        axis: Unit vector, in the world, along which the cup is pressed.
        depth: m along it that what the cup is pressed on may be inside of the cup at rest.
        overtravel: m that the tool travels beyond the surface.
    """

    outward: Outward | None
    axis: tuple[float, float, float]
    depth: float
    overtravel: float

    @property
    def way(self) -> Array:
        """(3,) m in the world that what the cup is pressed on counts as moved out of its way."""
        return (self.depth + SLIP) * np.array(self.axis)


def while_resting_on(floor: Iterable[str], item: str) -> AllowedContacts:
    """Contacts of an item by itself where it is set down.

    Args:
        floor: Names of the bodies that it may touch, and not sink into.
        item: Its id, for it is no longer where the scene has it.

    Returns:
        The contacts.
    """
    return AllowedContacts.of(item=dict.fromkeys(floor, np.zeros(3)), absent=frozenset({item}))


def while_coming_free(
    touched: frozenset[str] = frozenset(), opening: frozenset[tuple[str, str]] = frozenset()
) -> AllowedContacts:
    """Contacts of a way out of where the robot stopped.

    Args:
        touched: Names of what the cup is near to where it stopped, and may touch on its way from there.
        opening: Pairs of a part of the robot and a solid that are near to each other, and only come apart.

    Returns:
        The contacts.
    """
    free = AllowedContacts.at_any_depth(touched)
    return AllowedContacts(free.item, free.tool, opening=opening)


def while_in_segment(
    touching: Iterable[str], absent: frozenset[str], left_out: frozenset[tuple[str, str]]
) -> AllowedContacts:
    """Contacts in a segment of a plan, by the names that the plan states.

    Args:
        touching: Names of what tool and held item may touch, at any depth.
        absent: Ids of items that are not there.
        left_out: Pairs of a part of the robot and a solid that are not tested.

    Returns:
        The contacts.
    """
    stated = AllowedContacts.at_any_depth(touching, absent)
    return AllowedContacts(stated.item, stated.tool, absent, opening=left_out)


@dataclass(frozen=True, eq=False)
class PickContacts:
    """The contacts of one pick, stage by stage.

    Attributes:
        scene: The scene as it is seen.
        target: The item that is picked.
        floor: Names of the bodies that make the floor where it lies.
        ignored: Ids of neighbours that count as not there.
        stretch: m, length of the first stretch of the lift, over which the target may touch what it lies on.
    """

    scene: Scene
    target: PlacedItem
    floor: frozenset[str]
    ignored: frozenset[str]
    stretch: float

    def while_approaching(self) -> AllowedContacts:
        """Contacts of the empty tool on its way to the target, or away from it.

        Returns:
            None but the absence of ignored neighbours.
        """
        return AllowedContacts(absent=self.ignored)

    def tool_while_pressing(self, outward: Outward | None) -> AllowedContacts:
        """Contacts of the tool alone at the target.

        How deep the cup may go is left to the proof of the whole arm.

        Args:
            outward: Unit normal, in the world, of the face that the cup is pressed on; None where that is
                curved.

        Returns:
            The contacts, however deep.
        """
        return AllowedContacts.at_any_depth(self.met_by_cup(outward), self.ignored)

    def while_pressing(self, press: CupPress) -> AllowedContacts:
        """Contacts while the cup meets the target, or leaves it.

        Once the target is held, it still touches what it lies on.

        Args:
            press: How the cup is pressed on the target.

        Returns:
            The contacts.
        """
        cup = dict.fromkeys(self.met_by_cup(press.outward), press.way)
        return AllowedContacts.of(self._given_way(SLIP), cup, self.ignored)

    def while_closing(self) -> AllowedContacts:
        """Contacts of fingers that close on the target, or open from it.

        Returns:
            The target, however deep: what the fingers sweep as they close goes through it.
        """
        return AllowedContacts.at_any_depth({self.target.id}, self.ignored)

    def while_lifting_pinched(self) -> AllowedContacts:
        """Contacts over the first stretch of the lift where fingers hold the target.

        Returns:
            Those of the target with what it leaves; the fingers keep clear of all that.
        """
        return AllowedContacts.of(self._given_way(SLIP), absent=self._without_target)

    def while_lifting(self, press: CupPress) -> AllowedContacts:
        """Contacts over the first stretch of the lift.

        Target and cup leave what they touch, and go no deeper.

        Args:
            press: How the cup is pressed on the target.

        Returns:
            The contacts.
        """
        item, met = self._given_way(SLIP), self.met_by_cup(press.outward)
        cup = {name: press.way if name in met else np.zeros(3) for name in item}
        return AllowedContacts.of(item, cup, self._without_target)

    def while_carrying(self) -> AllowedContacts:
        """Contacts of the target in the cup, inside of its bin, when it touches nothing any more.

        Returns:
            None but the absence of the target and of ignored neighbours.
        """
        return AllowedContacts(absent=self._without_target)

    def while_transferring(self) -> AllowedContacts:
        """Contacts of the target in the cup outside of its bin, where no neighbour is ignored.

        Returns:
            None but the absence of the target from where it lay.
        """
        return AllowedContacts(absent=frozenset({self.target.id}))

    def after_dropping(self) -> AllowedContacts:
        """Contacts of the empty tool when the target has been dropped.

        Returns:
            None but the absence of the target: it is no longer where the scene has it.
        """
        return AllowedContacts(absent=frozenset({self.target.id}))

    def item_while_lifting(self) -> AllowedContacts:
        """Contacts of the target by itself over the first stretch of the lift.

        Returns:
            The contacts.
        """
        return AllowedContacts.of(self._given_way(ALONE_SLIP), absent=self._without_target)

    def rolling_along(self) -> tuple[AllowedContacts, ...]:
        """Contacts of the target by itself with the ground and one neighbour that may roll along.

        Returns:
            The contacts with each such neighbour.
        """
        others = frozenset(placed.id for placed in self.scene.items)
        ground = {body.name for body, _ in self.scene.standing} & set(self.near)
        rolling = [p.id for p in self.scene.items if p.id in self.near and p.can_roll]
        return tuple(AllowedContacts.at_any_depth(ground, others - {name}) for name in rolling)

    @property
    def near_off_floor(self) -> frozenset[str]:
        """Names of all that the target is near to at rest, but the floor."""
        return frozenset(self.near) - self.floor

    def met_by_cup(self, outward: Outward | None) -> frozenset[str]:
        """Find what the cup may touch at a face: the target, the floor, and what a thin target lies on.

        Args:
            outward: Unit normal of the face in the world, None where it is curved.

        Returns:
            Names of items and bodies.
        """
        return self._met_by_cup_at(outward)

    @cached_property
    def near(self) -> Mapping[str, SolidContact]:
        """Everything within the clearance of the target at rest: its support, walls and neighbours."""
        reach = self.scene.cell.clearance + FOLLOWING
        found = {c.b: c for c in self.supports.graph.near(self.target.id, reach, self.floor)}
        # An item near the bend rests on either side of it; one that hangs in the air on neither.
        limit = reach + self.scene.noise.bound(self.target.item)
        off_floor = self.floor if all(found[name].gap >= limit for name in self.floor) else frozenset()
        return {name: c for name, c in found.items() if name not in self.ignored | off_floor}

    @cached_property
    def supports(self) -> Supports:
        """Which item rests on which in the scene."""
        return supports_of(self.scene)

    @property
    def _without_target(self) -> frozenset[str]:
        return self.ignored | {self.target.id}

    def _given_way(self, slip: float) -> dict[str, Array]:
        """By name, how far (3,) what is near counts as moved out of the target's way.

        Two solids do not overlap: where their poses say so, by no more than both may be off, one of them is
        elsewhere.

        Args:
            slip: m that the target may go deeper than that, or come nearer to what it is clear of and still
                touch it, on a way that follows a line only nearly.
        """
        turned = TURNED * self.scene.noise.angle * self.stretch
        return {name: max(0.0, slip + turned - c.gap) * c.normal for name, c in self.near.items()}

    @cached_property
    def _met_by_cup_at(self) -> Callable[[Outward | None], frozenset[str]]:
        """Contacts of the cup by normal of the face, found once for each face, as many grasps ask for it."""
        return cache(self._find_met_by_cup)

    def _find_met_by_cup(self, outward: Outward | None) -> frozenset[str]:
        behind = {name for name in self.near if outward is not None and self._is_behind(name, outward)}
        return frozenset({self.target.id}) | (frozenset(self.near) & self.floor) | behind

    def _is_behind(self, name: str, outward: Outward) -> bool:
        """Whether all of a solid lies behind a flat face of the target: only through it can it be met."""
        solids, across = self.supports.graph.solids, np.array(outward)
        k, other = solids.names.index(self.target.id), solids.names.index(name)
        target, width = solids.half_widths(np.array([k, other]), np.tile(across, (2, 1, 1)))[:, 0]
        return bool(across @ (solids.T[other, :3, 3] - solids.T[k, :3, 3]) + width <= target)
