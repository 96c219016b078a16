"""roboplan's RRT-Connect, with coal in C++."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
from roboplan.core import (
    JointConfiguration,
    PathShortcutter,
    PathShortcuttingOptions,
    Scene,
    loadUrdfSceneDescriptionFromXml,
)
from roboplan.rrt import RRT, RRTOptions

PACKAGES = ("roboplan", "coal")

STEP = 0.05  # between the states that are tested along a motion: the library's default
MANY = 1_000_000  # nodes: the time limit alone ends the search


class Peer:
    """See ``worker``."""

    def __init__(self, problem: dict[str, Any]) -> None:
        self._problem = problem

    def prepare(self, query: dict[str, Any], number: int) -> None:
        """Everything that does not count as planning."""
        robot, names = query["robot"], self._problem["joint_names"]
        solids = {
            f"solid_{k}": solid
            for k, solid in enumerate(self._problem["scenes"][query["scene"]])
            if solid["name"] not in query["without"]
        }
        urdf = _with_world(robot, solids, self._problem["margin"])
        self._scene = Scene("peers", loadUrdfSceneDescriptionFromXml(urdf))
        self._scene.addGroup("arm", names)
        self._scene.setRngSeed(number + 1)
        self._scene.setCollisions([tuple(p) for p in robot["untested"]] + _allowed(robot, solids), False)
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


def _with_world(robot: dict[str, Any], solids: dict[str, Any], margin: float) -> str:
    """The URDF with the solids of the world in it as links: added to a scene one by one they take seconds."""
    document = ElementTree.fromstring(robot["urdf"])
    for name, solid in solids.items():
        link = ElementTree.SubElement(document, "link", name=name)
        collision = ElementTree.SubElement(link, "collision")
        ElementTree.SubElement(collision, "origin", solid["origin"])
        geometry = ElementTree.SubElement(collision, "geometry")
        ElementTree.SubElement(geometry, solid["kind"], _grown(solid["kind"], solid["size"], margin))
        joint = ElementTree.SubElement(document, "joint", name=f"to_{name}", type="fixed")
        ElementTree.SubElement(joint, "parent", link=robot["links"][0]["name"])
        ElementTree.SubElement(joint, "child", link=name)
    return ElementTree.tostring(document, encoding="unicode")


def _grown(kind: str, size: list[float], margin: float) -> dict[str, str]:
    if kind == "box":
        return {"size": " ".join(repr(s + 2 * margin) for s in size)}
    radius = {"radius": repr(size[0] + margin)}
    return radius if kind == "sphere" else radius | {"length": repr(size[1] + 2 * margin)}


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
