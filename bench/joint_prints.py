"""How exactly prints in three looks, solved together, tell where items are, and whether bounds hold.

    python -m bench.joint_prints --seeds 8150001-8150010 [--sensor ensenso]

Each seed is an order drawn by the rules of 2016, stowed by the package's scene maker, with three photographs
of each bin by a sensor on the gripper, as in trials by camera: cameras are located in the pod of each
picture, labels are damaged, light, exposure and white balance are drawn. Nothing but prints is looked for.
Errors are of position, angle and surface, symmetries of the shape aside; a bound is kept if all three are
within theirs. Seeds 8140001 to 8140005, of Carmine and Kinect v2 8240001 and 8240002, gave the
factors of bounds, the largest of what is printed last.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bench.perceived import fresh_scene, numbers_in, seen_bins
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.geometry import Array
from pickcli.perception.items.place_view import view_of_place
from pickcli.perception.items.pose_bound import joint_bound_of
from pickcli.perception.items.pose_spread import spread_of
from pickcli.perception.items.print_search import prints_in
from pickcli.perception.items.routing import pixels_per_mm
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.items.unknown_voxels import ASIDE
from pickcli.perception.textures.print_agreement import joint_print_poses
from pickcli.perception.textures.sift_views import SiftViews
from pickcli.scene.scene import PoseNoise
from pickcli.trial.simulated_cameras import PRINTS_OF_TRIALS

N_LOOKS = 3
OFF = "mm, degrees, mm of the surface"


@dataclass(frozen=True, eq=False)
class Solved:
    """An item whose print two looks or more recognised.

    Attributes:
        is_clear: Whether it is of clear material.
        error: (3,) mm, degrees and mm of the surface by which its pose is off.
        deviations: (3,) of these.
        bound: Those of the bounds; None if they are too wide to be of use.
        is_kept: Whether the error is within them.
    """

    is_clear: bool
    error: Array
    deviations: Array
    bound: Array | None
    is_kept: bool


def solved_in(cell: Cell, sensor: SensorModel, seed: int) -> Iterator[tuple[int, list[Solved]]]:
    """Of each bin of a fresh scene the number of printed items, and those that were solved for."""
    scene = fresh_scene(cell, seed)
    for seen in seen_bins(scene, sensor, N_LOOKS, print_set=PRINTS_OF_TRIALS):
        items = [placed.item for placed in seen.items]
        views = {item: SiftViews.ALL for item in items if item.is_printed}
        looks, T_world_place = [], scene.T_world_place(seen.place)
        fineness = min(
            pixels_per_mm(sensor.camera, rgbd.T_world_camera, seen.place, T_world_place)
            for rgbd, _ in seen.pictures
        )
        for rgbd, known in seen.pictures:
            view = view_of_place(rgbd, seen.place, T_world_place, known)
            assert view is not None
            looks.append((rgbd.T_world_camera, prints_in(rgbd, view, items, views, PRINTS_OF_TRIALS)))
        found = []
        for item in dict.fromkeys(items):
            true = [placed.T_world_item for placed in seen.items if placed.item == item]
            for joint in joint_print_poses(item, [(T, each.get(item, ())) for T, each in looks], ASIDE):
                errors = [error_of(item.shape, joint.T_world_item, T) for T in true]
                error = min(errors, key=lambda each: each.position)
                spread, bound = (
                    spread_of(item.shape, joint.covariance),
                    joint_bound_of(item, joint.covariance, fineness),
                )
                stated = PoseNoise(spread.position, spread.angle, spread.surface)
                found.append(
                    Solved(
                        item.material is Material.CLEAR, figures(error), figures(stated),
                        None if bound is None else figures(bound), bound is not None and bound.holds(error),
                    )
                )  # fmt: skip
        yield sum(item.is_printed for item in items), found


def figures(error: PoseNoise) -> Array:
    """(3,) mm, degrees and mm of the surface."""
    assert error.displacement is not None
    return np.array([1e3 * error.position, np.degrees(error.angle), 1e3 * error.displacement])


def report(name: str, found: Sequence[Solved]) -> None:
    """Print the figures of some items."""
    stated = [each for each in found if each.bound is not None]
    if not stated:
        print(f"{name}: none")
        return
    errors, bounds = (np.array([getattr(each, what) for each in stated]) for what in ("error", "bound"))
    kept = sum(each.is_kept for each in stated)
    share = f"{kept} within them ({kept / len(stated):.1%})"
    print(f"{name}: {len(found)} poses, {len(stated)} with bounds, {share}")
    for what, table in (("errors", errors), ("bounds", bounds)):
        medians, p95 = np.median(table, axis=0).round(2), np.percentile(table, 95, axis=0).round(2)
        print(f"  {what}: median {medians.tolist()}, p95 {p95.tolist()} ({OFF})")
    ratios = np.array([each.error / np.maximum(each.deviations, 1e-9) for each in found])
    print(f"  errors over deviations, largest: {ratios.max(axis=0).round(2).tolist()}")


def main() -> None:
    """Look, and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", required=True, help="of scenes, e.g. 8150001-8150010")
    parser.add_argument("--sensor", default="ensenso", help="a file under data/sensors")
    arguments = parser.parse_args()
    sensor = read_sensor(sensor_file(arguments.sensor))
    cell, n_printed, found = load_cell("apc2016_delft"), 0, list[Solved]()
    for seed in numbers_in(arguments.seeds):
        for n, solved in solved_in(cell, sensor, seed):
            n_printed += n
            found += solved
        print(f"{seed}: {len(found)} of {n_printed} printed items so far", flush=True)
    report("clear", [each for each in found if each.is_clear])
    report("others", [each for each in found if not each.is_clear])
    report("all", found)


if __name__ == "__main__":
    main()
