"""A small hall, its watch, and scenes in it, for tests of what a truck sees."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.watching.watch_file import Watch, read_watch, watch_file
from pickcli.watching.watched_scene import Reflector, Walker, WatchedScene

BOX = FloorBox("shelf", (5.0, 6.5), (2.0, 1.0))


def watch() -> Watch:
    """The watch that commands take by default."""
    return read_watch(watch_file("citi_truck"))


def narrow_watch() -> Watch:
    """The default watch with fields for people who stand."""
    return replace(watch(), fields=replace(watch().fields, approach=0.0))


def hall(*boxes: FloorBox, length: float = 30.0) -> DrivingArea:
    """A hall in which the truck begins at x = 1.5 in the middle of 8 m, and goes along x."""
    start, goal = np.array([1.5, 4.0, 0.0]), np.array([length - 3.0, 4.0, 0.0])
    return DrivingArea((0.0, 0.0), (length, 8.0), boxes, start, goal)


@cache
def plan() -> DrivePlan:
    """A straight drive of 5.5 m past a shelf."""
    return plan_drive(hall(BOX, length=10.0))


def scene(
    *walkers: Walker, area: DrivingArea | None = None, reflectors: tuple[Reflector, ...] = (),
    box_height: float = 2.0, duration: float = 30.0,
) -> WatchedScene:  # fmt: skip
    """A scene in the hall of the plan, or in another one."""
    area = plan().area if area is None else area
    heights = tuple(box_height for _ in area.boxes)
    return WatchedScene(area, heights, walkers, reflectors, (), duration)
