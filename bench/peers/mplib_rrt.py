"""mplib's planner: OMPL's RRTConnect with FCL, all in C++."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import mplib
import numpy as np
from mplib import Pose
from mplib.collision_detection import fcl

PACKAGES = ("mplib",)


class Peer:
    """See ``worker``."""

    def __init__(self, problem: dict[str, Any]) -> None:
        self._problem = problem
        self._folder = tempfile.TemporaryDirectory()

    def prepare(self, query: dict[str, Any], number: int) -> None:
        """Everything that does not count as planning."""
        robot, world = query["robot"], self._problem["scenes"][query["scene"]]
        urdf, srdf = (Path(self._folder.name) / name for name in ("robot.urdf", "robot.srdf"))
        urdf.write_text(robot["urdf"])
        srdf.write_text(_srdf(robot["untested"]))
        solids = [self._solid(solid) for solid in world if solid["name"] not in query["without"]]
        self._planner = mplib.Planner(str(urdf), robot["links"][-1]["name"], srdf=str(srdf), objects=solids)
        links = {link["name"] for link in robot["links"]}
        for pair in robot["allowed"]:
            link = next(name for name in pair if name in links)
            self._planner.acm.set_entry(link, next(name for name in pair if name != link), True)

    def plan(self, start: np.ndarray, goal: np.ndarray) -> np.ndarray | None:
        """The first path, or None: without the timing that plan_qpos adds."""
        self._ends = start, goal
        return self._planned(simplify=False)

    def shortened(self, path: np.ndarray) -> np.ndarray:
        """Planned once more: the library simplifies only as a part of planning."""
        again = self._planned(simplify=True)
        return path if again is None else again

    def _planned(self, simplify: bool) -> np.ndarray | None:
        start, goal = self._ends
        limit = float(self._problem["time_limit"])
        status, path = self._planner.planner.plan(start, [goal], time=limit, simplify=simplify)
        return np.asarray(path) if status == "Exact solution" else None

    def _solid(self, solid: dict[str, Any]) -> Any:
        kind, size, margin = solid["kind"], solid["size"], self._problem["margin"]
        if kind == "box":
            shape = fcl.Box([s + 2 * margin for s in size])
        elif kind == "cylinder":
            shape = fcl.Cylinder(size[0] + margin, size[1] + 2 * margin)
        else:
            shape = fcl.Sphere(size[0] + margin)
        pose = Pose(np.array(solid["T"]))
        return fcl.FCLObject(solid["name"], pose, [fcl.CollisionObject(shape)], [Pose()])


def _srdf(untested: list[list[str]]) -> str:
    lines = (f'<disable_collisions link1="{a}" link2="{b}" reason="never"/>' for a, b in untested)
    return f'<robot name="robot">{"".join(lines)}</robot>'
