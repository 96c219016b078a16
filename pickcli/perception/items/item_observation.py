"""What perception says of the listed items of a place."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.geometry import Array
from pickcli.perception.items.routing import ItemRoute
from pickcli.scene.scene import PoseNoise


class FoundBy(StrEnum):
    """By what the pose of an item was found."""

    SHAPE = "shape"  # and its colours: which of several like sides is which is not known
    PRINT = "print"  # what is printed on it was recognised there, too: all sides are known


@dataclass(frozen=True, eq=False)
class Support:
    """How much of the picture speaks for a pose.

    Attributes:
        expected: Pixels that the item would fill, were nothing but what is known before it.
        shown: Of these, not behind other items.
        supported: Of these, in which its surface was measured.
        through: Of these, in which something behind it was measured: it was seen through.
        before: Of these, in which something before it was measured.
        gain: nats by which the picture is explained better with the item than without.
        margin: nats by which it is explained better than with the item's next place.
        colour: nats, mean cost of the colours of supported pixels; negative if they are its own.
        own_colour: Share of supported pixels with colours that the item has itself; 1 if there are too few.
        position_spread: m by which the position may be off while the picture is explained nearly as well.
        angle_spread: rad by which the orientation may be.
        surface_spread: m by which a point of the surface may be.
    """

    expected: int
    shown: int
    supported: int
    through: int
    before: int
    gain: float
    margin: float
    colour: float
    own_colour: float
    position_spread: float
    angle_spread: float
    surface_spread: float


NEAR = 0.004  # m of the surface, up to which a look speaks for a pose


@dataclass(frozen=True)
class Agreement:
    """How another look agrees with a pose.

    Attributes:
        confidence: That of the other look in its own pose.
        off: By how much the poses differ, symmetries aside.
        n_prints: How many of both looks recognised the print.
    """

    confidence: float
    off: PoseNoise
    n_prints: int = 0

    @property
    def is_near(self) -> bool:
        """Whether the other look speaks for the pose."""
        return self.off.displacement is not None and self.off.displacement < NEAR

    @property
    def is_by_print(self) -> bool:
        """Whether both looks recognised the print there."""
        return self.n_prints == 2 and self.is_near

    @property
    def is_doubtful(self) -> bool:
        """Whether a look recognised the print where the other has the item elsewhere."""
        return self.n_prints > 0 and not self.is_near


@dataclass(frozen=True, eq=False)
class ItemObservation:
    """The answer for one listed item.

    Attributes:
        id: Id in the list: the item's name, or name#2 for a second copy.
        item: The item.
        T_world_item: (4, 4) pose; None if no place was found at all.
        confidence: Probability that the pose is within 10 mm and 10 degrees, symmetries aside; 0 without a
            pose.
        refusal: Why the pose is not to be used; "" if it is.
        bound: Bounds of the error of the pose, in which 99 of 100 should be; None if it is not sure enough
            for any.
        support: How much of the picture speaks for it; None without a pose.
        agreement: How another look agrees with it; None by a single look, or without a pose.
        found_by: By what it was found.
        route: By what it was looked for; None if that is not known any more.
    """

    id: str
    item: Item
    T_world_item: Array | None
    confidence: float
    refusal: str
    bound: PoseNoise | None
    support: Support | None
    agreement: Agreement | None = None
    found_by: FoundBy = FoundBy.SHAPE
    route: ItemRoute | None = None

    @property
    def is_answer(self) -> bool:
        """Whether the pose is given as an answer."""
        return not self.refusal


@dataclass(frozen=True, eq=False)
class UnexplainedPart:
    """Points side by side that no answer explains: of an item that was refused, or is not listed.

    Attributes:
        n_pixels: Number of points.
        low: (3,) m, lower corner of the box around them in the place's frame.
        high: (3,) m, its upper corner.
    """

    n_pixels: int
    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
class PlaceObservation:
    """The answers for the listed items of one place.

    Attributes:
        place: Name of the place.
        T_world_place: (4, 4) its pose.
        items: The answers, in the order of the list.
        unexplained: What else was measured before the known place, the largest part first.
        seen: Share of its room that is in sight, were no items in it.
        unknown: (N, 2, 3) m, lower and upper corners of boxes in the place's frame: space that nobody has
            seen, or that holds what no answer with a bound explains.
        error: Bounds of the error of ``T_world_place``.
        unrecognised: (M, 2, 3) m, boxes alike: what was measured that no answer with a bound explains, and
            where an item was found that is not sure enough.
    """

    place: str
    T_world_place: Array
    items: tuple[ItemObservation, ...]
    unexplained: tuple[UnexplainedPart, ...] = ()
    seen: float = 1.0
    unknown: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))
    error: Displacement = UNMOVED
    unrecognised: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))

    @property
    def refused(self) -> tuple[ItemObservation, ...]:
        """The listed items without an answer."""
        return tuple(item for item in self.items if not item.is_answer)

    @property
    def has_unlisted(self) -> bool:
        """Whether there is more than the list says: something unexplained, though every item is found."""
        return bool(self.unexplained) and not self.refused
