"""Every state of a plan of one arm is free of the other arm by the meshes of both, judged by fcl alone.

A Baxter that others prepared. The judge reads the shapes from the URDF itself and knows neither spheres nor
convex pieces; the kinematics is the verifier's, of each arm in the cell that is its own.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from xml.etree import ElementTree

import fcl
import numpy as np
import pytest
import yaml

from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.robot import Robot
from pickcli.cell.tool import FIXED
from pickcli.cell.workcell import Workcell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import empty_scene
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.verify import certify
from support.other_robots import LIMIT

pytestmark = pytest.mark.slow

PACKAGE = "example-robot-data"
JOINTS = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")
MIRROR = np.array([-1, 1, -1, 1, -1, 1, -1])  # from one arm to the other
PARKED = np.array([0.08, -1.0, 1.19, 1.94, -0.67, 1.03, 0.50])  # the right arm's, beside the torso
FORWARD = np.array([0.5, -0.1, 0.3, 0.9, 0.0, 0.6, 0.0])  # the right arm's, before the torso
STEP = 0.01  # s between two judged states
N_PLANS = 12


@pytest.fixture(scope="module")
def baxter(tmp_path_factory: pytest.TempPathFactory) -> Workcell:
    try:
        listed = files(PACKAGE) or []
    except PackageNotFoundError:
        pytest.skip(f"{PACKAGE} is not installed (development extra)")
    urdf = Path(str(next(path for path in listed if path.name == "baxter.urdf").locate()))
    folder = tmp_path_factory.mktemp("baxter")
    (folder / "robot.urdf").write_text(urdf.read_text())
    srdf = urdf.parents[1] / "srdf" / "baxter_manipulation.srdf"
    (folder / "robot.srdf").write_text(srdf.read_text())
    sides = {"left": MIRROR, "right": np.ones(7)}
    both = [f"{side}_{joint}" for side in sides for joint in JOINTS]
    content = {
        "format": "apc cell",
        "version": 2,
        "name": "baxter",
        "robot": {
            "urdf": "robot.urdf",
            "srdf": "robot.srdf",
            "packages": {PACKAGE: str(urdf.parents[3])},
            "T_world_base": {"xyz": [0.0, 0.0, 0.93], "rpy": [0.0, 0.0, 0.0]},
            "posture": {"head_pan": 0.0, "l_gripper_l_finger_joint": 0.0, "r_gripper_l_finger_joint": 0.0},
            "unshaped": [
                "display",
                *(f"{s}_hand_{part}_link" for s in sides for part in ("camera", "range", "accelerometer")),
            ],
            "motor_forces": dict.fromkeys(both, 50.0),
        },
        "joint_limits": {joint: dict(LIMIT) for joint in both},
        "speed_scale": 1.0,
        "clearance": 0.003,
        "arms": {
            side: {"joints": [f"{side}_{j}" for j in JOINTS], "tip": f"{side}_gripper", "parked": "parked"}
            for side in sides
        },
        "obstacles": [],
        "devices": {},
        "allowed_pairs": [],
        "configurations": [
            {"name": name, "arm": side, "kind": "midway", "q": (sign * q).tolist()}
            for side, sign in sides.items()
            for name, q in (("parked", PARKED), ("forward", FORWARD))
        ],
    }  # fmt: skip
    (folder / "cell.yaml").write_text(yaml.safe_dump(content))
    return load_workcell(folder)


class Judge:
    """The shapes of both arms as the URDF has them, each posed by the kinematics of its own cell."""

    def __init__(self, workcell: Workcell) -> None:
        self._robots = {name: cell.robot for name, cell in workcell.arms.items()}
        self._solids = {
            name: list(_solids(robot, workcell.preferred.path)) for name, robot in self._robots.items()
        }
        spared = {frozenset((pair.a, pair.b)) for pair in workcell.preferred.allowed_pairs}
        left, right = self._solids["left"], self._solids["right"]
        self._pairs = [
            (one, other) for a, _, one in left for b, _, other in right if frozenset((a, b)) not in spared
        ]

    def deepest(self, Q: dict[str, Array]) -> float:
        """The least distance (m) of any two shapes of different arms at configurations (N, n) of each."""
        poses = {name: _poses(robot, Q[name]) for name, robot in self._robots.items()}
        least = np.inf
        for k in range(len(Q["left"])):
            for name, solids in self._solids.items():
                for link, T, solid in solids:
                    T_world = poses[name][link][k] @ T
                    solid.setTransform(fcl.Transform(T_world[:3, :3], T_world[:3, 3]))
            for one, other in self._pairs:
                if fcl.collide(one, other):
                    return -1.0
                least = min(least, fcl.distance(one, other))
        return least


def _poses(robot: Robot, Q: Array) -> dict[str, Array]:
    return dict(zip((link.name for link in robot.links), link_poses(robot, Q), strict=True))


def _solids(robot: Robot, folder: Path):  # type: ignore[no-untyped-def]
    """Link, pose in it and fcl object of every shape that the arm's joints move, from the URDF's text."""
    moved = {robot.links[0].name: False}
    for joint in robot.joints:
        moved[joint.child] = moved[joint.parent] or joint.name in robot.joint_names
    packages = yaml.safe_load((folder / "cell.yaml").read_text())["robot"]["packages"]
    for link in ElementTree.parse(folder / "robot.urdf").iter("link"):
        if not moved.get(link.attrib["name"]):
            continue
        for shape in link.findall("collision"):
            origin = shape.find("origin")
            values = {} if origin is None else origin.attrib
            xyz, rpy = (np.array([float(v) for v in values.get(k, "0 0 0").split()]) for k in ("xyz", "rpy"))
            geometry = shape.find("geometry")
            assert geometry is not None
            yield (
                link.attrib["name"], pose(xyz, rpy=rpy), fcl.CollisionObject(_geometry(geometry[0], packages))
            )  # fmt: skip


def _geometry(shape: ElementTree.Element, packages: dict[str, str]) -> object:
    values = {
        key: [float(v) for v in text.split()] for key, text in shape.attrib.items() if key != "filename"
    }
    if shape.tag == "box":
        return fcl.Box(*values["size"])
    if shape.tag == "cylinder":
        return fcl.Cylinder(values["radius"][0], values["length"][0])
    if shape.tag == "sphere":
        return fcl.Sphere(values["radius"][0])
    path = Path(shape.attrib["filename"].replace(f"package://{PACKAGE}", packages[PACKAGE]))
    triangles = parse_triangles(path, read_mesh_bytes(path), tuple(values.get("scale", (1.0, 1.0, 1.0))))
    model = fcl.BVHModel()
    model.beginModel(len(triangles), 3 * len(triangles))
    model.addSubModel(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    model.endModel()
    return model


def _cell_beside(workcell: Workcell, q: Array) -> Cell:
    return workcell.cell("left", [ArmState("right", q, FIXED)])


def test_every_state_is_free_of_the_other_arm(baxter: Workcell) -> None:
    cell, judge = _cell_beside(baxter, FORWARD), Judge(baxter)
    scene, context = empty_scene(cell), PlanningContext(cell, None, None)
    checker = SceneChecker(CollisionModel(cell), scene, FIXED)
    alone = SceneChecker(CollisionModel(baxter.arms["left"]), empty_scene(baxter.arms["left"]), FIXED)
    rng = np.random.default_rng(0)
    limits = cell.robot.limits
    planned = in_the_way = 0
    while planned < N_PLANS:
        ends: list[Array] = []
        while len(ends) < 2:
            q = rng.uniform(limits.lower, limits.upper)
            if checker.is_valid(q) and Arm(cell.robot).tip(q, FIXED)[0, 3] > 0.3:
                ends.append(q)
        straight = np.array(ends)
        if checker.is_valid_path(straight) or not alone.is_valid_path(straight):
            continue  # it is the other arm that has to be in the way
        beside = np.linspace(ends[0], ends[1], 200)
        in_the_way += judge.deepest({"left": beside, "right": np.tile(FORWARD, (200, 1))}) < 0.003
        try:
            plan = certify(
                plan_move(context, scene, Start(ends[0], FIXED), MoveGoal(ends[1]), planned), scene
            )
        except NoPlanError:
            continue
        t = np.arange(0.0, plan.trajectory.duration, STEP)
        Q = plan.trajectory.sample(t)
        assert judge.deepest({"left": Q, "right": np.tile(FORWARD, (len(Q), 1))}) > 0.0
        planned += 1
    assert in_the_way > N_PLANS // 3  # the judge sees what the straight way would meet
