"""What fewer spheres around a robot cost: the same queries, planned with covers of different excess.

    python -m bench.covers [--only panda] [--queries 300] [--boxes 24] [--seed 5] [--excess 7.5 12]

Robots of example-robot-data stand among random boxes. Of each query start and goal are free for the tight
cover, which is that of an arm with a tool: looser covers do not allow all of them. The covers take turns in
one process, in both orders; times are of its processor, of planning and shortening, over the queries that all
solve.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import process_time

import numpy as np
from rich.console import Console
from rich.table import Table

from bench.robots import ROBOTS, make_cell
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Body, box
from pickcli.cell.station import Obstacles
from pickcli.collision import robot_model
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.robot_setup.sphere_excess import mean_of, sphere_excess
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed

TRIES = 20_000  # samples for two free ends of a query


@dataclass
class Outcome:
    """What one cover has to show for all queries.

    Attributes:
        model: The robot with the cover.
        spheres: Their number, and m outside in the mean and at most.
        ends: Queries whose ends are free.
        lengths: rad, of the path of each query; NaN if none was found.
        times: s.
    """

    model: CollisionModel
    spheres: tuple[int, float, float]
    ends: int = 0
    lengths: list[float] = field(default_factory=list)
    times: list[float] = field(default_factory=list)


def outcome(cell: Cell, excess: float | None) -> Outcome:
    """Cover a robot without a tool.

    Args:
        cell: Its cell.
        excess: m by which spheres of boxes and cylinders stick out; None for those of an arm with a tool.

    Returns:
        The cover, without queries so far.
    """
    bare = robot_model._bare_excess

    def stated(body: Body) -> float:
        return robot_model._excess(body) if excess is None else excess

    robot_model._bare_excess = stated
    try:
        model = CollisionModel(cell)
        found = sphere_excess(cell, model)
        model.state(cell.robot.tool.default_state)
    finally:
        robot_model._bare_excess = bare
    most = max(each.max_excess for each in found)
    return Outcome(model, (sum(each.n_spheres for each in found), mean_of(found), most))


def scenes(cell: Cell, n: int, n_boxes: int, seed: int) -> Iterator[tuple[int, Scene]]:
    """Boxes of 4 to 40 cm around the robot, none within 15 cm of its axis, drawn again for every query."""
    base = cell.robot.T_world_base[:3, 3]
    for k in range(n):
        rng, boxes = derived_rng(seed, "boxes", k), list[Body]()
        while len(boxes) < n_boxes:
            middle = base + rng.uniform((-0.8, -0.8, -0.1), (0.8, 0.8, 1.1))
            half = rng.uniform(0.02, 0.2, 3)
            if np.hypot(*np.maximum(np.abs(middle - base) - half, 0.0)[:2]) > 0.15:
                low, high = (middle - half).tolist(), (middle + half).tolist()
                boxes.append(box(f"box_{len(boxes)}", tuple(low), tuple(high)))
        among = replace(cell, obstacles=Obstacles(tuple(boxes)))
        yield k, Scene(among, cell.T_world_pod, (), PoseNoise())


def run(cell: Cell, covers: list[Outcome], asked: argparse.Namespace) -> int:
    """Plan all queries with every cover; the number of queries that have two free ends."""
    space, state, n = JointSpace.of(cell.robot), cell.robot.tool.default_state, 0
    for k, scene in scenes(cell, asked.queries, asked.boxes, asked.seed):
        checkers = [SceneChecker(each.model, scene, state) for each in covers]
        ends = _ends(cell, checkers[0], derived_rng(asked.seed, "ends", k))
        if len(ends) < 2:
            continue
        n += 1
        turns = list(zip(covers, checkers, strict=True))
        for cover, checker in turns if k % 2 else turns[::-1]:
            cover.ends += bool(checker.are_valid(ends).all())
            began = process_time()
            path = plan(checker, space, ends[0], ends[1:], seed=derived_seed(asked.seed, "plan", k))
            if path is not None:
                path = shorten(checker, space, path, seed=derived_seed(asked.seed, "shorten", k))
            cover.times.append(process_time() - began)
            cover.lengths.append(np.nan if path is None else path.length)
    return n


def _ends(cell: Cell, checker: SceneChecker, rng: np.random.Generator) -> Array:
    """Two free configurations (2, n), fewer if there are hardly any."""
    Q = rng.uniform(*cell.robot.limits.window, (TRIES, cell.robot.n_joints))
    return Q[checker.are_valid(Q)][:2]


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--only", choices=ROBOTS, action="append")
    parser.add_argument("--queries", type=int, default=300)
    parser.add_argument("--boxes", type=int, default=12)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--excess", type=float, nargs="+", default=[1e3 * robot_model.BARE_EXCESS], help="mm")
    asked = parser.parse_args()
    heads = (
        "robot",
        "excess, mm",
        "spheres",
        "outside, mm",
        "queries",
        "ends free",
        "solved",
        "ms: mean",
        "median",
        "p95",
        "length",
    )
    table = Table(*heads)
    for name in asked.only or ("panda", "baxter"):
        with tempfile.TemporaryDirectory() as folder:
            cell = load_cell(make_cell(name, Path(folder))[0])
            covers = [outcome(cell, each) for each in (None, *(1e-3 * mm for mm in asked.excess))]
            n = run(cell, covers, asked)
        joint = ~np.isnan([each.lengths for each in covers]).any(axis=0)
        for said, each in zip(("tight", *map(str, asked.excess)), covers, strict=True):
            times, (count, mean, most) = 1e3 * np.array(each.times)[joint], each.spheres
            solved, length = np.isfinite(each.lengths).sum(), np.array(each.lengths)[joint].mean()
            table.add_row(
                name, said, str(count), f"{1e3 * mean:.1f} / {1e3 * most:.1f}", str(n), str(each.ends),
                str(solved), f"{times.mean():.2f}", f"{np.median(times):.2f}",
                f"{np.percentile(times, 95):.2f}", f"{length:.2f}",
            )  # fmt: skip
    Console().print(table)


if __name__ == "__main__":
    main()
