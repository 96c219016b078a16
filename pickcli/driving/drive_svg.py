"""A drive as a drawing from above: walls, boxes, the truck along its path, forwards and backwards."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

import numpy as np

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.free_space_proof import truck_corners
from pickcli.geometry import Array

LONG_SIDE = 800.0  # px of the longer side of the walls
BORDER = 0.3  # m around them
SHOWN_STEP = 0.5  # m of travel between two drawn outlines of the truck, at most
LINE_STEP = 0.05  # m of travel between two points of a line, at most
BOX, OUTLINE, START, GOAL = "#c8c8c8", "#56b4e9", "#009e73", "#d55e00"
FORWARDS, BACKWARDS = "#0072b2", "#cc79a7"  # after Okabe and Ito, as all pictures


def drive_svg(plan: DrivePlan) -> str:
    """Draw a drive.

    Args:
        plan: The plan.

    Returns:
        The text of an SVG file.
    """
    area = plan.area
    low, sides = np.array(area.low) - BORDER, np.array(area.high) - area.low + 2 * BORDER
    scale = LONG_SIDE / sides.max()
    width, height = scale * sides
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}">'
    )
    shapes = [shape.format(points=_points(at, low, scale, height)) for shape, at in _shapes(plan)]
    return "\n".join([head, '<rect width="100%" height="100%" fill="white"/>', *shapes, "</svg>", ""])


def _shapes(plan: DrivePlan) -> Iterator[tuple[str, Array]]:
    """Shapes with {points} in place of their points; (N, 2) m: these."""
    area, path = plan.area, plan.path
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    low, high = np.array(area.low), np.array(area.high)
    yield (
        '<polygon points="{points}" fill="none" stroke="#404040" stroke-width="3"/>',
        low + corners * (high - low),
    )
    for box in area.boxes:
        name = escape(box.name).replace("{", "{{").replace("}", "}}")
        yield f'<polygon points="{{points}}" fill="{BOX}"><title>{name}</title></polygon>', box.corners
    n = max(2, int(np.ceil(path.length / SHOWN_STEP)) + 1)
    outlines = truck_corners(area, path.poses_at(np.linspace(0.0, path.length, n)))
    for k, outline in enumerate(outlines):
        ink, line = {0: (START, 2.5), n - 1: (GOAL, 2.5)}.get(k, (OUTLINE, 0.7))
        yield f'<polygon points="{{points}}" fill="none" stroke="{ink}" stroke-width="{line}"/>', outline
    ends = path.knots[[0, *path.cusps.tolist(), len(path.steps)]]
    for begin, end, sign in zip(
        ends[:-1], ends[1:], np.sign(path.steps[[0, *path.cusps.tolist()]]), strict=True
    ):
        travel = np.linspace(begin, end, max(2, int(np.ceil((end - begin) / LINE_STEP)) + 1))
        ink = FORWARDS if sign > 0 else BACKWARDS
        yield (
            f'<polyline points="{{points}}" fill="none" stroke="{ink}" stroke-width="2"/>',
            path.poses_at(travel),
        )


def _points(places: Array, low: Array, scale: float, height: float) -> str:
    """Points in px; y up becomes y down."""
    return " ".join(
        f"{scale * (x - low[0]):.1f},{height - scale * (y - low[1]):.1f}" for x, y in places[:, :2]
    )
