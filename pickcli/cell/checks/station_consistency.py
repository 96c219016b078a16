"""Consistency of a cell's pod, tote and places: figures and names."""

from __future__ import annotations

from itertools import pairwise

from pickcli.cell.checks.references import refer, unique
from pickcli.cell.makers.carrier_builder import build_carrier
from pickcli.cell.makers.grid import place_names
from pickcli.cell.makers.pod import flat_from, underside
from pickcli.cell.schemas.cell_schema import CellModel, LegsModel, PodModel, ToteModel
from pickcli.cell.schemas.place_schema import BodiesModel, GridModel
from pickcli.cell.shapes import Body
from pickcli.cell.station import OBSTACLE, POD, TOTE, UNKNOWN
from pickcli.errors import InputError
from pickcli.files.source import Key, Source

# m: 2.4 pixels of the coarsest depth camera of the package, Kinect v2, at 1.6 m, from where pods are located.
# What is narrower is in no cloud, so the cell would state as known what nobody can see.
LEAST_LEG = 0.01


def check_pod(source: Source, pod: PodModel) -> None:
    """Check that a pod's walls, boards, lips and legs are in order, and that no two bins share a name.

    Args:
        source: Collects the mistakes with their places in the file.
        pod: The pod as it stands in the file.
    """
    _ascending(
        source,
        ("divider", pod.divider + pod.divider_thickness),
        ("post", pod.post),
        ("side_wall", pod.side_wall),
        ("width", pod.width / 2),
    )
    _ascending(
        source,
        ("lip_depth", pod.lip_depth),
        ("hanging_lip_depth", pod.hanging_lip_depth),
        ("floor_slope", flat_from(pod)),  # where the slope ends
        ("back_wall", pod.back_wall),
        ("depth", pod.depth),
    )
    for i, (upper, lower) in enumerate(pairwise(pod.rows)):
        gap = upper.floor_front - pod.board_thickness - lower.ceiling_front
        if abs(gap) > 5e-4:
            source.add(
                ("pod", "rows", i + 1, "ceiling_front"),
                f"expected the underside of the board above, {lower.ceiling_front + gap:.4f} m, "
                f"got {lower.ceiling_front:g}; correct it, floor_front above or board_thickness",
            )
    if pod.legs is not None:
        _check_legs(source, pod, pod.legs)
    keys: list[Key] = [("pod", "rows", i, "bins", j) for i in range(len(pod.rows)) for j in range(3)]
    unique(source, keys, [name for row in pod.rows for name in row.bins])


def _check_legs(source: Source, pod: PodModel, legs: LegsModel) -> None:
    """Report legs that no cloud shows, that meet each other, and that reach into the lowest row."""
    for name, across, size in (("width", pod.width, legs.width), ("depth", pod.depth, legs.depth)):
        if not size < across / 2:
            text = f"two legs of {size:g} m leave nothing open of the pod's {name}, {across:g} m"
            source.add(("pod", "legs", name), f"{text}; correct one of the two")
        elif size < LEAST_LEG:
            text = f"expected at least {LEAST_LEG:g} m, which a camera sees as two pixels, got {size:g}"
            source.add(("pod", "legs", name), f"{text}; correct it, or leave the legs out")
    if legs.height is not None and legs.height < LEAST_LEG:
        text = f"expected at least {LEAST_LEG:g} m, got {legs.height:g}: nothing is open under the pod"
        source.add(("pod", "legs", "height"), f"{text}; correct it, or leave the legs out")
    if legs.height is not None and legs.height > underside(pod):
        text = (
            f"expected at most {underside(pod):.4f} m, the underside of the lowest board, got {legs.height:g}"
        )
        source.add(("pod", "legs", "height"), f"{text}; correct it, or leave it out")


def _ascending(source: Source, *places: tuple[str, float]) -> None:
    """Report each figure that is not greater than the one before."""
    for (before, low), (name, high) in pairwise(places):
        if not low < high:
            text = f"puts it at {high:.4g} m, expected beyond {low:.4g} m ({before}); correct one of the two"
            source.add(("pod", name), text)


def check_tote(source: Source, tote: ToteModel) -> None:
    """Check that the tote's flange surrounds its rim, outside the walls.

    Args:
        source: Collects the mistakes with their places in the file.
        tote: The tote as it stands in the file.
    """
    for axis, name in enumerate("xy"):
        low = tote.inner.lower[axis] - tote.wall_thickness
        high = tote.inner.upper[axis] + tote.wall_thickness
        if not tote.flange.lower[axis] <= low < high <= tote.flange.upper[axis]:
            source.add(
                ("tote", "inner"),
                f"puts the walls at {name} from {low:g} to {high:g}, expected inside the flange's "
                f"{tote.flange.lower[axis]:g} to {tote.flange.upper[axis]:g}; correct one of the two",
            )


def check_places(source: Source, model: CellModel) -> None:
    """Check that names of places are unique, that supporting bodies exist, and that meshes can be read.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
    """
    taken = [TOTE, *(name for row in (() if model.pod is None else model.pod.rows) for name in row.bins)]
    keys: list[Key] = [("pod", "rows")] * len(taken)
    for name, place in model.places.items():
        if name in (POD, TOTE, OBSTACLE, UNKNOWN):
            source.add(("places", name), f"{name!r} is the name of something else in cells; rename it")
        if isinstance(place, GridModel):
            for i, row in enumerate(place_names(name, place)):
                taken += row
                stated = place.names is not None
                keys += [
                    ("places", name, "names", i, j) if stated else ("places", name) for j in range(len(row))
                ]
            continue
        taken.append(name)
        keys.append(("places", name))
        if isinstance(place, BodiesModel):
            bodies = [part.name for part in place.bodies]
            unique(source, [("places", name, "bodies", i, "name") for i in range(len(bodies))], bodies)
            for i, each in enumerate(place.support):
                refer(source, ("places", name, "support", i), "body of this place", each, bodies)
            _check_meshes(source, name, place)
    unique(source, keys, taken)


def _check_meshes(source: Source, name: str, place: BodiesModel) -> None:
    """Report meshes that are outside the cell's folder or cannot be read."""
    folder = source.path.parent
    for i, part in enumerate(place.bodies):
        if part.mesh is None:
            continue
        key, path = ("places", name, "bodies", i, "mesh"), folder / part.mesh
        if not path.resolve().is_relative_to(folder.resolve()):
            source.add(key, f"expected a path inside the cell's folder, got {part.mesh!r}; copy it there")
            continue
        try:
            build_carrier(name, place.model_copy(update={"bodies": (part,)}), folder)
        except InputError as error:
            source.add(key, str(error))


def own_bodies(source: Source, model: CellModel) -> dict[str, tuple[Body, ...]]:
    """Return the bodies of the carriers that a cell lists under ``places``.

    Args:
        source: The cell's file.
        model: The cell as it stands in the file, its places checked.

    Returns:
        The bodies, by name of the carrier.
    """
    folder = source.path.parent
    return {name: build_carrier(name, place, folder).bodies for name, place in model.places.items()}
