"""Second opinion on a drive: judges its file with kinematics and distances of its own.

Control actions are integrated by the rules of Runge, Kutta and Simpson; the truck's distance from walls and
boxes is that of corners and edges of two rectangles. No corner (a, b) of a truck with the wheel base L moves
farther than sqrt((1 + |b| / L)^2 + (a / L)^2) per m of travel, so that distances at two poses bound what lies
between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.driving.drive_plan_file import POSE_STEP, StatedDrive
from pickcli.driving.driving_area import WALLS, DrivingArea
from pickcli.driving.tricycle import PLANNED_SHARE, STEERING_RESERVE
from pickcli.errors import Reason
from pickcli.geometry import Array

STEP = 0.005  # m of travel between two poses that are judged, before any is halved
LEAST_STEP = 1e-5  # m of travel, below which what is not proven counts as too near
SUBSTEP = 0.01  # m of travel of one step of integration, at most
AT_END = 1e-4  # m and rad, by which start, goal and stated poses may differ from the actions
SAME = 1e-6  # of figures that are stated twice
SEEN_STEP = 0.02  # m of travel between the samples of a stated clearance
ROUNDING = 1e-5  # of a limit, for figures that a file rounds


@dataclass(frozen=True)
class DriveVerdict:
    """Result of the verification of a drive.

    Attributes:
        reasons: Against the drive; none if it is accepted.
        clearance: m that the truck is from everything at least, all along.
        position_error: m between the end of the drive and the goal.
        yaw_error: rad between them.
        speed_ratio: Most of the truck's speed that is used, as a share.
        acceleration_ratio: Of its acceleration, likewise.
        centripetal_ratio: Of its centripetal acceleration, likewise.
        steering_rate_ratio: Of its steering rate, likewise.
    """

    reasons: tuple[Reason, ...]
    clearance: float
    position_error: float
    yaw_error: float
    speed_ratio: float
    acceleration_ratio: float
    centripetal_ratio: float
    steering_rate_ratio: float


def verify_drive(drive: StatedDrive, area: DrivingArea) -> DriveVerdict:
    """Judge a drive in an area.

    Args:
        drive: What its file says.
        area: The area that it must be a drive in.

    Returns:
        The verdict, with every fault.
    """
    view = _View(drive, area)
    faults = (*view.other_area(), *view.wrong_ends(), *view.too_near(), *view.beyond_limits(), *view.untold())
    position_error, yaw_error = view.errors
    speed, acceleration, centripetal, rate = view.ratios
    return DriveVerdict(
        faults, view.nearest[0], position_error, yaw_error, speed, acceleration, centripetal, rate
    )


class _View:
    """A drive in an area, as the verifier computes it.

    Args:
        drive: What its file says.
        area: The area.
    """

    def __init__(self, drive: StatedDrive, area: DrivingArea) -> None:
        self._drive, self._area, self._truck = drive, area, area.truck
        self._knots = np.concatenate([[0.0], np.cumsum(np.abs(drive.steps))])
        self._length = float(self._knots[-1])

    def other_area(self) -> Iterator[Reason]:
        """Yield what the file states otherwise than the area."""
        drive, area = self._drive, self._area
        pairs = (
            ("truck", drive.truck, area.truck),
            ("margin", drive.margin, area.margin),
            ("start", drive.start.tolist(), area.start.tolist()),
            ("goal", drive.goal.tolist(), area.goal.tolist()),
            ("straight", drive.straight, area.straight),
        )
        for name, own, other in pairs:
            if own != other:
                yield Reason("another area", name, f"{own} in the drive, {other} in the area")

    @cached_property
    def errors(self) -> tuple[float, float]:
        """Distance (m) and angle (rad) between the end of the drive and the goal."""
        end, goal = self.poses(np.array([self._length]))[0], self._area.goal
        return float(np.hypot(*(end[:2] - goal[:2]))), abs(float(_turn(end[2], goal[2])))

    def wrong_ends(self) -> Iterator[Reason]:
        """Yield that the drive does not end at the goal, or not straight."""
        position, yaw = self.errors
        if position > AT_END or yaw > AT_END:
            yield Reason("does not end at the goal", "end", f"{position:.4f} m and {yaw:.4f} rad off")
        straight = self._area.straight
        ends_within = self._knots[1:] > self._length - abs(straight) + SAME
        is_straight = np.abs(self._drive.steering[1:][ends_within]).max(initial=0.0) <= SAME
        is_straight &= bool((np.sign(self._drive.steps[ends_within]) == np.sign(straight)).all())
        begins = np.interp(self._length - abs(straight), self._knots, self._drive.steering)
        if straight and not (is_straight and abs(begins) <= SAME):
            yield Reason("does not end straight", "end", f"{straight:g} m of straight travel are asked")

    def poses(self, travel: Array) -> Array:
        """(N, 3) m, m, rad at increasing travels (N,), by Runge-Kutta steps of fourth order."""
        n = np.maximum(1, np.ceil(np.abs(self._drive.steps) / SUBSTEP)).astype(int)
        grid = np.unique(np.concatenate([travel, self._knots, *self._within(n)]).clip(0.0, self._length))
        middle = (grid[:-1] + grid[1:]) / 2
        step = np.searchsorted(self._knots, middle).clip(1, len(self._drive.steps)) - 1
        ds = np.diff(grid) * np.sign(self._drive.steps[step])
        phi = [np.interp(at, self._knots, self._drive.steering) for at in (grid[:-1], middle, grid[1:])]
        turn = [np.sin(angle) / self._truck.wheel_base for angle in phi]
        # The heading does not depend on itself: for it the rule is Simpson's.
        yaw = np.concatenate([[0.0], np.cumsum(ds * (turn[0] + 4 * turn[1] + turn[2]) / 6)])
        yaw += self._drive.start[2]
        half = yaw[:-1] + ds * (5 * turn[0] + 8 * turn[1] - turn[2]) / 24
        heads = (yaw[:-1], half, yaw[1:])
        rows = []
        for of in (np.cos, np.sin):
            f = [np.cos(angle) * of(head) for angle, head in zip(phi, heads, strict=True)]
            rows.append(np.concatenate([[0.0], np.cumsum(ds * (f[0] + 4 * f[1] + f[2]) / 6)]))
        x, y = rows[0] + self._drive.start[0], rows[1] + self._drive.start[1]
        at = np.searchsorted(grid, travel.clip(0.0, self._length))
        return np.column_stack([x, y, yaw])[at]

    def _within(self, n: Array) -> list[Array]:
        """Travels that cut each step into so many equal ones."""
        parts = zip(self._knots[:-1].tolist(), self._knots[1:].tolist(), n.tolist(), strict=True)
        return [np.linspace(start, end, k, endpoint=False) for start, end, k in parts]

    @cached_property
    def nearest(self) -> tuple[float, float, str]:
        """Distance (m) that the truck is from anything at least, the travel there, and what it is."""
        margin, reach = self._area.margin, self._reach
        low = np.linspace(0.0, self._length, max(2, int(np.ceil(self._length / STEP)) + 1))
        low, high = low[:-1], low[1:]
        least, at, name = np.inf, 0.0, ""
        while len(low):
            ends = np.unique(np.concatenate([low, high]))
            found = self._distances(self.poses(ends))
            of_each = found.min(axis=1)
            before, after = (of_each[np.searchsorted(ends, side)] for side in (low, high))
            bound = (before + after - reach * (high - low)) / 2
            is_open = (bound < margin) & (np.minimum(before, after) >= margin) & (high - low > LEAST_STEP)
            worst = np.where(is_open, np.inf, bound)
            if len(worst) and worst.min() < least:
                k = int(worst.argmin())
                least, at = float(worst[k]), float(low[k])
                name = self._name(int(found[np.searchsorted(ends, low[k])].argmin()))
            middle = (low[is_open] + high[is_open]) / 2
            low, high = np.concatenate([low[is_open], middle]), np.concatenate([middle, high[is_open]])
        return least, at, name

    @property
    def _reach(self) -> float:
        """Length (m) that a corner of the truck moves per m of travel, at most."""
        truck = self._truck
        a, b = max(truck.front, truck.back) / truck.wheel_base, truck.width / 2 / truck.wheel_base
        return float(np.hypot(1.0 + b, a))

    def _name(self, k: int) -> str:
        return WALLS if k == 0 else self._area.boxes[k - 1].name

    def _distances(self, poses: Array) -> Array:
        """(N, 1 + boxes) m from walls and boxes; 0 or less where they meet."""
        truck = self._truck
        half = truck.width / 2
        own = np.array([[truck.front, half], [-truck.back, half], [-truck.back, -half], [truck.front, -half]])
        turned = np.exp(1j * poses[:, 2])[:, None] * (own[:, 0] + 1j * own[:, 1]) + (
            poses[:, :1] + 1j * poses[:, 1:2]
        )
        corners = np.stack([turned.real, turned.imag], axis=-1)
        walls = np.minimum(corners - self._area.low, self._area.high - corners).min(axis=(1, 2))
        return np.column_stack([walls, *(_apart(corners, box.corners) for box in self._area.boxes)])

    def too_near(self) -> Iterator[Reason]:
        """Yield where the truck does not keep the margin."""
        least, at, name = self.nearest
        if least < self._area.margin - 2 * LEAST_STEP:
            detail = f"{least:.4f} m from {name}, {self._area.margin:g} m are to be kept"
            yield Reason("too near", f"after {at:.2f} m of travel", detail)

    @cached_property
    def ratios(self) -> tuple[float, float, float, float]:
        """Shares of speed, acceleration, centripetal acceleration and steering rate that are used at most."""
        drive, truck = self._drive, self._truck
        grid = np.unique(np.concatenate([drive.travel, self._knots]).clip(0.0, self._length))
        # Constant acceleration: the square of the speed is linear in the travel.
        squares = np.interp(grid, drive.travel, drive.speeds**2)
        most = np.maximum(squares[:-1], squares[1:])
        sine = np.abs(np.sin(np.interp(grid, self._knots, drive.steering)))
        slope = np.abs(np.diff(drive.steering) / drive.steps)
        step = np.searchsorted(self._knots, (grid[:-1] + grid[1:]) / 2).clip(1, len(drive.steps)) - 1
        gaps = np.diff(drive.travel)
        return (
            float(drive.speeds.max()) / truck.speed,
            float((np.abs(np.diff(drive.speeds**2)) / (2 * gaps)).max()) / truck.acceleration,
            float((most * np.maximum(sine[:-1], sine[1:])).max()) / truck.wheel_base / truck.centripetal,
            float((np.sqrt(most) * slope[step]).max()) / truck.steering_rate,
        )

    def beyond_limits(self) -> Iterator[Reason]:
        """Yield limits that are not kept, with the reserve of plans, and where the truck does not rest."""
        names = ("speed", "acceleration", "centripetal acceleration", "steering rate")
        for name, ratio in zip(names, self.ratios, strict=True):
            if ratio > PLANNED_SHARE * (1.0 + ROUNDING) + ROUNDING:
                yield Reason("beyond a limit", name, f"{ratio:.4f} of it, at most {PLANNED_SHARE:g} is used")
        largest = float(np.abs(self._drive.steering).max())
        if largest > self._truck.steering - STEERING_RESERVE + SAME:
            detail = f"{largest:.4f} rad, at most {self._truck.steering - STEERING_RESERVE:g} rad are used"
            yield Reason("beyond a limit", "steering angle", detail)
        if abs(self._drive.travel[0]) > SAME or abs(self._drive.travel[-1] - self._length) > SAME:
            yield Reason("speeds are not those of the whole drive", "profile", f"{self._length:.6f} m")
        turns = np.flatnonzero(np.diff(np.sign(self._drive.steps))) + 1
        rests = np.concatenate([[0.0], self._knots[turns], [self._length]])
        nearest = np.abs(self._drive.travel[:, None] - rests).argmin(axis=0)
        is_off = np.abs(self._drive.travel[nearest] - rests) > SAME
        for k in np.flatnonzero(is_off | (self._drive.speeds[nearest] > SAME)):
            yield Reason(
                "does not rest", f"after {rests[k]:.2f} m of travel", "it starts, ends or turns there"
            )

    def untold(self) -> Iterator[Reason]:
        """Yield poses and times of the file that are not those of its actions."""
        yield from self._other_figures()
        rows = self._drive.poses
        travel, gaps = rows[:, 1], np.diff(rows[:, 1])
        if (gaps <= 0.0).any() or max(abs(travel[0]), abs(travel[-1] - self._length)) > SAME:
            detail = f"from {travel[0]:.3f} to {travel[-1]:.3f} m, the drive is {self._length:.3f} m long"
            yield Reason("not the same drive", "poses", detail)
            return
        if gaps.max() > POSE_STEP + SAME:
            detail = f"{gaps.max():.3f} m of travel between two rows, at most {POSE_STEP:g} m are left out"
            yield Reason("not the same drive", "poses", detail)
        found = self.poses(travel)
        angles = np.interp(travel, self._knots, self._drive.steering)
        stated = np.column_stack([rows[:, 2:4], rows[:, 5], _turn(rows[:, 4], found[:, 2])])
        off = np.abs(stated - np.column_stack([found[:, :2], angles, np.zeros(len(rows))])).max(axis=1)
        if off.max() > AT_END:
            k = int(off.argmax())
            yield Reason("not the same drive", "poses", f"row {k} is {off[k]:.4f} m or rad off the actions")
        times = self._times(travel)
        late = np.abs(times - rows[:, 0])
        if late.max() > AT_END:
            k = int(late.argmax())
            yield Reason("not the same drive", "poses", f"row {k} is {late[k]:.4f} s off its speeds")
        if abs(times[-1] - self._drive.duration) > AT_END:
            yield Reason("not the same drive", "duration", f"its speeds take {times[-1]:.3f} s")

    def _other_figures(self) -> Iterator[Reason]:
        """Yield figures of the file that its actions do not have."""
        drive = self._drive
        if abs(drive.length - self._length) > SAME:
            yield Reason("not the same drive", "travel", f"its actions are {self._length:.6f} m long")
        if drive.n_cusps != (n := int(np.count_nonzero(np.diff(np.sign(drive.steps))))):
            yield Reason("not the same drive", "cusps", f"its actions have {n}")
        n = int(np.ceil(self._length / SEEN_STEP)) + 1
        least = float(self._distances(self.poses(np.linspace(0.0, self._length, n))).min())
        if abs(least - drive.clearance) > AT_END:
            yield Reason("not the same drive", "clearance", f"it comes as near as {least:.4f} m")

    def _times(self, travel: Array) -> Array:
        """(N,) s at which the speeds bring the truck to travels (N,) m."""
        at = np.unique(np.concatenate([self._drive.travel, travel]))
        speeds = np.sqrt(np.interp(at, self._drive.travel, self._drive.speeds**2))
        with np.errstate(divide="ignore"):
            times = np.concatenate([[0.0], np.cumsum(2 * np.diff(at) / (speeds[:-1] + speeds[1:]))])
        return np.asarray(times[np.searchsorted(at, travel)])


def _turn(angle: Array | float, other: Array | float) -> Array:
    """Angle (rad) from one direction to another, in (-pi, pi]."""
    return np.asarray(np.angle(np.exp(1j * (np.asarray(angle) - np.asarray(other)))))


def _apart(rectangles: Array, box: Array) -> Array:
    """(N,) m between (N, 4, 2) rectangles and a box (4, 2); 0 where they overlap."""
    between = np.minimum(
        _to_edges(rectangles, box[None]), _to_edges(np.broadcast_to(box, (1, 4, 2)), rectangles)
    )
    return np.where(_overlap(rectangles, box), 0.0, between)


def _to_edges(points: Array, polygons: Array) -> Array:
    """(N,) m from any of 4 points (N or 1, 4, 2) to the nearest edge of polygons (N or 1, 4, 2)."""
    edges = np.roll(polygons, -1, axis=1) - polygons
    off = points[:, :, None] - polygons[:, None]
    share = (off * edges[:, None]).sum(-1) / (edges**2).sum(-1)[:, None]
    nearest = off - share.clip(0.0, 1.0)[..., None] * edges[:, None]
    return np.asarray(np.linalg.norm(nearest, axis=-1).min(axis=(1, 2)))


def _overlap(rectangles: Array, box: Array) -> Array:
    """(N,) whether rectangles (N, 4, 2) and a box (4, 2) overlap: no edge's normal parts them."""
    is_parted = np.zeros(len(rectangles), dtype=bool)
    others = np.broadcast_to(box, rectangles.shape)
    for owner in (rectangles, others):
        edges = np.roll(owner, -1, axis=1) - owner
        normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
        along = [np.einsum("nek,nck->nec", normals, corners) for corners in (rectangles, others)]
        gaps = np.maximum(along[0].min(-1) - along[1].max(-1), along[1].min(-1) - along[0].max(-1))
        is_parted |= (gaps > 0.0).any(axis=1)
    return ~is_parted
