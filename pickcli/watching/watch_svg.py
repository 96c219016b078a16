"""A watched drive as a drawing from above: walls, boxes, sun, reflectors, people, tracks, truck, fields."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import TypeAlias

import numpy as np

from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.driving_area import FloorBox
from pickcli.driving.free_space_proof import truck_corners
from pickcli.driving.steering_path import posed
from pickcli.geometry import Array
from pickcli.watching.watched_drive import WatchedDrive

LONG_SIDE = 800.0  # px of the longer side of the walls
BORDER = 0.3  # m around them
OUTLINE_EVERY = 50  # periods between drawn outlines of the truck
WALK_STEP = 0.2  # s between points of a way
BOX, WALL, SUN, REFLECTOR = "#c8c8c8", "#404040", "#f0e442", "#000000"
TRUCK, BRAKED, PERSON, TRACK, FIELD = "#56b4e9", "#d55e00", "#009e73", "#cc79a7", "#e69f00"  # Okabe and Ito
_Shape: TypeAlias = tuple[str, Array, str, str]  # kind, (N, 2) m, attributes, title


def watch_svg(drive: WatchedDrive) -> str:
    """Draw a watched drive.

    Args:
        drive: The drive.

    Returns:
        The text of an SVG file.
    """
    area = drive.scene.area
    low, sides = np.array(area.low) - BORDER, np.array(area.high) - area.low + 2 * BORDER
    scale = LONG_SIDE / sides.max()
    width, height = scale * sides

    def px(places: Array) -> str:
        return " ".join(f"{scale * (x - low[0]):.1f},{height - scale * (y - low[1]):.1f}" for x, y in places)

    shapes = [
        f'<{kind} points="{px(places)}" {style}>{f"<title>{escape(title)}</title>" if title else ""}</{kind}>'
        for kind, places, style, title in (*_standing(drive), *_moving(drive), *_requests(drive))
    ]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}">'
    )
    return "\n".join([head, '<rect width="100%" height="100%" fill="white"/>', *shapes, "</svg>", ""])


def _standing(drive: WatchedDrive) -> Iterator[_Shape]:
    scene = drive.scene
    low, high = np.array(scene.area.low), np.array(scene.area.high)
    for patch in scene.sun:
        corners = FloorBox("", patch.centre, patch.size, patch.yaw).corners
        yield "polygon", np.clip(corners, low, high), f'fill="{SUN}" fill-opacity="0.4"', "sun"
    walls = low + np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * (high - low)
    yield "polygon", walls, f'fill="none" stroke="{WALL}" stroke-width="3"', ""
    for box in scene.area.boxes:
        yield "polygon", box.corners, f'fill="{BOX}"', box.name
    for each in scene.reflectors:
        along = each.size[0] / 2 * np.array([-np.sin(each.yaw), np.cos(each.yaw)])
        ends = np.array(each.centre[:2]) + np.array([-along, along])
        yield "polyline", ends, f'fill="none" stroke="{REFLECTOR}" stroke-width="3"', str(each.kind)


def _moving(drive: WatchedDrive) -> Iterator[_Shape]:
    duration = PERIOD * (len(drive.poses) - 1)
    for walker in drive.scene.walkers:
        times = np.arange(0.0, duration + WALK_STEP, WALK_STEP).tolist()
        places = np.array([walker.place(time) for time in times])
        yield "polyline", places, f'fill="none" stroke="{PERSON}" stroke-width="2"', walker.name
        round_ = np.linspace(0.0, 2 * np.pi, 24)
        body = places[0] + 0.25 * np.column_stack([np.cos(round_), np.sin(round_)])
        yield "polygon", body, f'fill="{PERSON}"', walker.name
    for number, rows in drive.tracks.items():
        yield "polyline", rows[:, 1:], f'fill="none" stroke="{TRACK}" stroke-width="1"', f"track {number}"
    shown = np.arange(0, len(drive.poses), OUTLINE_EVERY)
    for k, outline in zip(shown.tolist(), truck_corners(drive.scene.area, drive.poses[shown]), strict=True):
        ink = BRAKED if drive.is_braked[k] else TRUCK
        yield "polygon", outline, f'fill="none" stroke="{ink}" stroke-width="0.8"', f"{k * PERIOD:.1f} s"


def _requests(drive: WatchedDrive) -> Iterator[_Shape]:
    for each in drive.requests:
        if each.field is None:
            continue
        k = min(round(each.time / PERIOD), len(drive.poses) - 1)
        outline = each.field.outline
        places = posed(drive.poses[k], np.column_stack([outline, np.zeros(len(outline))]))[:, :2]
        style = f'fill="{FIELD}" fill-opacity="0.15" stroke="{FIELD}" stroke-width="1"'
        yield "polygon", places, style, f"{each.time:.2f} s: brake request by {each.by}"
    for touch in drive.touches:
        k = min(round(touch.time / PERIOD), len(drive.poses) - 1)
        outline = truck_corners(drive.scene.area, drive.poses[k : k + 1])[0]
        style = f'fill="none" stroke="{BRAKED}" stroke-width="3"'
        yield "polygon", outline, style, f"{touch.time:.2f} s: contact with {touch.name}"
