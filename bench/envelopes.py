"""Envelopes as goal regions against fixed grasps, among cans in the way.

    python -m bench.envelopes [--scenes 40] [--seed 0]

In `panda_table` a can stands on a post among cans on posts: free, six of them beside and behind it, six all
round it, and these with a plank above. Its side is reached with open fingers from the named configuration
home: by the region query over both envelopes of the side, the hand this way up or the other; by eight fixed
grasps from eight azimuths, either way up; and by the one of these that is nearest to the robot. Each is the
straight joint line to the nearest goal that has one, else RRT-Connect, shortened. Travel is the sum of all
joints' ways; it is compared on scenes that both solve. Then poses of truncated envelopes are tried with the
tool's own collision model: kept are those that collide.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from rich.console import Console
from rich.table import Table

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, pose
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.envelope_truncation import truncated
from pickcli.grasping.finger_envelopes import FingerReach, finger_envelopes
from pickcli.kinematics.arm import Arm
from pickcli.motion.path import JointPath
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.planning.region_query import RegionChecks, RegionProblem, plan_to_region
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_seed

RADIUS, HEIGHT = 0.025, 0.12  # m, of every can
NEAREST, FARTHEST = 0.18, 0.28  # m, from the target's axis to those of its neighbours
ALL_ROUND, BEHIND = (0.0, 2 * np.pi), (-np.pi / 2, np.pi / 2)  # rad, of neighbours as seen from the robot
N_NEIGHBOURS = 6
N_FIXED = 8
PLACE = "mat_front"
KINDS = ("free", "behind", "all round", "plank")
POST = 0.3  # m, on posts of which height the cans stand, so that the hand can come level
GAP = 1e-3  # m, between what stands on each other
N_TRIED = 1000  # poses of each truncated envelope


@dataclass
class Row:
    """What one way of choosing the goal came to.

    Attributes:
        lengths: rad, by scene: the way of all joints.
        times: s, by scene.
    """

    lengths: dict[int, float] = field(default_factory=dict)
    times: list[float] = field(default_factory=list)


def can(cell: Cell, name: str, x: float, y: float) -> PlacedItem:
    """Stand a can on the mat."""
    return _placed(cell, name, Shape(ShapeKind.CYLINDER, (RADIUS, HEIGHT)), x, y, POST + GAP + HEIGHT / 2)


def _placed(cell: Cell, name: str, shape: Shape, x: float, y: float, z: float) -> PlacedItem:
    seals = dict.fromkeys(shape.face_names, 0.0)
    item = Item(name, 2016, shape, 0.3, 0, seals, "made up", "printed", 0.0, 1.0, "", "made up")
    mat = cell.T_world_place(cell.places[PLACE])[2, 3]
    return PlacedItem(name, item, PLACE, pose((x, y, mat + z + GAP)))


def scene_of(bench: Bench, rng: np.random.Generator, kind: str) -> Scene:
    """Draw a scene of one kind, the target first, in which the arm stands free."""
    while True:
        scene = _scene(bench.cell, rng, kind)
        if SceneChecker(bench.model, scene, bench.state).is_valid(bench.home):
            return scene


def _scene(cell: Cell, rng: np.random.Generator, kind: str) -> Scene:
    x, y = 0.46 + rng.uniform(-0.06, 0.06), rng.uniform(-0.12, 0.12)
    items = [can(cell, "target", x, y)]
    low, high = BEHIND if kind == "behind" else ALL_ROUND
    middle = np.arctan2(y, x)
    step = (high - low) / N_NEIGHBOURS
    for i in range(N_NEIGHBOURS if kind != "free" else 0):
        angle = middle + low + (i + 0.5 + rng.uniform(-0.25, 0.25)) * step
        off = rng.uniform(NEAREST, FARTHEST)
        items.append(can(cell, f"neighbour {i}", x + off * np.cos(angle), y + off * np.sin(angle)))
    post = Shape(ShapeKind.CYLINDER, (RADIUS, POST - GAP))
    for stands in tuple(items):
        at = stands.T_world_item[:2, 3]
        items.append(_placed(cell, f"post of {stands.id}", post, at[0], at[1], POST / 2))
    if kind == "plank":
        plank = Shape(ShapeKind.BOX, (0.24, 0.12, 0.02))
        items.append(_placed(cell, "plank", plank, x, y, POST + HEIGHT + 0.12))
    return Scene(cell, cell.T_world_pod, tuple(items), PoseNoise())


def fixed_grasps(sides: Sequence[Envelope]) -> Array:
    """Return poses (16, 4, 4) of the tip at the middle of both envelopes of a side, from eight azimuths."""
    found = []
    for side in sides:
        coordinates = np.tile((side.low + side.high) / 2, (N_FIXED, 1))
        coordinates[:, 0] = np.arange(N_FIXED) * 2 * np.pi / N_FIXED
        found.append(side.poses_at(coordinates, np.zeros(N_FIXED), np.zeros((N_FIXED, 2))))
    return np.concatenate(found)


class Bench:
    """The cell, and the ways in which goals are chosen."""

    def __init__(self) -> None:
        self.cell = load_cell("panda_table")
        self.arm, self.model = Arm(self.cell.robot), CollisionModel(self.cell)
        self.space = JointSpace.of(self.cell.robot, self.cell.speed_scale)
        self.state = self.cell.robot.tool.default_state
        self.home = self.cell.configurations["home"].q

    def play(self, scene: Scene, seed: int, rows: dict[str, Row], k: int) -> None:
        """Solve a scene in every way."""
        T = scene.items[0].T_world_item
        contacts = AllowedContacts.at_any_depth(["target"])
        tool = FreeToolChecker(self.model, scene, self.state, np.eye(3), contacts)
        checker = SceneChecker(self.model, scene, self.state, contacts=contacts)
        envelopes = self.envelopes(scene, tool)
        fixed = T @ fixed_grasps(envelopes)
        nearest = int(
            np.argmax(fixed[:N_FIXED, :2, 2] @ T[:2, 3])
        )  # whose approach leads away from the robot
        near = fixed[[nearest, N_FIXED + nearest]]
        problem = RegionProblem(envelopes, T, self.state, self.home)
        ways: dict[str, Callable[[], JointPath | None]] = {
            "region": lambda: plan_to_region(
                self.arm,
                self.space,
                problem,
                RegionChecks(tool.are_valid_at, checker),
                derived_seed("bench", seed, k),
            ),
            "8 fixed": lambda: self.fixed(checker, fixed, seed + k),
            "1 fixed": lambda: self.fixed(checker, near, seed + k),
        }
        for name, way in ways.items():
            start = time.perf_counter()
            path = way()
            rows[name].times.append(time.perf_counter() - start)
            if path is not None:
                rows[name].lengths[k] = float(np.abs(np.diff(path.waypoints, axis=0)).sum())

    def envelopes(self, scene: Scene, tool: FreeToolChecker) -> tuple[Envelope, ...]:
        """Return the envelopes of the target's side."""
        robot = self.cell.robot
        assert isinstance(robot.tool.grip, ParallelGripper)
        fingers = FingerReach.of(robot.tool, robot.tool.grip, tool.depth)
        return finger_envelopes(scene.items[0].item.shape, fingers)[:2]

    def fixed(self, checker: SceneChecker, poses: Array, seed: int) -> JointPath | None:
        """Plan a path to any of some poses (K, 4, 4), for each of which sixteen seeds are tried."""
        rng = np.random.default_rng(seed)
        goals = np.concatenate([self.arm.solve_spread(T, self.state, rng) for T in poses])
        path = plan(checker, self.space, self.home, goals, seed=seed) if len(goals) else None
        return path and shorten(checker, self.space, path, seed=seed)

    def colliding(self, scene: Scene, rng: np.random.Generator) -> tuple[int, int]:
        """Count poses of truncated envelopes, and those of them at which the tool is not free."""
        T = scene.items[0].T_world_item
        contacts = AllowedContacts.at_any_depth(["target"])
        tool = FreeToolChecker(self.model, scene, self.state, np.eye(3), contacts)
        n = n_colliding = 0
        for envelope in self.envelopes(scene, tool):
            part = truncated(envelope, T, tool).envelope
            if part is not None:
                poses = T @ part.sample(rng, N_TRIED)
                n += len(poses)
                n_colliding += int((~tool.are_valid(tool.displacements(poses))).sum())
        return n, n_colliding


def main() -> None:
    """Print a row for each kind of scene."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    bench = Bench()
    table = Table("scene", "way", "solved", "travel, rad", "of 8 fixed, common", "s, median")
    n = n_colliding = 0
    for kind in KINDS:
        rows = {name: Row() for name in ("region", "8 fixed", "1 fixed")}
        rng = np.random.default_rng([options.seed, len(kind)])
        for k in range(options.scenes):
            scene = scene_of(bench, rng, kind)
            bench.play(scene, options.seed, rows, k)
            if k % 10 == 0:
                tried, found = bench.colliding(scene, np.random.default_rng(k))
                n, n_colliding = n + tried, n_colliding + found
        for name, row in rows.items():
            common = sorted(row.lengths.keys() & rows["8 fixed"].lengths.keys())
            ours, theirs = (sum(r.lengths[k] for k in common) for r in (row, rows["8 fixed"]))
            mean = np.mean(list(row.lengths.values())) if row.lengths else np.nan
            ratio = ours / theirs if theirs else np.nan
            solved = f"{len(row.lengths)} of {options.scenes}"
            table.add_row(kind, name, solved, f"{mean:.2f}", f"{ratio:.2f}", f"{np.median(row.times):.3f}")
    Console().print(table)
    print(f"poses of truncated envelopes: {n}, of which {n_colliding} collide")


if __name__ == "__main__":
    main()
