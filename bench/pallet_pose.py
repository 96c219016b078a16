"""How well a pallet is found in one depth picture of the truck's camera, and what else is taken for one.

    python -m bench.pallet_pose [--pictures 500] [--seed 0] [--sensor carmine] [--mount]
    python -m bench.pallet_pose --pictures 400 --seed 1 --calibrate

In each picture a full or half EUR pallet stands 0.6 to 2.5 m before the camera (from there to its front,
along the floor), turned by up to 20 degrees and aside by up to a fifth of that distance. On it are nothing, a
full load, or a few cartons, which may reach over its edges. Besides there are up to four boxes, every other
time a pallet beside it 50 to 300 mm away, at the same line or not, and every fifth time a box before it that
hides a part of it. The zone that is stated is off by up to 0.2 m and 10 degrees. As many pictures show none:
bare floor, crates and boxes, also of a pallet's size, a box on two beams, a table with four legs, runners as
those of a pallet of 0.6 m or 1.0 m width, the long side of a pallet, open bins, heaps. A pallet is missed if
it is not found or is more than 50 mm off, which is false, too. With ``--mount`` the camera is off its stated
pose within 2 mm and 2 mrad. Times are processor time of one thread, of the detection alone. ``--calibrate``
fits the factor of the bounds, as bench.pod_pose does.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field, replace
from time import thread_time

import numpy as np

import pickcli.perception.pallets.pallet_pose as pallet_pose
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.cell.shapes import Body, box
from pickcli.driving.area_view import rendered_area
from pickcli.driving.driving_area import DrivingArea, FloorBox, StatedPallet
from pickcli.driving.steering_path import posed, seen_from
from pickcli.driving.truck_camera import TruckCamera, floor_pose
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.floor_pose_bound import ROUNDING
from pickcli.perception.pallets.front_search import PalletZone
from pickcli.perception.pallets.pallet_pose import PalletEstimate, detect_pallet
from pickcli.perception.pallets.pallet_shape import EUR_FULL, EUR_HALF, PalletShape
from pickcli.perception.pod_pose import EXACT
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid

DISTANCE, ASIDE, TURNED = (0.6, 2.5), 0.2, np.radians(20.0)  # m, of the distance, and rad
OFF = np.array([0.2, 0.2, np.radians(10.0)])  # m, m and rad that zones are off
TOLERANCE = np.array([0.25, 0.25, np.radians(12.0)])
NONE = np.zeros(3)
FALSE = 0.05  # m from the pallet, from which on what is found is something else
MOUNT = MountError(0.002, 0.002)
KEPT = 0.995  # of draws, by the factor
HALL = DrivingArea((-6.0, -4.0), (4.0, 4.0), (), NONE, NONE)
OTHERS = ("floor", "crate", "flat box", "beams", "table", "narrow", "wide", "long side", "bin", "heap")


@dataclass(frozen=True, eq=False)
class Draw:
    """A picture, with what is in it."""

    picture: DepthPicture
    shape: PalletShape
    zone: PalletZone
    pose: Array | None  # (3,) m, m, rad of the pallet in the frame of the truck; None for none
    what: str


def draw(camera: TruckCamera, seed: int, k: int, mount: MountError, is_there: bool) -> Draw:
    """Put up a scene and take a picture of it."""
    rng = np.random.default_rng([seed, k, is_there])
    shape = EUR_FULL if rng.random() < 0.5 else EUR_HALF
    distance, yaw = rng.uniform(*DISTANCE), rng.uniform(-TURNED, TURNED)
    front = np.array([camera.position[0] - distance, rng.uniform(-ASIDE, ASIDE) * distance, yaw])
    at = posed(front, np.array([-shape.length / 2, 0.0, 0.0]))
    what = "pallet" if is_there else OTHERS[rng.integers(len(OTHERS))]
    area = replace(HALL, boxes=tuple(clutter(rng, shape, at)))
    pallets, solids = [], list(another(what, shape, at, rng))
    if is_there:
        load = rng.integers(3)
        pallets.append(StatedPallet(shape, at, float(rng.uniform(0.2, 1.2)) if load == 1 else 0.0, NONE))
        solids += placed(cartons(rng, shape) if load == 2 else (), at)
    if rng.random() < 0.5:
        beside = (rng.uniform(-0.2, 0.2), rng.choice([-1, 1]) * (shape.width + rng.uniform(0.05, 0.3)), 0.0)
        pallets.append(StatedPallet(shape, posed(at, np.array(beside)), 0.5 * rng.integers(2), NONE))
    seen = rendered_area(area, NONE, tuple(pallets)).solids
    T = floor_pose(NONE) @ camera.T_truck_camera
    depth = measure_depth(
        RenderedScene((*seen, *solids)), camera.model, T @ within(mount, rng), 1000 * seed + k
    )
    zone = PalletZone(at + rng.uniform(-1.0, 1.0, 3) * OFF, TOLERANCE)
    picture = DepthPicture(depth.camera, T, depth.depth)
    return Draw(picture, shape, zone, at if is_there else None, what)


def within(mount: MountError, rng: np.random.Generator) -> Array:
    """(4, 4) true camera in the frame of the stated one, evenly within bounds."""
    shift, axis = rng.standard_normal((2, 3))
    shift *= mount.position * rng.random() ** (1 / 3) / np.linalg.norm(shift)
    turn = mount.angle * float(rng.random() ** (1 / 3))
    return pose(shift, R=rotation_axis_angle(axis / np.linalg.norm(axis), turn))


def clutter(rng: np.random.Generator, shape: PalletShape, at: Array) -> list[FloorBox]:
    """Boxes that do not overlap the pallet, of which one may stand before it."""
    boxes = []
    for _ in range(rng.integers(5)):
        place, size = at[:2] + rng.uniform(-1.8, 1.8, 2), rng.uniform(0.1, 0.6, 2)
        local = np.abs(seen_from(at, np.array([*place, 0.0]))[:2])
        if (local > np.array([shape.length, shape.width]) / 2 + 0.45).any() and place[0] < -0.5:
            boxes.append(
                FloorBox("box", tuple(place), tuple(size), rng.uniform(0, 3), rng.uniform(0.05, 1.2))
            )
    if rng.random() < 0.2:
        size = rng.uniform(0.05, 0.2, 2)
        local = np.array([shape.length / 2 + 0.15 + rng.uniform(0.0, 0.3), rng.uniform(-0.5, 0.5), 0.0])
        place = posed(at, local)
        boxes.append(
            FloorBox("before", tuple(place[:2]), tuple(size), rng.uniform(0, 3), rng.uniform(0.05, 0.3))
        )
    return boxes


def cartons(rng: np.random.Generator, shape: PalletShape) -> tuple[Body, ...]:
    """One to four cartons on the deck, up to 30 mm over its edges."""
    found = []
    for k in range(rng.integers(1, 5)):
        size = rng.uniform(0.15, 0.6, 3)
        half = np.maximum(np.array([shape.length, shape.width]) / 2 + 0.03 - size[:2] / 2, 0.0)
        x, y = rng.uniform(-half, half)
        low = np.array([x - size[0] / 2, y - size[1] / 2, shape.height])
        found.append(box(f"carton {k}", tuple(low), tuple(low + size)))
    return tuple(found)


def another(what: str, shape: PalletShape, at: Array, rng: np.random.Generator) -> list[RenderedSolid]:
    """What is no pallet, in its place."""
    half, side, deck = shape.length / 2, shape.width / 2, shape.height
    if what in ("narrow", "wide"):
        other = replace(shape, width=0.6 if what == "narrow" else 1.0, deck=(0.1, 0.1, 0.1))
        return placed(other.bodies, at)
    if what == "long side":
        return placed(EUR_FULL.bodies, at + np.array([0.0, 0.0, np.pi / 2]))
    bodies: list[Body] = []
    if what in ("crate", "flat box"):
        size = np.array([half, side]) if rng.random() < 0.5 else rng.uniform(0.15, 0.6, 2)
        height = deck if what == "flat box" else rng.uniform(0.08, 0.6)
        bodies = [box("crate", (-size[0], -size[1], 0.0), (size[0], size[1], height))]
    elif what == "beams":
        bodies = [box(f"beam {y}", (-half, y - 0.05, 0.0), (half, y + 0.05, 0.1)) for y in (-0.35, 0.35)]
        bodies.append(box("plank", (-half, -side, 0.1), (half, side, rng.uniform(0.13, 0.5))))
    elif what == "table":
        bodies = [
            box(f"leg {x} {y}", (x - 0.03, y - 0.03, 0.0), (x + 0.03, y + 0.03, 0.3))
            for x in (-half + 0.03, half - 0.03) for y in (-side + 0.03, side - 0.03)
        ]  # fmt: skip
        bodies.append(box("top", (-half, -side, 0.3), (half, side, 0.33)))
    elif what == "bin":
        high = rng.uniform(0.1, 0.5)
        bodies = [
            box("near", (half - 0.02, -side, 0.0), (half, side, high)),
            box("far", (-half, -side, 0.0), (-half + 0.02, side, high)),
            box("right", (-half, -side, 0.0), (half, -side + 0.02, high)),
            box("left", (-half, side - 0.02, 0.0), (half, side, high)),
        ]
    elif what == "heap":
        for k in range(12):
            low = np.array([*rng.uniform(-0.6, 0.5, 2), 0.0])
            bodies.append(box(f"piece {k}", tuple(low), tuple(low + rng.uniform(0.05, 0.25, 3))))
    return placed(tuple(bodies), at)


def placed(bodies: tuple[Body, ...], at: Array) -> list[RenderedSolid]:
    """Bodies as cameras see them."""
    T = floor_pose(at)
    return [RenderedSolid(OwnerKind.CARRIER, "other", each.shape, T @ each.T_parent_shape) for each in bodies]


@dataclass
class Figures:
    """What came of pictures."""

    errors: list[Array] = field(default_factory=list)  # (3,) m, m, rad, in the frame of the found pallet
    fronts: list[float] = field(default_factory=list)  # m, of the middle of the front
    bounds: list[Array] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    times: list[float] = field(default_factory=list)  # s
    missed: Counter[str] = field(default_factory=Counter)
    n_there: int = 0
    n_other: int = 0
    false: Counter[str] = field(default_factory=Counter)

    def add(self, drawn: Draw, mount: MountError) -> PalletEstimate | None:
        """Detect, and count."""
        noise = CAMERAS[0].model.depth
        assert noise is not None
        self.n_there, self.n_other = (
            self.n_there + (drawn.pose is not None), self.n_other + (drawn.pose is None)
        )  # fmt: skip
        began = thread_time()
        try:
            found = detect_pallet(drawn.picture, noise, drawn.shape, drawn.zone, mount)
        except InputError as fault:
            self.times.append(thread_time() - began)
            if drawn.pose is not None:
                self.missed[str(fault)[:90]] += 1
            return None
        self.times.append(thread_time() - began)
        if drawn.pose is None:
            self.false[drawn.what] += 1
            return None
        off = seen_from(found.pose, drawn.pose)
        if np.hypot(*off[:2]) > FALSE:
            self.false["elsewhere"] += 1
            self.missed["elsewhere"] += 1
            return None
        half = np.array([drawn.shape.length / 2, 0.0, 0.0])
        self.errors.append(off)
        self.fronts.append(float(np.hypot(*(posed(off, half) - half)[:2])))
        self.bounds.append(np.array([found.error.x, found.error.y, found.error.yaw]))
        front = posed(drawn.pose, half)
        self.distances.append(float(np.hypot(*(front[:2] - drawn.picture.T_world_camera[:2, 3]))))
        return found

    def __str__(self) -> str:
        """A table."""
        errors, bounds = np.abs(self.errors), np.array(self.bounds)
        position, yaw = 1e3 * np.hypot(*errors[:, :2].T), np.degrees(errors[:, 2])
        far = np.array(self.distances) > 1.8
        is_kept = (errors <= bounds).all(axis=1)
        n_missed, n_false = sum(self.missed.values()), sum(self.false.values())
        of_all = self.n_there + self.n_other
        rows = {
            "pictures with a pallet / without": f"{self.n_there} / {self.n_other}",
            "position, mm: median / p95 / worst": _three(position),
            "position beyond 1.8 m, mm: median / p95 / worst": _three(position[far]),
            "middle of the front, mm: median / p95 / worst": _three(1e3 * np.array(self.fronts)),
            "yaw, degrees: median / p95 / worst": _three(yaw, 2),
            "missed": f"{n_missed} ({100 * n_missed / max(1, self.n_there):.2f} %)",
            "false": f"{n_false} ({100 * n_false / max(1, of_all):.2f} % of all pictures)",
            "bounds kept": f"{100 * is_kept.mean():.2f} %",
            "bounds, median: x, y in mm, yaw in degrees": "{:.1f} / {:.1f} / {:.2f}".format(
                *np.median(bounds, axis=0) * [1e3, 1e3, np.degrees(1.0)]
            ),
            "time, ms: median / p95 / worst": _three(1e3 * np.array(self.times), 0),
        }
        told = [f"| {what} | {figure} |" for what, figure in rows.items()]
        told += [f"missed {n}: {why}" for why, n in self.missed.most_common()]
        return "\n".join(told + [f"false {n}: {what}" for what, n in self.false.most_common()])


def _three(values: Array, digits: int = 1) -> str:
    return " / ".join(f"{each:.{digits}f}" for each in np.percentile(values, (50, 95, 100)))


def calibrate(n: int, seed: int) -> None:
    """Print the factor of the bounds."""
    figures = Figures()
    pallet_pose.FACTOR = 1.0
    for k in range(n):
        figures.add(draw(CAMERAS[0], seed, k, EXACT, True), EXACT)
    ratios = ((np.abs(figures.errors) - ROUNDING) / (np.array(figures.bounds) - ROUNDING)).max(axis=1)
    print(f"factor {np.quantile(ratios, KEPT):.2f} for {KEPT:.1%} of {len(ratios)}, most {ratios.max():.2f}")


CAMERAS: list[TruckCamera] = []


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--pictures", type=int, default=500, help="with a pallet, and as many without")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sensor", default="carmine")
    parser.add_argument("--mount", action="store_true", help="the camera is off its stated pose")
    parser.add_argument("--calibrate", action="store_true", help="fit the factor of the bounds")
    given = parser.parse_args()
    CAMERAS.append(TruckCamera(read_sensor(sensor_file(given.sensor))))
    if given.calibrate:
        calibrate(given.pictures, given.seed)
        return
    mount, figures = MOUNT if given.mount else EXACT, Figures()
    for k in range(given.pictures):
        for is_there in (True, False):
            figures.add(draw(CAMERAS[0], given.seed, k, mount, is_there), mount)
    print(figures)


if __name__ == "__main__":
    main()
