"""Random orders of a pallet: cartons of a few kinds, many of them alike, as wholesale orders are.

Sizes and masses are those of the five public orders of BED-BPP (F. Kagerer et al., IJRR 42(14), 2023): sides
of 0.1 to 0.6 m, 0.2 to 25 kg.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.palletizing.pallet_order import CLEARANCE, CONTAINERS, ROUNDED, Carton, Pallet, PalletOrder
from pickcli.seeds import derived_rng

DENSITIES = (60.0, 450.0)  # kg/m3
LIGHTEST = 0.2  # kg
PER_KIND = 4.0  # cartons of a kind, mean
EUR_PALLET = CONTAINERS["eur_pallet"]
BEARS = 12.0  # times its own mass that a carton bears


@dataclass(frozen=True)
class CartonBounds:
    """Bounds of what is drawn, by default those of BED-BPP.

    Attributes:
        shortest: m, of sides of the base.
        longest: m, of sides of the base.
        lowest: m, of heights.
        highest: m, of heights.
        heaviest: kg.
    """

    shortest: float = 0.15
    longest: float = 0.6
    lowest: float = 0.1
    highest: float = 0.4
    heaviest: float = 25.0


def random_pallet_order(
    n_cartons: int,
    seed: int,
    pallet: Pallet = EUR_PALLET,
    sizes: CartonBounds = CartonBounds(),
    clearance: float = CLEARANCE,
) -> PalletOrder:
    """Draw an order.

    Args:
        n_cartons: Number of cartons.
        seed: Seed of all random choices.
        pallet: What they are stacked on.
        sizes: Bounds of sizes and masses.
        clearance: m between cartons beside each other.

    Returns:
        The order.
    """
    rng = derived_rng(seed, "pallet order")
    cartons: list[Carton] = []
    highest = min(sizes.highest, np.floor(100 * (pallet.height - pallet.deck) + ROUNDED) / 100)
    sides, heights = (sizes.shortest, sizes.longest), (sizes.lowest, highest)
    while len(cartons) < n_cartons:
        length, width = sorted((round(_drawn(rng, sides), 2) for _ in range(2)), reverse=True)
        height = min(round(_drawn(rng, heights), 2), highest)
        density = _drawn(rng, DENSITIES)
        mass = round(float(np.clip(length * width * height * density, LIGHTEST, sizes.heaviest)), 1)
        for _ in range(min(1 + rng.poisson(PER_KIND - 1.0), n_cartons - len(cartons))):
            name = f"carton_{len(cartons) + 1:03d}"
            cartons.append(Carton(name, (length, width, height), mass, round(BEARS * mass, 1)))
    shuffled = [cartons[k] for k in rng.permutation(n_cartons)]
    return PalletOrder(pallet, tuple(shuffled), clearance)


def _drawn(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    """Draw a figure whose logarithm is uniform."""
    return float(np.exp(rng.uniform(*np.log(bounds))))
