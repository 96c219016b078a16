"""Stacks the cartons of an order: one after the other where they stand lowest, proven to stand at any time.

With the whole order known, several sequences are stacked, and the one that leaves the fewest is kept. As
cartons come one by one, the sequence is theirs, and of a few places the one is taken after which the next
cartons that are already seen find the lowest places.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.palletizing.landing_places import landing_places
from pickcli.palletizing.pallet_order import CENTRE_ERROR, LEVEL, ROUNDED, Carton, PalletOrder, least_contact
from pickcli.palletizing.pallet_stack import PalletStack, Placement, all_bearing
from pickcli.palletizing.support_polygon import EMPTY, clipped, depth_inside, hull, rectangle
from pickcli.seeds import derived_rng

LEAST_AREA = 0.55  # of a base over what bears it: cardboard sags beyond
MOST_TRIED = 300  # places of a carton, the lowest first, whose support is worked out
N_COMPARED = 3  # places that are compared by what comes next
N_SHUFFLED = 2  # further sequences with the whole order known
SHUFFLE = 0.3  # of the logarithm of a volume, by which these vary
ABOVE = 0.05  # m over the highest carton, from which others come down
OTHERWISE = 0.05  # m of height that lying across is worth, where all are to lie along one side
BESIDE = 0.15  # m of height that sides beside others all round are worth
AREA = 0.1  # m of height that a base wholly over others is worth


@dataclass
class _Pallet:
    """What is on the pallet so far."""

    order: PalletOrder
    across: bool | None = None  # whether cartons are to be turned, if that is preferred
    placed: list[Placement] = field(default_factory=list)
    loads: Counter[str] = field(default_factory=Counter)  # kg on each carton

    def copy(self) -> _Pallet:
        return _Pallet(self.order, self.across, list(self.placed), Counter(self.loads))

    def put(self, placement: Placement) -> None:
        """Put a carton on it."""
        self.placed.append(placement)
        for name in all_bearing(self.placed, placement.rests_on):
            self.loads[name] += placement.carton.mass  # type: ignore[assignment]

    def places(self, carton: Carton, n_most: int) -> list[Placement] | Failures:
        """Return the best places where a carton stands, the best first; or why there is none."""
        bears = self.order.pallet.bears
        if sum(p.carton.mass for p in self.placed) + carton.mass > bears + ROUNDED:
            return Failures((Reason("too heavy", carton.id, f"the pallet bears {bears:g} kg in all"),))
        found: list[Placement] = []
        against: Counter[str] = Counter()
        for _, low, is_turned in self._candidates(carton):
            placement = self._standing(carton, low, is_turned)
            if isinstance(placement, str):
                against[placement] += 1
            else:
                found.append(placement)
            if len(found) == n_most:
                break
        return found or self._why_not(carton, against)

    def _candidates(self, carton: Carton) -> list[tuple[float, Array, bool]]:
        """Return the cheapest landing places: cost (m), lower corner (3,), whether turned."""
        found = []
        for places in landing_places(self.order, self.placed, carton):
            around = 2.0 * (carton.size[0] + carton.size[1])
            costs = places.low[:, 2] + carton.size[2] - BESIDE * places.beside / around
            costs -= AREA * places.bearing_area
            costs += OTHERWISE * (self.across is not None and places.is_turned != self.across)
            costs[places.bearing_area < LEAST_AREA] = np.inf  # it would sag
            for k in np.argsort(costs, kind="stable")[:MOST_TRIED].tolist():
                if np.isfinite(costs[k]):
                    found.append((float(costs[k]), places.low[k], places.is_turned))
        found.sort(key=lambda place: (round(place[0], 9), place[2], tuple(place[1].tolist())))
        return found[:MOST_TRIED]

    def _standing(self, carton: Carton, low: Array, is_turned: bool) -> Placement | str:
        """Return a placement in which a carton stands, and overloads nothing; or what is wrong with it."""
        top = max((float(p.high[2]) for p in self.placed), default=0.0)
        placement = Placement(carton, low, is_turned, (), EMPTY, top + ABOVE)
        bearers = () if low[2] == 0.0 else tuple(p for p in self.placed if _touches(p, placement))
        if bearers:
            firm = [p for p in bearers if _contact(p, placement).min() >= least_contact(self.order.clearance)]
            pieces = [clipped(p.bears_within, low[:2], placement.high[:2]) for p in firm]
            within = hull(np.concatenate([EMPTY, *pieces]))
        else:
            within = rectangle(low[:2], placement.high[:2])
        off = CENTRE_ERROR * placement.size[:2] * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
        if depth_inside(within, placement.centre[:2] + off) < 0.0:
            return "would tip"
        names = tuple(p.carton.id for p in bearers)
        limits = {p.carton.id: p.carton.bears for p in self.placed}
        if any(
            self.loads[name] + carton.mass > limits[name] + ROUNDED
            for name in all_bearing(self.placed, names)
        ):
            return "would crush what bears it"
        return replace(placement, rests_on=names, bears_within=within)

    def _why_not(self, carton: Carton, against: Counter[str]) -> Failures:
        if not against:
            size = " x ".join(f"{side:g}" for side in carton.size)
            detail = f"{size} m: nowhere on what stands there is over half of it borne"
            return Failures((Reason("no room", carton.id, detail),))
        detail = ", ".join(f"it {what} at {n} place{'s' * (n > 1)}" for what, n in against.most_common())
        return Failures((Reason("does not stand", carton.id, detail),))


def stack_all(order: PalletOrder, seed: int = 0) -> PalletStack:
    """Stack an order that is known as a whole, in a sequence of our own.

    Args:
        order: The order.
        seed: Seed of the sequences that are drawn.

    Returns:
        The stack with the most cartons, of several the fullest.
    """
    rng = derived_rng(seed, "pallet")
    sequences = [sorted(order.cartons, key=key) for key in SEQUENCES] + [list(order.cartons)]
    stacks = [_in_turns(order, sequence) for sequence in sequences]
    stacks += [_in_turns(order, sequences[0], across) for across in (False, True)]
    stacks += [_in_turns(order, _shuffled(order.cartons, rng)) for _ in range(N_SHUFFLED)]
    return max(stacks, key=lambda stack: (len(stack.placements), stack.fill))


def stack_as_they_come(order: PalletOrder, look_ahead: int = 0) -> PalletStack:
    """Stack an order in the sequence in which its cartons come; what has no place then is left.

    Args:
        order: The order.
        look_ahead: Number of cartons after the present one that are seen.

    Returns:
        The stack.
    """
    pallet, left = _Pallet(order), {}
    for k, carton in enumerate(order.cartons):
        following = order.cartons[k + 1 : k + 1 + look_ahead]
        places = pallet.places(carton, N_COMPARED if following else 1)
        if isinstance(places, Failures):
            left[carton.id] = places
        else:
            pallet.put(min(places, key=lambda place: _cost_of_next(pallet, place, following)))
    return PalletStack(order, tuple(pallet.placed), left)


def _in_turns(order: PalletOrder, sequence: Sequence[Carton], across: bool | None = None) -> PalletStack:
    """Stack cartons in a sequence; those without a place are tried again as long as others are put up."""
    pallet, waiting = _Pallet(order, across), list(sequence)
    while True:
        left: dict[str, Failures] = {}
        in_vain: set[tuple[object, ...]] = set()  # kinds of cartons that have no place on what is there
        for carton in waiting:
            kind = (carton.size, carton.mass, carton.bears)
            if kind in in_vain:
                left[carton.id] = Failures((Reason("no place", carton.id, "one that is like it has none"),))
                continue
            places = pallet.places(carton, 1)
            if isinstance(places, Failures):
                left[carton.id] = places
                in_vain.add(kind)
            else:
                pallet.put(places[0])
                in_vain.clear()
        if len(left) in (0, len(waiting)):
            return PalletStack(order, tuple(pallet.placed), left)
        waiting = [carton for carton in waiting if carton.id in left]


def _cost_of_next(pallet: _Pallet, place: Placement, following: Sequence[Carton]) -> tuple[int, float]:
    """How many of the next cartons have no place after one, and how high (m) they and it reach in all."""
    trial, missing, heights = pallet.copy(), 0, float(place.high[2])
    trial.put(place)
    for carton in following:
        places = trial.places(carton, 1)
        if isinstance(places, Failures):
            missing += 1
        else:
            trial.put(places[0])
            heights += float(places[0].high[2])
    return missing, heights


def _touches(lower: Placement, upper: Placement) -> bool:
    """Whether a carton bears one whose lower side is as high as its top."""
    return bool(abs(lower.high[2] - upper.low[2]) <= LEVEL and (_contact(lower, upper) > ROUNDED).all())


def _contact(a: Placement, b: Placement) -> Array:
    """Return the width (2,) m of what two cartons have above each other, negative if they are apart."""
    return np.asarray((np.minimum(a.high, b.high) - np.maximum(a.low, b.low))[:2])


def _area(carton: Carton) -> float:
    return carton.size[0] * carton.size[1]


def _shuffled(cartons: Sequence[Carton], rng: np.random.Generator) -> list[Carton]:
    """Return cartons from large to small, more or less."""
    off = rng.normal(0.0, SHUFFLE, len(cartons))
    keys = [-np.log(_area(c) * c.size[2]) + d for c, d in zip(cartons, off, strict=True)]
    return [cartons[k] for k in np.argsort(keys, kind="stable")]


SEQUENCES: tuple[Callable[[Carton], tuple[float, ...]], ...] = (
    lambda c: (-_area(c), -c.size[2]),
    lambda c: (-_area(c) * c.size[2],),
    lambda c: (-c.size[2], -_area(c)),
    lambda c: (-c.mass, -_area(c)),
)  # keys by which cartons are sorted
