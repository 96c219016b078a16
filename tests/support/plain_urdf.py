"""Forward kinematics and meshes of a URDF, read without any of the product's code."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pickcli.geometry import Array

PACKAGE = "package://example-robot-data/robots/"


@dataclass(frozen=True, eq=False)
class PlainUrdf:
    """A URDF as a tree of XML.

    Attributes:
        root: Its root element.
        folder: Where the meshes of ``package://example-robot-data/robots/`` lie.
    """

    root: ET.Element
    folder: Path

    @classmethod
    def read(cls, path: Path, folder: Path) -> PlainUrdf:
        return cls(ET.parse(path).getroot(), folder)

    def pose(self, link: str, positions: Mapping[str, float]) -> Array:
        """(4, 4) pose of a link in the root link; joints that are not named stand at 0."""
        for joint in self.root.iter("joint"):
            if (child := joint.find("child")) is not None and child.get("link") == link:
                parent = joint.find("parent")
                assert parent is not None
                here = self.pose(str(parent.get("link")), positions)
                return np.asarray(here @ _origin(joint) @ _motion(joint, self._position(joint, positions)))
        return np.eye(4)

    def mesh(self, link: str, kind: str) -> tuple[Path, Array]:
        """The file of a link's mesh, and its pose (4, 4) in the link. The kind is "visual" or "collision"."""
        element = self.root.find(f"link[@name='{link}']/{kind}")
        assert element is not None
        mesh = element.find("geometry/mesh")
        assert mesh is not None
        return self.folder / str(mesh.get("filename")).removeprefix(PACKAGE), _origin(element)

    @staticmethod
    def _position(joint: ET.Element, positions: Mapping[str, float]) -> float:
        mimic = joint.find("mimic")
        if mimic is None:
            return positions.get(str(joint.get("name")), 0.0)
        factor = float(mimic.get("multiplier", "1"))
        return factor * positions.get(str(mimic.get("joint")), 0.0) + float(mimic.get("offset", "0"))


def _origin(element: ET.Element) -> Array:
    origin, T = element.find("origin"), np.eye(4)
    if origin is not None:
        T[:3, :3] = Rotation.from_euler("xyz", _numbers(origin, "rpy")).as_matrix()
        T[:3, 3] = _numbers(origin, "xyz")
    return T


def _motion(joint: ET.Element, position: float) -> Array:
    T, axis = np.eye(4), joint.find("axis")
    if axis is None or joint.get("type") == "fixed":
        return T
    direction = position * np.array(_numbers(axis, "xyz"))
    if joint.get("type") == "prismatic":
        T[:3, 3] = direction
    else:
        T[:3, :3] = Rotation.from_rotvec(direction).as_matrix()
    return T


def _numbers(element: ET.Element, attribute: str) -> list[float]:
    return [float(part) for part in element.get(attribute, "0 0 0").split()]
