"""Orders: contents of places before a task, and the wanted items."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from pickcli.cell.station import TOTE
from pickcli.errors import InputError

ANY_BIN = "any bin"  # destination of each item of a stow

TIME_LIMIT = {2015: 20 * 60.0, 2016: 15 * 60.0}  # s
MOVE_TIME = 60.0  # s for each of an order's moves, which no rules limit


class OrderKind(StrEnum):
    """Kind of an order."""

    PICK = "pick"  # move the targets of the work order from their bins into the tote
    STOW = "stow"  # move everything from the tote into bins
    OUTPUT = "output"  # not an order but the state after one: no work order and an empty tote
    MOVE = "move"  # move items from place to place


@dataclass(frozen=True)
class Target:
    """One line of a work order: one copy of an item, its place, and its destination.

    Attributes:
        bin: Name of the bin, or other place.
        item: Name of the item.
        into: Name of the destination; ``ANY_BIN`` if any bin will do.
    """

    bin: str
    item: str
    into: str = TOTE


@dataclass(frozen=True)
class Order:
    """Contents before the task (after it, for OUTPUT), and the wanted items.

    Attributes:
        kind: Kind of the order.
        year: 2015 or 2016, by the format of the file; selects the rules and the items' figures.
        bin_contents: Names of items by bin, in the order of the bins; duplicates are copies. For a MOVE by
            place.
        tote_contents: Names of the items in the tote.
        work_order: The targets of a pick, or the moves, in their order.
    """

    kind: OrderKind
    year: int
    bin_contents: dict[str, tuple[str, ...]]
    tote_contents: tuple[str, ...]
    work_order: tuple[Target, ...]

    @property
    def contents(self) -> dict[str, tuple[str, ...]]:
        """Names of all items by place, including a tote that is not empty."""
        return self.bin_contents | ({TOTE: self.tote_contents} if self.tote_contents else {})

    @property
    def targets(self) -> tuple[Target, ...]:
        """Targets to be moved: the work order, or for a stow all items in the tote, in order."""
        if self.kind is not OrderKind.STOW:
            return self.work_order
        return tuple(Target(TOTE, name, ANY_BIN) for name in self.tote_contents)

    def is_met(self, target: Target, place: str) -> bool:
        """Whether a target in a place has reached its destination.

        Args:
            target: One of the order's targets.
            place: Name of the place.

        Returns:
            True if it has.
        """
        return place in self.bin_contents if target.into == ANY_BIN else place == target.into


def require_playable(order: Order, where: str = "the order") -> Order:
    """Refuse an order that cannot be played.

    Args:
        order: The order.
        where: Name of its file, for messages.

    Returns:
        The order.

    Raises:
        InputError: It is the state after a task, or a pick order with items in the tote.
    """
    if order.kind is OrderKind.OUTPUT:
        raise InputError(
            f"{where}: this is an {order.kind} file, with nothing to do; a trial plays pick orders (with a "
            "work_order), stow orders (with tote_contents), and moves"
        )
    if order.tote_contents and order.kind is not OrderKind.STOW:
        names = ", ".join(order.tote_contents[:3]) + (", ..." if len(order.tote_contents) > 3 else "")
        raise InputError(
            f"{where}: tote_contents names {len(order.tote_contents)} items ({names}); a pick begins with an "
            'empty tote, as in the official orders: write "tote_contents": []'
        )
    return order


def time_limit(order: Order) -> float:
    """Return the time limit of a trial.

    Args:
        order: The order of the trial.

    Returns:
        s, by the rules of the order's year; for moves a fixed time each.
    """
    return MOVE_TIME * len(order.work_order) if order.kind is OrderKind.MOVE else TIME_LIMIT[order.year]


def may_move_others(order: Order) -> bool:
    """Whether items that are no targets may be moved to other places.

    Args:
        order: The order of the trial.

    Returns:
        False in 2015, when the rules took 12 points for each, and for moves, which list everything to be
        moved. In a stow other items are moved within the tote.
    """
    return order.kind is OrderKind.STOW or (order.kind is OrderKind.PICK and order.year != 2015)
