"""How well the pod is located from one depth picture, at random poses of its tolerance.

    python -m bench.pod_pose [--shifts 200] [--seed 0] [--sensor kinect_v2] [--height 1.25] [--json FILE]

A full shelf, seen from the middle before it at 1.45 m, as by a camera at a robot's waist; no robot is in the
picture. Times are processor time of one thread.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from time import thread_time

import numpy as np

from bench.perception import full_shelf
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file, sensor_names
from pickcli.errors import InputError
from pickcli.geometry import inverse, rotation_angle
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.pod_pose import locate_pod
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene

AWAY = 1.45  # m from the pod's mouths to the camera
LOOKING_AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def measure(n: int, seed: int, sensor_name: str, height: float) -> dict[str, float]:
    """Locate the pod at random poses.

    Args:
        n: Number of poses.
        seed: Of poses and noise.
        sensor_name: Model of the camera.
        height: m of the camera over the floor.

    Returns:
        Errors (mm and degrees), failures and times (ms).
    """
    cell, sensor = load_cell("apc2016_delft"), read_sensor(sensor_file(sensor_name))
    scene, home = full_shelf(cell), cell.configurations["home"]
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3], T_world_camera[:3, 3] = LOOKING_AHEAD, (-AWAY, 0.0, height)
    found, failures, bounds = [], 0, cell.pod.displacement
    for k in range(n):
        rng = np.random.default_rng([seed, k])
        T = displaced(cell.T_world_pod, *rng.uniform(-1.0, 1.0, 3) * [bounds.x, bounds.y, bounds.yaw])
        moved = T @ inverse(cell.T_world_pod)
        items = tuple(replace(p, T_world_item=moved @ p.T_world_item) for p in scene.items)
        seen = RenderedScene.of(replace(scene, T_world_pod=T, items=items), home.q, home.tool_state)
        seen = RenderedScene(tuple(each for each in seen.solids if each.kind is not OwnerKind.LINK))
        picture = measure_depth(seen, sensor, T_world_camera, seed + k)
        began = thread_time()
        try:
            off = inverse(T) @ locate_pod(picture, cell).T_world_pod
        except InputError:
            failures += 1
            continue
        took = 1e3 * (thread_time() - began)
        found.append((1e3 * np.hypot(*off[:2, 3]), np.degrees(rotation_angle(off[:3, :3])), took))
    p50, p95 = np.percentile(np.array(found), [50, 95], axis=0)
    names = ("position_mm", "yaw_deg", "time_ms")
    figures = {f"{name}_median": float(v) for name, v in zip(names, p50, strict=True)}
    figures |= {f"{name}_p95": float(v) for name, v in zip(names, p95, strict=True)}
    worst = np.array(found).max(axis=0)
    return {
        **figures,
        "position_mm_max": float(worst[0]),
        "yaw_deg_max": float(worst[1]),
        "failures": failures,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--shifts", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sensor", choices=sensor_names(), default="kinect_v2")
    parser.add_argument("--height", type=float, default=1.25, help="m over the floor")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(given.shifts, given.seed, given.sensor, given.height)
    for name, value in figures.items():
        print(f"{name:>20} {value:.3f}")
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
