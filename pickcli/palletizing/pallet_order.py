"""Order of a pallet: what is to be stacked, and on what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array

ROUNDED = 1e-6  # m or kg, by which limits may be exceeded
CLEARANCE = 0.005  # m between a carton that comes down and those beside it, as large as errors of its pose
LEVEL = 5e-4  # m by which tops that bear the same carton may differ in height
LEAST_CONTACT = 1e-3  # m
CENTRE_ERROR = 0.05  # of each side, by which the centre of mass of a carton may be off its middle
SIDES = ("-x", "+x", "-y", "+y")


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
        walls: Those of ``SIDES`` that have a wall, from the deck to the height.
        edge: m that cartons keep from edges of the deck without a wall.
    """

    size: tuple[float, float] = (1.2, 0.8)
    deck: float = 0.144
    height: float = 2.0
    bears: float = 1500.0
    walls: tuple[str, ...] = ()
    edge: float = 0.0

    def room(self, clearance: float) -> tuple[Array, Array]:
        """Return the part of the deck over which cartons may come down.

        Args:
            clearance: m that they keep from walls.

        Returns:
            Its lower and its upper corner, (2,) m each.
        """
        off = np.array([clearance if side in self.walls else self.edge for side in SIDES]).reshape(2, 2)
        half = np.array(self.size) / 2
        return -half + off[:, 0], half - off[:, 1]


# EUR 1 and EUR 6 of the European Pallet Association, and a common roll container with frames on three sides.
CONTAINERS = {
    "eur_pallet": Pallet(),
    "half_pallet": Pallet((0.8, 0.6), bears=500.0),
    "roll_container": Pallet((0.8, 0.7), 0.2, 2.0, 500.0, ("-x", "+x", "+y")),
}


@dataclass(frozen=True)
class PalletOrder:
    """An order.

    Attributes:
        pallet: The pallet.
        cartons: What is to be stacked, in the sequence in which it comes.
        clearance: m that a carton keeps from others beside it as it comes down.
        fall: m that it may fall onto others as it is let go, without turning over their edges.
    """

    pallet: Pallet
    cartons: tuple[Carton, ...]
    clearance: float = CLEARANCE
    fall: float = 0.0


def least_contact(clearance: float) -> float:
    """Return how wide a contact is at least to bear: narrower ones may not be there where poses are off.

    Args:
        clearance: m between cartons beside each other, as large as errors of their poses.

    Returns:
        m.
    """
    return max(clearance, LEAST_CONTACT)


def least_margin(fall: float, height: float) -> float:
    """Return how far a carton's middle must be inside of what bears it, for a fall not to turn it over.

    All energy of the fall goes into a turn about the nearest edge, which lifts the middle of the carton.

    Args:
        fall: m.
        height: m, of the carton.

    Returns:
        m, seen from above.
    """
    return float(np.sqrt(fall * (fall + height)))
