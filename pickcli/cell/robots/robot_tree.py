"""Joins several robots of a cell into one tree under a common root link."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Joint, JointType, massless_link
from pickcli.cell.robots.urdf import Urdf
from pickcli.geometry import Array

WORLD = "world"  # root link to which all robots of a cell are attached


def prefixed(robot: Urdf, prefix: str) -> Urdf:
    """Prefix the names of a robot, so that two robots of the same kind fit in one tree.

    Args:
        robot: The robot.
        prefix: Prefix of every link and joint name.

    Returns:
        The renamed robot.
    """

    def joint(old: Joint) -> Joint:
        names = {key: prefix + getattr(old, key) for key in ("name", "parent", "child")}
        return replace(old, **names)

    return Urdf(
        name=robot.name,
        root=prefix + robot.root,
        links={prefix + name: replace(link, name=prefix + name) for name, link in robot.links.items()},
        joints={prefix + child: joint(old) for child, old in robot.joints.items()},
        mimics={
            prefix + name: replace(mimic, joint=prefix + mimic.joint) for name, mimic in robot.mimics.items()
        },
        unshaped={prefix + name: line for name, line in robot.unshaped.items()},
    )


def side_by_side(name: str, robots: Mapping[str, tuple[Urdf, Array]]) -> Urdf:
    """Join several robots into one tree.

    Args:
        name: Name of the tree.
        robots: By name, each with the pose (4, 4) of its root link in the world; link and joint names must be
            unique among all.

    Returns:
        The tree; its root is a link without a shape at the world's origin.
    """
    parts = [robot for robot, _ in robots.values()]
    mounts = {
        robot.root: Joint(
            name=f"{WORLD}_{robot.root}",
            type=JointType.FIXED,
            parent=WORLD,
            child=robot.root,
            T_parent_joint=T_world_base,
            axis=np.array([0.0, 0.0, 1.0]),
            lower=0.0,
            upper=0.0,
        )
        for robot, T_world_base in robots.values()
    }
    return Urdf(
        name=name,
        root=WORLD,
        links={
            WORLD: massless_link(WORLD),
            **{n: link for r in parts for n, link in r.links.items()},
        },
        joints={**mounts, **{child: joint for r in parts for child, joint in r.joints.items()}},
        mimics={n: mimic for r in parts for n, mimic in r.mimics.items()},
        unshaped={n: line for r in parts for n, line in r.unshaped.items()},
    )
