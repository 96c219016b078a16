"""Builds the pod from the figures in a cell file: oriented boxes and bins.

Every board is a sloped slab, a flat slab behind it, and two bars at the front edge: a lip above the floor and
one that hangs below the underside. The volumes above the highest board and behind the back wall are solid,
to keep the robot out; so is that below the lowest board, unless the pod stands on legs, with nothing between.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.place import Access, Place, Room
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.schemas.cell_schema import PodModel, RowModel
from pickcli.cell.shapes import Body, Shape, ShapeKind, box
from pickcli.cell.station import POD, Pod
from pickcli.geometry import pose

BELOW = "body_below"  # the body under the lowest board
FRONT_LEGS = ("leg_front_left", "leg_front_right")
REAR_LEGS = ("leg_rear_left", "leg_rear_right")


def build_pod(figures: PodModel) -> Pod:
    """Build the boxes (in the pod frame) and bins of the shelf.

    Args:
        figures: The shelf as it stands in the cell file.

    Returns:
        The pod.
    """
    boards = [body for i in range(len(figures.rows)) for body in _row_bodies(figures, i)]
    bodies = (*boards, *_frame_bodies(figures), *_leg_bodies(figures))
    displacement = Displacement(figures.displacement.x, figures.displacement.y, figures.displacement.yaw)
    bins = [b for row in figures.rows for b in _row_bins(figures, row)]
    return Pod(
        bodies=bodies,
        bins={b.name: b for b in bins},
        displacement=displacement,
    )


def row_name(row: RowModel) -> str:
    """Return the name of a row: ``row_ABC`` for the bins bin_A, bin_B, bin_C.

    Args:
        row: The row.

    Returns:
        Its name.
    """
    return "row_" + "".join(name.rsplit("_", 1)[-1] for name in row.bins)


def flat_from(figures: PodModel) -> float:
    """Return the x at which the floor's slope ends.

    Args:
        figures: The shelf as it stands in the cell file.

    Returns:
        x in m, pod frame.
    """
    return float(figures.lip_depth + figures.floor_drop / np.tan(figures.floor_slope))


def floor_names(row: RowModel) -> tuple[str, str]:
    """Return the names of the two bodies that support the items in a row.

    Args:
        row: The row.

    Returns:
        The sloped and the flat part.
    """
    return f"{row_name(row)}_floor_slope", f"{row_name(row)}_floor_flat"


def underside(figures: PodModel) -> float:
    """Return the height at which the lowest board's underside is flat.

    Args:
        figures: The shelf as it stands in the cell file.

    Returns:
        m over the floor.
    """
    return figures.rows[-1].floor_front - figures.floor_drop - figures.board_thickness


def _row_bodies(figures: PodModel, i: int) -> list[Body]:
    """Floor, lip and dividers of row i, and the lip that hangs below its floor."""
    row = figures.rows[i]
    name = row_name(row)
    below = row.floor_front - figures.board_thickness
    bodies = [
        *_board(figures, row.floor_front, floor_names(row)),
        _front(figures, f"{name}_lip", figures.lip_depth, below, row.lip_top),
    ]
    if i + 1 < len(figures.rows):
        hanging = figures.rows[i + 1].hanging_lip
        bodies.append(
            _front(figures, f"{name}_hanging_lip", figures.hanging_lip_depth, hanging, row.floor_front)
        )
    inner, outer = figures.divider, figures.divider + figures.divider_thickness
    bottom, top = row.floor_front - figures.floor_drop, row.ceiling_front
    for side, low, high in (("left", inner, outer), ("right", -outer, -inner)):
        lower, upper = (figures.divider_from, low, bottom), (figures.back_wall, high, top)
        bodies.append(box(f"{name}_divider_{side}", lower, upper))
    return bodies


def _board(figures: PodModel, top: float, names: tuple[str, str]) -> list[Body]:
    """Sloped and flat slab of a board whose upper face begins at height ``top``, m."""
    slope, thickness, width = figures.floor_slope, figures.board_thickness, 2 * figures.side_wall
    x_0, x_1 = figures.lip_depth, flat_from(figures)
    middle = np.array([(x_0 + x_1) / 2, 0.0, top - figures.floor_drop / 2])
    normal = np.array([np.sin(slope), 0.0, np.cos(slope)])
    size = ((x_1 - x_0) / np.cos(slope), width, thickness * np.cos(slope))
    T = pose(middle - normal * size[2] / 2, rpy=(0.0, slope, 0.0))
    sloped = Body(names[0], Shape(ShapeKind.BOX, tuple(float(s) for s in size)), T)
    low = top - figures.floor_drop
    y = figures.side_wall
    flat = box(names[1], (x_1, -y, low - thickness), (figures.back_wall, y, low))
    return [sloped, flat]


def _front(figures: PodModel, name: str, depth: float, low: float, high: float) -> Body:
    """A bar across the front, from the front face inwards."""
    return box(name, (0.0, -figures.side_wall, low), (depth, figures.side_wall, high))


def _frame_bodies(figures: PodModel) -> list[Body]:
    """Sides with their posts, back, and the solids that close the shelf above and below."""
    half, back, wall = figures.width / 2, figures.back_wall, figures.side_wall
    top_row, low, high = figures.rows[0], _begin(figures), figures.height
    ceiling = top_row.ceiling_front + figures.board_thickness
    sides = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        inner = sign * wall
        sides += [
            box(f"wall_{side}", *_span((0.0, back), (inner, sign * half), (low, high))),
            box(f"post_{side}", *_span((0.0, figures.post_depth), (sign * figures.post, inner), (low, high))),
        ]
    return [
        *sides,
        box("back", (back, -half, low), (figures.depth, half, high)),
        *([box(BELOW, (0.0, -wall, low), (back, wall, underside(figures)))] if _is_closed(figures) else []),
        *_board(figures, ceiling, ("ceiling_slope", "ceiling_flat")),
        _front(figures, "ceiling_lip", figures.hanging_lip_depth, top_row.hanging_lip, ceiling),
        box("body_above", (0.0, -wall, ceiling), (back, wall, figures.height)),
    ]


def _begin(figures: PodModel) -> float:
    """Height over the floor at which walls, posts and back begin, m."""
    if figures.legs is None:
        return 0.0
    return underside(figures) if figures.legs.height is None else figures.legs.height


def _is_closed(figures: PodModel) -> bool:
    """Whether there is a solid below the lowest board."""
    return _begin(figures) < underside(figures)


def _leg_bodies(figures: PodModel) -> list[Body]:
    """Legs from the floor to where the rest begins, if the pod has any."""
    if figures.legs is None:
        return []
    outside, deep, x = figures.width / 2, figures.legs.depth, figures.depth
    legs, inside = [], outside - figures.legs.width
    for names, xs in ((FRONT_LEGS, (0.0, deep)), (REAR_LEGS, (x - deep, x))):
        for name, sign in zip(names, (1.0, -1.0), strict=True):
            legs.append(box(name, *_span(xs, (sign * inside, sign * outside), (0.0, _begin(figures)))))
    return legs


def _span(
    x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Lower and upper corner of an upright box; its sides may be given in either order in y."""
    return (x[0], min(y), z[0]), (x[1], max(y), z[1])


def _row_bins(figures: PodModel, row: RowModel) -> list[Place]:
    inner, outer = figures.divider, figures.divider + figures.divider_thickness
    mouths = ((outer, figures.post), (-inner, inner), (-figures.post, -outer))
    insides = ((outer, figures.side_wall), (-inner, inner), (-figures.side_wall, -outer))
    return [
        _bin(figures, row, name, mouth, inside)
        for name, mouth, inside in zip(row.bins, mouths, insides, strict=True)
    ]


def _bin(
    figures: PodModel, row: RowModel, name: str, mouth: tuple[float, float], inside: tuple[float, float]
) -> Place:
    y, z = sum(mouth) / 2, row.lip_top
    room = Room(
        x_range=(0.0, figures.back_wall),
        y_range=(inside[0] - y, inside[1] - y),
        floor_front=row.floor_front - z,
        floor_back=row.floor_front - figures.floor_drop - z,
        ceiling_front=row.ceiling_front - z,
        ceiling_back=row.ceiling_front - figures.floor_drop - z,
        slope_from=figures.lip_depth,
        floor_flat_from=flat_from(figures),
    )
    access = Access.from_front(mouth[1] - mouth[0], row.hanging_lip - z)
    # The lowest board is thin: a body of the pod right under it is in contact tolerance of the items too.
    is_on_body = row is figures.rows[-1] and _is_closed(figures)
    support = (*floor_names(row), *((BELOW,) if is_on_body else ()))
    return Place(name, POD, pose((0.0, y, z)), access, room, support)
