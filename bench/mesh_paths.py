"""Do the exact meshes of a robot touch anything along paths that were proven with its spheres?

    python -m bench.mesh_paths [--robots panda ur5] [--queries 500] [--seed 0] [--without-tool] [--json FILE]

The robot, with a suction cup unless it is left out, stands before shelf and tote of the default cell, among
boxes that are drawn again for every query, and goes from one free configuration to another; paths are
shortened. The judge knows nothing of spheres and convex pieces: the triangles of the URDF's collision meshes,
as bounding volume hierarchies of python-fcl, against each other and against all boxes, every 5 mrad of the
joint that moves most. So that it is known to see something, it judges the straight edges that are not proven
as well: most of them do touch.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any
from xml.etree import ElementTree

import fcl
import numpy as np
import yaml

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.shapes import Body, Shape, ShapeKind, box
from pickcli.cell.station import Obstacles
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, pose
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.verification.forward_kinematics import link_poses

STEP = 0.005  # rad of a joint between two judged configurations
BASE = (-0.75, 0.0, 0.9)  # m, before the shelf
PACKAGE = "example-robot-data"
TOOL = """<robot name="suction_cup">
<link name="mount">
<collision><origin xyz="0 0 0.06"/><geometry><cylinder radius="0.02" length="0.12"/></geometry></collision>
</link>
<link name="cup">
<collision><origin xyz="0 0 0.02"/><geometry><cylinder radius="0.015" length="0.04"/></geometry></collision>
</link>
<joint name="mount_cup" type="fixed"><parent link="mount"/><child link="cup"/><origin xyz="0 0 0.12"/></joint>
</robot>
"""


@dataclass(frozen=True)
class Arm:
    """A robot of the package, and what of it is planned.

    Attributes:
        urdf: Under the package's folder of robots.
        srdf: Under the same folder.
        joints: The planned joints.
        flange: Link that carries the tool.
        without: Links that are not there.
    """

    urdf: str
    srdf: str
    joints: tuple[str, ...]
    flange: str
    without: tuple[str, ...] = ()


ARMS = {
    "panda": Arm(
        "panda_description/urdf/panda.urdf",
        "panda_description/srdf/panda.srdf",
        tuple(f"panda_joint{k}" for k in range(1, 8)),
        "panda_link8",
        ("panda_hand",),
    ),
    "ur5": Arm(
        "ur_description/urdf/ur5_robot.urdf",
        "ur_description/srdf/ur5.srdf",
        (
            "shoulder_pan_joint",
            "shoulder_lift_joint",
            "elbow_joint",
            "wrist_1_joint",
            "wrist_2_joint",
            "wrist_3_joint",
        ),
        "tool0",
    ),
}


def installed() -> Path:
    """Folder of the package where pip puts it."""
    found = next(Path(sys.prefix).glob(f"lib/python*/site-packages/cmeel.prefix/share/{PACKAGE}"), None)
    if found is None:
        raise SystemExit(f"{PACKAGE} is not installed; pip install {PACKAGE}, or say where it is with --data")
    return found


def make_cell(name: str, data: Path, folder: Path, has_tool: bool = True) -> Cell:
    """The default cell's shelf and tote, with another robot before them."""
    arm, default = ARMS[name], yaml.safe_load((data_path() / "cells/apc2016_delft/cell.yaml").read_text())
    limits = {"max_velocity": 2.0, "max_acceleration": 10.0, "max_jerk": 100.0}
    has = {f"has_{kind}_limits": True for kind in ("velocity", "acceleration", "jerk")}
    tool = {key: value for key, value in default["tool"].items() if key not in ("joint", "states")}
    links = {"flange_link": arm.flange, "lance_link": "mount", "cup_link": "cup", "cup_length": 0.04}
    content = default | {
        "name": name,
        "robot": {
            "urdf": "robot.urdf",
            "srdf": "robot.srdf",
            "packages": {PACKAGE: str(data)},
            "T_world_base": {"xyz": list(BASE), "rpy": [0.0, 0.0, 0.0]},
            "joints": list(arm.joints),
            "without": list(arm.without),
            "motor_forces": dict.fromkeys(arm.joints, 100.0),
        },
        "joint_limits": {joint: {**has, **limits} for joint in arm.joints},
        "tool": tool | links | {"urdf": "tool.urdf"},
        "obstacles": [],
        "devices": {},
        "sensors": {},
        "allowed_pairs": [],
        "configurations": [],
    }
    if not has_tool:
        content["robot"] |= {"tip": arm.flange}
        del content["tool"]
    (folder / "robot.urdf").write_bytes((data / "robots" / arm.urdf).read_bytes())
    (folder / "robot.srdf").write_bytes((data / "robots" / arm.srdf).read_bytes())
    (folder / "tool.urdf").write_text(TOOL)
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    return load_cell(folder)


class Judge:
    """The exact meshes of a robot among boxes.

    Args:
        cell: The robot's cell.
        data: Folder of the package that its meshes are in.
    """

    def __init__(self, cell: Cell, data: Path) -> None:
        self._robot = robot = cell.robot
        meshes = dict(_meshes(robot.urdf, data))
        self._solids: list[tuple[int, str, Array, Any]] = []  # link, its name, pose in it, solid
        for i, link in enumerate(robot.links):
            if link.name in meshes:
                solids = [(T, _hierarchy(triangles)) for T, triangles in meshes[link.name]]
            else:
                solids = [(body.T_parent_shape, _geometry(body.shape)) for body in link.bodies]
            self._solids += [(i, link.name, T, fcl.CollisionObject(solid)) for T, solid in solids]
        movers = [self._movers(link.name) for link in robot.links]
        spared = {frozenset((p.a, p.b)) for p in cell.allowed_pairs}
        spared |= {frozenset((joint.parent, joint.child)) for joint in robot.joints}
        self._pairs = [
            (one, other)
            for (i, a, _, one), (j, b, _, other) in combinations(self._solids, 2)
            if movers[i] != movers[j] and frozenset((a, b)) not in spared
        ]
        self._moving = [solid for i, _, _, solid in self._solids if movers[i]]

    def touches(self, bodies: list[tuple[Body, Array]], waypoints: Array) -> bool:
        """Whether anything touches anywhere on a polyline (N, n)."""
        world = fcl.DynamicAABBTreeCollisionManager()
        world.registerObjects(
            [
                fcl.CollisionObject(_geometry(body.shape), _transform(T @ body.T_parent_shape))
                for body, T in bodies
            ]
        )
        world.setup()
        for block in np.array_split(densely(waypoints), 1 + len(waypoints)):
            poses = link_poses(self._robot, block)
            for k in range(len(block)):
                for i, _, T, solid in self._solids:
                    solid.setTransform(_transform(poses[i, k] @ T))
                if any(fcl.collide(one, other) for one, other in self._pairs):
                    return True
                for solid in self._moving:
                    data = fcl.CollisionData()
                    world.collide(solid, data, fcl.defaultCollisionCallback)
                    if data.result.is_collision:
                        return True
        return False

    def _movers(self, link: str) -> frozenset[str]:
        """The planned joints that move a link."""
        by_child = {joint.child: joint for joint in self._robot.joints}
        found = []
        while link in by_child:
            found.append(by_child[link].name)
            link = by_child[link].parent
        return frozenset(found) & set(self._robot.joint_names)


def densely(waypoints: Array) -> Array:
    """Configurations (K, n) on a polyline (N, n), no joint farther than STEP from one to the next."""
    pieces = []
    for a, b in pairwise(waypoints):
        n = int(np.ceil(np.abs(b - a).max() / STEP)) + 1
        pieces.append(a + np.linspace(0.0, 1.0, n)[:, None] * (b - a))
    return np.vstack(pieces)


def _meshes(urdf: Path, data: Path) -> Iterator[tuple[str, list[tuple[Array, Array]]]]:
    """By link: pose in the link and triangles (T, 3, 3) of each mesh, as the URDF has them."""
    for link in ElementTree.parse(urdf).iter("link"):
        found = []
        for collision in link.findall("collision"):
            mesh, origin = collision.find("geometry/mesh"), collision.find("origin")
            if mesh is not None:
                path = Path(mesh.attrib["filename"].replace(f"package://{PACKAGE}", str(data)))
                scale = tuple(float(v) for v in mesh.get("scale", "1 1 1").split())
                xyz, rpy = ((origin.get(key) if origin is not None else None) for key in ("xyz", "rpy"))
                T = pose(_floats(xyz), rpy=_floats(rpy))
                found.append((T, parse_triangles(path, read_mesh_bytes(path), scale)))
        if found:
            yield link.attrib["name"], found


def _floats(text: str | None) -> Array:
    return np.zeros(3) if text is None else np.array([float(v) for v in text.split()])


def _hierarchy(triangles: Array) -> Any:
    model = fcl.BVHModel()
    model.beginModel(len(triangles), 3 * len(triangles))
    model.addSubModel(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    model.endModel()
    return model


def _geometry(shape: Shape) -> Any:
    if shape.kind is ShapeKind.BOX:
        return fcl.Box(*shape.size)
    return fcl.Cylinder(*shape.size) if shape.kind is ShapeKind.CYLINDER else fcl.Sphere(*shape.size)


def _transform(T: Array) -> Any:
    return fcl.Transform(T[:3, :3], T[:3, 3])


def scenes(cell: Cell, n: int, seed: int) -> Iterator[tuple[int, Scene]]:
    """Scenes with boxes of 2 to 20 cm around the robot, none within 15 cm of its axis."""
    for k in range(n):
        rng = derived_rng(seed, "boxes", k)
        boxes: list[Body] = []
        while len(boxes) < 14:
            middle = np.array(BASE) + rng.uniform((-0.9, -0.9, -0.2), (0.6, 0.9, 1.1))
            half = rng.uniform(0.02, 0.2, 3)
            if np.hypot(*np.maximum(np.abs(middle - BASE) - half, 0.0)[:2]) > 0.15:
                low, high = (middle - half).tolist(), (middle + half).tolist()
                boxes.append(box(f"box_{len(boxes)}", tuple(low), tuple(high)))
        among = replace(cell, obstacles=Obstacles(tuple(boxes)))
        yield k, Scene(among, cell.T_world_pod, (), PoseNoise())


def measure(name: str, data: Path, n: int, seed: int, has_tool: bool) -> dict[str, Any]:
    """Plan and judge n queries of one robot."""
    with TemporaryDirectory() as folder:
        cell = make_cell(name, data, Path(folder), has_tool)
        judge = Judge(cell, data)
    model, space, state = CollisionModel(cell), JointSpace.of(cell.robot), cell.robot.tool.default_state
    lengths: list[float] = []
    times: list[float] = []
    unsolved, touching = 0, []
    blocked, blocked_touching = 0, 0
    for k, scene in scenes(cell, n, seed):
        checker, rng = SceneChecker(model, scene, state), derived_rng(seed, "ends", k)
        ends: list[Array] = []
        while len(ends) < 2:
            q = rng.uniform(*cell.robot.limits.window)
            if checker.is_valid(q):
                ends.append(q)
        began = process_time()
        path = plan(checker, space, ends[0], ends[1][None], seed=derived_seed(seed, "plan", k))
        if path is None:
            unsolved += 1
            continue
        path = shorten(checker, space, path, seed=derived_seed(seed, "shorten", k))
        times.append(1e3 * (process_time() - began))
        lengths.append(path.length)
        edge = np.array(ends)
        if not checker.is_valid_path(edge):
            blocked += 1
            blocked_touching += judge.touches(list(scene.standing), edge)
        if judge.touches(list(scene.standing), path.waypoints):
            touching.append(k)
        print(f"\r{name}: {k + 1} of {n}, {len(touching)} touch", end="", file=sys.stderr)
    print(file=sys.stderr)
    return {
        "queries": n,
        "paths": len(lengths),
        "unsolved": unsolved,
        "touching": len(touching),
        "which_touch": touching,
        "straight_edges_not_proven": blocked,
        "straight_edges_not_proven_touching": blocked_touching,
        "length_mean_rad": float(np.mean(lengths)),
        "planning_ms_median": float(np.median(times)),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="+", choices=sorted(ARMS), default=sorted(ARMS))
    parser.add_argument("--queries", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--without-tool", action="store_true", help="its spheres are coarser")
    parser.add_argument(
        "--data", type=Path, help="folder of the package example-robot-data, if not installed"
    )
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    data = arguments.data or installed()
    given = arguments.queries, arguments.seed, not arguments.without_tool
    found = {name: measure(name, data, *given) for name in arguments.robots}
    print(json.dumps(found, indent=2))
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
