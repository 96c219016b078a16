"""roboplan's RRT-Connect, with coal in C++."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from roboplan.core import (
    Box,
    Cylinder,
    JointConfiguration,
    PathShortcutter,
    PathShortcuttingOptions,
    Scene,
    Sphere,
    loadUrdfSceneDescriptionFromXml,
)
from roboplan.rrt import RRT, RRTOptions

PACKAGES = ("roboplan", "coal")

STEP = 0.05  # between the states that are tested along a motion: the library's default
MANY = 1_000_000  # nodes: the time limit alone ends the search
GREY = np.full(4, 0.5)


class Peer:
    """See ``worker``."""

    def __init__(self, problem: dict[str, Any]) -> None:
        self._problem = problem

    def prepare(self, query: dict[str, Any], number: int) -> None:
        """Everything that does not count as planning."""
        robot, names = query["robot"], self._problem["joint_names"]
        self._scene = Scene("peers", loadUrdfSceneDescriptionFromXml(robot["urdf"]))
        self._scene.addGroup("arm", names)
        self._scene.setRngSeed(number + 1)
        self._scene.setCollisions([tuple(pair) for pair in robot["untested"]], False)
        solids = {
            f"solid_{k}": solid
            for k, solid in enumerate(self._problem["scenes"][query["scene"]])
            if solid["name"] not in query["without"]
        }
        for name, solid in solids.items():
            self._add(name, solid)
        # By itself it would test the world's solids against each other.
        spared = [*combinations(solids, 2), *_allowed(robot, solids)]
        self._scene.setCollisions(spared, False)
        options = RRTOptions(
            group_name="arm", max_nodes=MANY, collision_check_step_size=STEP,
            max_planning_time=float(self._problem["time_limit"]), rrt_connect=True,
        )  # fmt: skip
        self._rrt = RRT(self._scene, options)
        self._rrt.setRngSeed(number + 1)
        shortening = PathShortcuttingOptions(group_name="arm", max_step_size=STEP, seed=number)
        self._shortcutter = PathShortcutter(self._scene, shortening)

    def plan(self, start: np.ndarray, goal: np.ndarray) -> Any:
        """The first path, or None."""
        names = self._problem["joint_names"]
        try:
            path = self._rrt.plan(JointConfiguration(names, start), JointConfiguration(names, goal))
        except RuntimeError:
            return None
        return None if path is None else _Path(path)

    def shortened(self, path: _Path) -> np.ndarray:
        """The same path by the library's own shortcutting."""
        return _Path(self._shortcutter.shortcut(path.path)).waypoints()

    def _add(self, name: str, solid: dict[str, Any]) -> None:
        kind, size, margin = solid["kind"], solid["size"], self._problem["margin"]
        T = np.asfortranarray(solid["T"])
        if kind == "box":
            self._scene.addBoxGeometry(name, "universe", Box(*(s + 2 * margin for s in size)), T, GREY)
        elif kind == "cylinder":
            cylinder = Cylinder(size[0] + margin, size[1] + 2 * margin)
            self._scene.addCylinderGeometry(name, "universe", cylinder, T, GREY)
        else:
            self._scene.addSphereGeometry(name, "universe", Sphere(size[0] + margin), T, GREY)


def _allowed(robot: dict[str, Any], solids: dict[str, Any]) -> list[tuple[str, str]]:
    """Pairs of a link and a solid that are not tested."""
    links = [link["name"] for link in robot["links"]]
    return [
        (link, name)
        for pair in robot["allowed"]
        for link in links
        if link in pair
        for name, solid in solids.items()
        if solid["name"] in pair
    ]


class _Path:
    def __init__(self, path: Any) -> None:
        self.path = path

    def waypoints(self) -> np.ndarray:
        """(N, n)."""
        return np.array(self.path.positions)
