"""Random orders of a pallet: cartons of a few kinds, many of them alike, as wholesale orders are.

Sizes and masses are those of the five public orders of BED-BPP (F. Kagerer et al., IJRR 42(14), 2023): sides
of 0.1 to 0.6 m, 0.2 to 25 kg.
"""

from __future__ import annotations

import numpy as np

from pickcli.palletizing.pallet_order import CONTAINERS, Carton, Pallet, PalletOrder
from pickcli.seeds import derived_rng

SIDES, HEIGHTS = (0.15, 0.6), (0.1, 0.4)  # m
DENSITIES = (60.0, 450.0)  # kg/m3
MASSES = (0.2, 25.0)  # kg
PER_KIND = 4.0  # cartons of a kind, mean
EUR_PALLET = CONTAINERS["eur_pallet"]
BEARS = 12.0  # times its own mass that a carton bears


def random_pallet_order(n_cartons: int, seed: int, pallet: Pallet = EUR_PALLET) -> PalletOrder:
    """Draw an order.

    Args:
        n_cartons: Number of cartons.
        seed: Seed of all random choices.
        pallet: What they are stacked on.

    Returns:
        The order.
    """
    rng = derived_rng(seed, "pallet order")
    cartons: list[Carton] = []
    while len(cartons) < n_cartons:
        length, width = sorted((round(_drawn(rng, SIDES), 2) for _ in range(2)), reverse=True)
        height = round(_drawn(rng, HEIGHTS), 2)
        density = _drawn(rng, DENSITIES)
        mass = round(float(np.clip(length * width * height * density, *MASSES)), 1)
        for _ in range(min(1 + rng.poisson(PER_KIND - 1.0), n_cartons - len(cartons))):
            name = f"carton_{len(cartons) + 1:03d}"
            cartons.append(Carton(name, (length, width, height), mass, round(BEARS * mass, 1)))
    shuffled = [cartons[k] for k in rng.permutation(n_cartons)]
    return PalletOrder(pallet, tuple(shuffled))


def _drawn(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    """Draw a figure whose logarithm is uniform."""
    return float(np.exp(rng.uniform(*np.log(bounds))))
