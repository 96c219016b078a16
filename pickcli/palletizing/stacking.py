"""Stacks the cartons of an order: one after the other where they stand lowest, proven to stand at any time.

With the whole order known, several sequences are stacked, and that which leaves the fewest is repaired: what
it left comes earlier in the next one (D. Joslin, D. Clements, "Squeaky wheel optimization", Journal of
Artificial Intelligence Research 10, 1999). As cartons come one by one, the sequence is theirs, and of a few
places the one is taken after which the next cartons that are already seen find the lowest places.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.palletizing.landing_places import PlacementArrays, landing_places
from pickcli.palletizing.pallet_order import (
    CENTRE_ERROR,
    LEVEL,
    ROUNDED,
    Carton,
    PalletOrder,
    least_contact,
    least_margin,
)
from pickcli.palletizing.pallet_stack import PalletStack, Placement
from pickcli.palletizing.support_polygon import EMPTY, clipped, depth_inside, hull, rectangle
from pickcli.seeds import derived_rng

LEAST_AREA = 0.55  # of a base over what bears it: cardboard sags beyond
MOST_TRIED = 300  # places of a carton, the lowest first, whose support is worked out
N_COMPARED = 3  # places that are compared by what comes next
LAYER = 0.1  # m by which heights are told apart where cartons that are about as high come together
FILLED = (0.57, 0.64)  # shares of the room that the smallest cartons of too large an order may fill
N_REPAIRED = 16  # further sequences with the whole order known, while something is left
EARLIER = (0.05, 0.5)  # share of a sequence by which what was left of it comes earlier in the next
ABOVE = 0.05  # m over the highest carton, from which others come down
OTHERWISE = 0.05  # m of height that lying across is worth, where all are to lie along one side
BESIDE = 0.15  # m of height that sides beside others all round are worth
AREA = 0.1  # m of height that a base wholly over others is worth


class _Pallet:
    """What is on the pallet so far.

    order: what is stacked. across: whether cartons are to be turned, if that is preferred
    """

    def __init__(self, order: PalletOrder, across: bool | None = None) -> None:
        self._order, self._across = order, across
        self.placed: list[Placement] = []
        self._mass, self._loads = 0.0, list[float]()  # kg, of all and on each
        self._below: list[frozenset[int]] = []  # those that bear each, directly or through others
        self._arrays = PlacementArrays.of((), ())

    def copy(self) -> _Pallet:
        """Return another that is the same now."""
        other = _Pallet(self._order, self._across)
        other.placed, other._below = list(self.placed), list(self._below)
        other._mass, other._loads, other._arrays = self._mass, list(self._loads), self._arrays
        return other

    def put(self, placement: Placement) -> None:
        """Put a carton on it."""
        on = {k for k, p in enumerate(self.placed) if p.carton.id in placement.rests_on}
        self._below.append(frozenset(on.union(*(self._below[k] for k in on))))
        self.placed.append(placement)
        self._mass += placement.carton.mass
        self._loads.append(0.0)
        for k in sorted(self._below[-1]):
            self._loads[k] += placement.carton.mass
        own = [p.carton.bears - load for p, load in zip(self.placed, self._loads, strict=True)]
        spare = [min(own[k] for k in (i, *below)) for i, below in enumerate(self._below)]
        self._arrays = PlacementArrays.of(self.placed, spare)

    def places(self, carton: Carton, n_most: int) -> list[Placement] | Failures:
        """Return the best places where a carton stands, the best first; or why there is none."""
        bears = self._order.pallet.bears
        if self._mass + carton.mass > bears + ROUNDED:
            return Failures((Reason("too heavy", carton.id, f"the pallet bears {bears:g} kg in all"),))
        found: list[Placement] = []
        lows, turns, against = self._candidates(carton)
        for low, is_turned in zip(lows, turns, strict=True):
            placement = self._standing(carton, low, is_turned)
            if placement is None:
                against["would tip"] += 1
            else:
                found.append(placement)
            if len(found) == n_most:
                break
        return found or self._why_not(carton, against)

    def _candidates(self, carton: Carton) -> tuple[Array, list[bool], Counter[str]]:
        """Return landing places, the cheapest first, that overload nothing, and where it may not tip.

        Lower corners (N, 3) and whether turned; and how many more there are, by what is wrong with them.
        """
        costs, lows, turns = [], [], []
        against: Counter[str] = Counter()
        around = 2.0 * (carton.size[0] + carton.size[1])
        for places in landing_places(self._order, self._arrays, carton):
            sags = places.supported_share < LEAST_AREA
            crushes = ~sags & (places.spare < carton.mass - ROUNDED)
            half = np.array(carton.size[:2])[[1, 0] if places.is_turned else [0, 1]] / 2
            most, centre = 2 * CENTRE_ERROR * half, places.low[:, :2] + half
            is_within = (places.borne_low <= centre - most) & (centre + most <= places.borne_high)
            stands = is_within.all(axis=1)
            against["would crush what bears it"] += int(crushes.sum())
            against["would tip"] += int((~sags & ~crushes & ~stands).sum())
            kept = ~sags & ~crushes & stands
            cost = places.low[:, 2] + carton.size[2] - BESIDE * places.beside / around
            cost += OTHERWISE * (self._across is not None and places.is_turned != self._across)
            costs.append((cost - AREA * places.supported_share)[kept])
            lows.append(places.low[kept])
            turns += [places.is_turned] * int(kept.sum())
        cost, low = np.concatenate([*costs, []]), np.concatenate([*lows, np.empty((0, 3))])
        first = np.lexsort((*low.T[::-1], turns, np.round(cost, 9)))[:MOST_TRIED]
        return low[first], [turns[k] for k in first.tolist()], against

    def _standing(self, carton: Carton, low: Array, is_turned: bool) -> Placement | None:
        """Return a placement, if a carton stands in it."""
        above = float(self._arrays.high[:, 2].max(initial=0.0)) + ABOVE
        placement = Placement(carton, low, is_turned, (), EMPTY, above)
        if low[2] == 0.0:
            return replace(placement, bears_within=rectangle(low[:2], placement.high[:2]))
        there = self._arrays
        shared = (np.minimum(there.high, placement.high) - np.maximum(there.low, low))[:, :2].min(axis=1)
        is_level = np.abs(there.high[:, 2] - low[2]) <= LEVEL
        bearers = np.flatnonzero(is_level & (shared > ROUNDED)).tolist()
        firm = [self.placed[k] for k in bearers if shared[k] >= least_contact(self._order.clearance)]
        pieces = [clipped(p.bears_within, low[:2], placement.high[:2]) for p in firm]
        within = hull(np.concatenate([EMPTY, *pieces]))
        off = CENTRE_ERROR * placement.size[:2] * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
        margin = least_margin(self._order.fall, carton.size[2])
        if depth_inside(within, placement.centre[:2] + off) < 0.0:
            return None
        if margin > 0.0 and depth_inside(within, placement.centre[None, :2]) < margin:
            return None
        names = tuple(self.placed[k].carton.id for k in bearers)
        return replace(placement, rests_on=names, bears_within=within)

    def _why_not(self, carton: Carton, against: Counter[str]) -> Failures:
        if not against.total():
            size = " x ".join(f"{side:g}" for side in carton.size)
            detail = f"{size} m: nowhere on what stands there is over half of it borne"
            return Failures((Reason("no room", carton.id, detail),))
        detail = ", ".join(f"it {what} at {n} place{'s' * (n > 1)}" for what, n in against.most_common() if n)
        return Failures((Reason("does not stand", carton.id, detail),))


def stack_all(order: PalletOrder, seed: int = 0) -> PalletStack:
    """Stack an order that is known as a whole, in a sequence of our own.

    Args:
        order: The order.
        seed: Seed of the sequences that are drawn.

    Returns:
        The stack with the most cartons, of several the fullest.
    """
    sequences = [sorted(order.cartons, key=key) for key in SEQUENCES] + [list(order.cartons)]
    sequences += _smallest_first(order)
    tried = [(_in_turns(order, sequence), sequence) for sequence in sequences]
    tried += [(_in_turns(order, sequences[0], across), sequences[0]) for across in (False, True)]
    best, sequence = max(tried, key=lambda each: _quality(each[0]))
    rng = derived_rng(seed, "pallet")
    for _ in range(N_REPAIRED):
        if not best.left:
            break
        repaired = _with_left_earlier(sequence, best, rng)
        stack = _in_turns(order, repaired)
        if _quality(stack) >= _quality(best):
            best, sequence = stack, repaired
    return best


def _smallest_first(order: PalletOrder) -> list[list[Carton]]:
    """Return sequences of too large an order: first the smallest cartons, up to a share of the room."""
    pallet = order.pallet
    room = pallet.size[0] * pallet.size[1] * (pallet.height - pallet.deck)
    ordered = sorted(order.cartons, key=_volume)
    filled = np.cumsum([_volume(carton) for carton in ordered]) / room
    numbers = [int(np.searchsorted(filled, share)) for share in FILLED if filled[-1] > share]
    return [sorted(ordered[:n], key=_by_height) + ordered[n:] for n in numbers]


def _quality(stack: PalletStack) -> tuple[int, float]:
    return len(stack.placements), stack.fill


def _with_left_earlier(
    sequence: Sequence[Carton], stack: PalletStack, rng: np.random.Generator
) -> list[Carton]:
    """Return a sequence in which what was left of it comes earlier, each by a random share of the whole."""
    ranks = [
        k - (carton.id in stack.left) * rng.uniform(*EARLIER) * len(sequence)
        for k, carton in enumerate(sequence)
    ]
    return [sequence[k] for k in np.argsort(ranks, kind="stable")]


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
        elif len(places) == 1:
            pallet.put(places[0])
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


def _area(carton: Carton) -> float:
    return carton.size[0] * carton.size[1]


def _volume(carton: Carton) -> float:
    return _area(carton) * carton.size[2]


def _by_height(carton: Carton) -> tuple[float, ...]:
    return -carton.size[2], -_area(carton)


# Keys by which cartons are sorted; with those as high as each other next to each other, layers become level.
SEQUENCES: tuple[Callable[[Carton], tuple[float, ...]], ...] = (
    lambda c: (-_area(c), -c.size[2]),
    lambda c: (-_volume(c),),
    _by_height,
    lambda c: (-round(c.size[2] / LAYER), -_area(c), -c.size[2]),
    lambda c: (-c.mass, -_area(c)),
)
