"""Order of a pallet: what is to be stacked, and on what."""

from __future__ import annotations

from dataclasses import dataclass

ROUNDED = 1e-6  # m or kg, by which limits may be exceeded
CLEARANCE = 0.005  # m between a carton that comes down and those beside it, as large as errors of its pose


@dataclass(frozen=True)
class Carton:
    """A carton to be stacked.

    Attributes:
        id: Its name in the order.
        size: (3,) m: length, width and height, as it stands; it may be turned about the vertical.
        mass: kg.
        bears: kg that may stand on it, with all that stands on that; infinite if nothing is stated.
    """

    id: str
    size: tuple[float, float, float]
    mass: float
    bears: float = float("inf")


@dataclass(frozen=True)
class Pallet:
    """What cartons are stacked on. Its frame is in the middle of its deck, z up, x along the length.

    Attributes:
        size: (2,) m: length and width of the deck.
        deck: m, height of the deck over the floor.
        height: m over the floor, that nothing stacked exceeds.
        bears: kg of all cartons.
    """

    size: tuple[float, float] = (1.2, 0.8)
    deck: float = 0.144
    height: float = 2.0
    bears: float = 1500.0


@dataclass(frozen=True)
class PalletOrder:
    """An order.

    Attributes:
        pallet: The pallet.
        cartons: What is to be stacked, in the sequence in which it comes.
        clearance: m that a carton keeps from others beside it as it comes down.
    """

    pallet: Pallet
    cartons: tuple[Carton, ...]
    clearance: float = CLEARANCE
