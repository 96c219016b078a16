"""Critical pairs: pairs of named configurations that must not depend on a single edge of the roadmap."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.station import Pod

NamePair = tuple[str, str]

# Motions of every order: from home and from each bin or camera pose to the tote and its drop poses, from home
# to the bins, and from a bin to the pose from which the camera sees into it.
_KINDS = (("home", "tote"), ("bin", "tote"), ("camera", "tote"), ("home", "drop"), ("bin", "drop"),
          ("camera", "drop"), ("home", "bin"))  # fmt: skip


def critical_pairs(cell: Cell) -> list[NamePair]:
    """List the pairs that need a second route in case an edge is blocked.

    They follow from the kinds of the two ends (see ``_KINDS``); also each bin with its camera pose, and each
    bin with those that adjoin it in the pod, into which blocking items are put aside.

    Args:
        cell: The cell.

    Returns:
        Pairs of names, each sorted, sorted; none twice.
    """
    by_kind: dict[str, list[NamedConfiguration]] = defaultdict(list)
    for named in cell.configurations.values():
        by_kind[named.kind].append(named)
    bins, cameras = by_kind["bin"], by_kind["camera"]
    pairs = {(a.name, b.name) for one, two in _KINDS for a in by_kind[one] for b in by_kind[two]}
    pairs |= {(a.name, b.name) for a in bins for b in cameras if a.place == b.place}
    pairs |= {(a, b) for a, b in neighbouring_bins(cell.pod) if {a, b} <= {each.name for each in bins}}
    return sorted({(min(pair), max(pair)) for pair in pairs})


def neighbouring_bins(pod: Pod) -> Iterator[NamePair]:
    """List bins side by side in a row, and bins of consecutive rows that overlap horizontally.

    Args:
        pod: The pod.

    Yields:
        Names of two adjoining bins.
    """
    rows: dict[float, list[Place]] = {}
    for each in pod.bins.values():
        rows.setdefault(round(float(each.T_carrier_place[2, 3]), 3), []).append(each)
    for row in rows.values():
        for left, right in pairwise(sorted(row, key=lambda each: -float(each.T_carrier_place[1, 3]))):
            yield left.name, right.name
    for low, high in pairwise(rows[z] for z in sorted(rows)):
        yield from ((a.name, b.name) for a in high for b in low if _overlap(a, b))


def _overlap(a: Place, b: Place) -> bool:
    """Whether the mouths of two bins overlap horizontally."""
    apart = abs(float(a.T_carrier_place[1, 3] - b.T_carrier_place[1, 3]))
    return apart < (a.access.width + b.access.width) / 2
