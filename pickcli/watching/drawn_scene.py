"""Draws a watched scene for a drive: people who cross its path, reflectors on walls and boxes, sun."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.driving_area import DrivingArea
from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.watching.foreseen_contact import outline_distance
from pickcli.watching.watched_scene import Reflector, ReflectorKind, SunPatch, Walker, WatchedScene

SPEEDS = (0.3, 2.0)  # m/s of those who walk
STANDING = 0.15  # share of people who stand
LONGEST = 6.0  # m that they walk before and after the path
BESIDE = 0.35  # m that they keep from walls and boxes
FROM_START = 2.0  # m that they are from the truck at first, at least
CROSSING = np.radians((40.0, 140.0))  # between path and way
BOX_HEIGHTS = (0.5, 2.2)  # m
MOST_REFLECTORS, MOST_SUN = 8, 3
SUN_SIZES, SUN_STRENGTHS = (0.5, 3.0), (4.0, 15.0)
POST = (0.08, 1.1)  # m, diameter and height
POST_BESIDE = 0.7  # m of a post from the truck all along
MORE_TIME = 30.0  # s beyond the planned duration
TRIES = 60
DECIMALS = 3  # of figures, so that files say the same


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Draws for one plan."""

    plan: DrivePlan
    rng: np.random.Generator

    @property
    def area(self) -> DrivingArea:
        return self.plan.area

    def clearance(self, place: Array) -> float:
        """Distance (m) from walls and boxes."""
        return min(
            [float(self.area.wall_distance(place))] + [float(b.distance(place)) for b in self.area.boxes]
        )

    def walker(self, number: int) -> Walker | None:
        """A person whose way meets the path where the truck is by plan; None if that is not free."""
        profile, rng = self.plan.profile, self.rng
        time = rng.uniform(0.15, 0.95) * profile.duration
        x, y, yaw = self.plan.path.poses_at(profile.travel_at(np.array([time])))[0].tolist()
        ahead = rng.uniform(0.0, self.area.truck.front + 0.5)
        meeting = np.array([x + ahead * np.cos(yaw), y + ahead * np.sin(yaw)])
        is_standing, speed = rng.uniform() < STANDING, rng.uniform(*SPEEDS)
        angle = yaw + rng.choice([-1, 1]) * rng.uniform(*CROSSING)
        height, aside = rng.uniform(1.6, 1.95), rng.uniform(0.2, 2.0)
        way = np.array([np.cos(angle), np.sin(angle)])
        if is_standing:
            route, speed, start = [meeting + aside * way], 0.0, 0.0
        else:
            before, after = self._free_way(meeting, -way), self._free_way(meeting, way)
            route = [meeting - before * way, meeting + after * way]
            start = time - before / speed
            if before + after < 1.0:
                return None
        first = route[0][None]
        if self.clearance(route[0]) < BESIDE or (start < 0 and not is_standing):
            return None
        if outline_distance(self.area.truck, self.area.start[None], first)[0] < FROM_START:
            return None
        rounded = tuple((round(float(a), DECIMALS), round(float(b), DECIMALS)) for a, b in route)
        speed, start, height = (round(float(each), DECIMALS) for each in (speed, start, height))
        return Walker(f"person {number}", rounded, speed, start, height)

    def _free_way(self, place: Array, way: Array) -> float:
        """Length (m) that someone can go from a place."""
        steps = np.arange(0.0, LONGEST, 0.1)
        free = [self.clearance(place + step * way) >= BESIDE for step in steps.tolist()]
        return float(steps[free.index(False) - 1]) if False in free[1:] and free[0] else LONGEST * free[0]

    def reflector(self) -> Reflector | None:
        """A reflector on a side of a wall or box, on the floor, or a post; None if it is in the way."""
        rng = self.rng
        kind = ReflectorKind(rng.choice([str(each) for each in ReflectorKind]))
        if kind is ReflectorKind.POST:
            place = rng.uniform(self.area.low, self.area.high)
            if self.clearance(place) < POST[0] or self._from_path(place) < POST_BESIDE:
                return None
            return Reflector(kind, _place(place, POST[1] / 2), POST)
        is_flat = kind is ReflectorKind.TAPE and rng.uniform() < 0.3
        if is_flat:
            place = rng.uniform(self.area.low, self.area.high)
            size = (round(rng.uniform(0.5, 3.0), DECIMALS), 0.05)
            return Reflector(
                kind, _place(place, 0.003), size, round(rng.uniform(-np.pi, np.pi), DECIMALS), True
            )
        middle, normal, length = self._side()
        along, up = rng.uniform(0.15, 0.6, 2) if kind is ReflectorKind.SIGN else (rng.uniform(0.3, 2.0), 0.05)
        along = min(float(along), length)
        place = (
            middle
            + 0.01 * normal
            + rng.uniform(-0.5, 0.5) * (length - along) * np.array([-normal[1], normal[0]])
        )
        yaw = round(float(np.arctan2(normal[1], normal[0])), DECIMALS)
        size = (round(along, DECIMALS), round(float(up), DECIMALS))
        return Reflector(kind, _place(place, rng.uniform(0.3, 1.9)), size, yaw)

    def _side(self) -> tuple[Array, Array, float]:
        """(2,) m: middle of a side of a wall or box; (2,) where it looks; m: how long it is."""
        k = int(self.rng.integers(len(self.area.boxes) + 1))
        low, high = self.area.low, self.area.high
        walls = np.array([low, (low[0], high[1]), high, (high[0], low[1])])  # looking inwards
        corners = walls if k == len(self.area.boxes) else self.area.boxes[k].corners
        i = int(self.rng.integers(4))
        along = corners[(i + 1) % 4] - corners[i]
        length = float(np.hypot(*along))
        return (corners[i] + corners[(i + 1) % 4]) / 2, np.array([along[1], -along[0]]) / length, length

    def _from_path(self, place: Array) -> float:
        poses = self.plan.path.poses_at(np.linspace(0.0, self.plan.path.length, 200))
        return float(outline_distance(self.area.truck, poses, np.tile(place, (len(poses), 1))).min())

    def sun_patch(self) -> SunPatch:
        """A rectangle of the floor."""
        (a, b), (c, d), rng = self.rng.uniform(self.area.low, self.area.high), SUN_SIZES, self.rng
        size, yaw, strength = rng.uniform(c, d, 2), rng.uniform(-np.pi, np.pi), rng.uniform(*SUN_STRENGTHS)
        return SunPatch(
            (round(float(a), DECIMALS), round(float(b), DECIMALS)),
            (round(float(size[0]), DECIMALS), round(float(size[1]), DECIMALS)),
            round(yaw, DECIMALS), round(strength, DECIMALS),
        )  # fmt: skip


def draw_watched_scene(plan: DrivePlan, n_walkers: int, seed: int) -> WatchedScene:
    """Draw a scene for a drive.

    Args:
        plan: The drive.
        n_walkers: Number of people; less where there is no room.
        seed: Seed of all that is drawn.

    Returns:
        The scene.
    """
    drawing = _Drawing(plan, derived_rng("watched scene", seed))
    rng = drawing.rng
    heights = tuple(round(rng.uniform(*BOX_HEIGHTS), DECIMALS) for _ in plan.area.boxes)
    walkers: list[Walker] = []
    for _ in range(TRIES):
        if len(walkers) < n_walkers and (walker := drawing.walker(len(walkers) + 1)) is not None:
            walkers.append(walker)
    drawn = [drawing.reflector() for _ in range(int(rng.integers(MOST_REFLECTORS + 1)))]
    sun = tuple(drawing.sun_patch() for _ in range(int(rng.integers(MOST_SUN + 1))))
    duration = round(plan.profile.duration + MORE_TIME, DECIMALS)
    reflectors = tuple(each for each in drawn if each is not None)
    return WatchedScene(plan.area, heights, tuple(walkers), reflectors, sun, duration)


def _place(place: Array, z: float) -> tuple[float, float, float]:
    x, y = place.tolist()
    return round(x, DECIMALS), round(y, DECIMALS), round(float(z), DECIMALS)
