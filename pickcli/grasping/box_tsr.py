"""KTH's task space regions: ``.tsrs`` files, lists of ``!BoxTSR`` with extents of poses in an item's frame.

Six extents [least, greatest]: x, y, z in m of the cup's centre, then the angles a, b, c in rad of the tool's
orientation Rx(c) Ry(b) Rz(a), whose z axis points into the item. The files do not state the convention; of
all orders of three rotations it is the one in which every tool points at the surface that its region lies on,
and turns freely about its own axis there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.files.file_kind import TSRS
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array, rotation_axis_angle

TAG = "!BoxTSR"
MAX_REGIONS = 10_000  # regions of a file
MAX_DISTANCE = 2.0  # m, bound of every position in a file
MOST_ANGLE = 2.0 * np.pi
_AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class BoxTsr:
    """A task space region of a file.

    Attributes:
        bounds: (6, 2) least and greatest x, y, z in m and a, b, c in rad.
    """

    bounds: Array

    @property
    def corners(self) -> Array:
        """(2, 3) least and greatest position of the cup's centre, m."""
        return np.asarray(self.bounds[:3].T)

    @property
    def approach(self) -> Array:
        """(3,) unit vector of the tool's approach, for the middle of the angles."""
        return np.asarray(orientation(*self.bounds[3:].mean(axis=1))[:, 2])


def orientation(a: float, b: float, c: float) -> Array:
    """Return the orientation of a tool.

    Args:
        a: rad about z.
        b: rad about y.
        c: rad about x.

    Returns:
        (3, 3) rotation of the tool in the item's frame.
    """
    x, y, z = _AXES
    return np.asarray(rotation_axis_angle(x, c) @ rotation_axis_angle(y, b) @ rotation_axis_angle(z, a))


def read_box_tsrs(path: Path) -> tuple[BoxTsr, ...]:
    """Read a file of regions. Its only tag, ``!BoxTSR``, is ignored: nothing in the file is executed.

    Args:
        path: The file.

    Returns:
        The regions.

    Raises:
        InputError: The file is larger than 1 MB or not a list of regions; with every mistake and its place.
    """
    source = read_yaml(path, TSRS, tags=frozenset((TAG,)))
    entries = source.data
    if not isinstance(entries, list) or not entries:
        source.add((), f"expected a list of {TAG} with extents; {TSRS.origin}")
    elif len(entries) > MAX_REGIONS:
        source.add((), f"{len(entries)} regions; at most {MAX_REGIONS} are read")
    else:
        for k, entry in enumerate(entries):
            for key, fault in _faults(entry):
                source.add((k, *key), fault)
    source.check()
    return tuple(BoxTsr(np.array(entry["extents"], np.float64)) for entry in entries)


def _faults(entry: Any) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield the faults of a region, each with its place in it."""
    if not isinstance(entry, dict) or list(entry) != ["extents"]:
        yield (), "expected extents and nothing else"
        return
    extents = entry["extents"]
    if not isinstance(extents, list) or len(extents) != 6:
        yield ("extents",), "expected six pairs [least, greatest]: x, y, z in m and three angles in rad"
        return
    for i, pair in enumerate(extents):
        most = MAX_DISTANCE if i < 3 else MOST_ANGLE
        is_pair = isinstance(pair, list) and len(pair) == 2 and all(_is_number(end) for end in pair)
        if not is_pair:
            yield ("extents", i), "expected two numbers [least, greatest]"
        elif not -most <= pair[0] <= pair[1] <= most:
            yield ("extents", i), f"expected -{most:.4g} <= least <= greatest <= {most:.4g}, got {pair}"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
