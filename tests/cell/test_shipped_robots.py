"""The robots of the cells that ship, written from published figures, against models that others measured."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.robots.urdf import read_urdf
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import rotation_angle, transform_points
from support.mesh_surface import outside, surface_points
from support.plain_urdf import PlainUrdf

N_CONFIGURATIONS = 200
N_POINTS = 20_000
SAME_PLACE, SAME_DIRECTION = 1e-3, 1e-3  # m and rad
ROUNDING = 1.5e-4  # m by which a point may be out of a shape that was rounded to such figures


@dataclass(frozen=True)
class Other:
    """The model of a robot in the package example-robot-data.

    Attributes:
        urdf: Its file.
        root: Its link that is the root of ours.
        links: Links of which ours must be in the same place.
        meshes: By link whether its visual or its collision mesh is the real surface.
    """

    urdf: str
    root: str
    links: tuple[str, ...]
    meshes: dict[str, str]


ARM_OF_BAXTER = (
    "upper_shoulder",
    "lower_shoulder",
    "upper_elbow",
    "lower_elbow",
    "upper_forearm",
    "lower_forearm",
)
ARMS_OF_BAXTER = tuple(f"{side}_{link}" for side in ("left", "right") for link in (*ARM_OF_BAXTER, "wrist"))
FINGERS_OF_BAXTER = tuple(f"l_gripper_{side}_finger{part}" for side in "lr" for part in ("", "_tip"))
ARMS_OF_PR2 = tuple(
    f"{side}_{link}_link"
    for side in "lr"
    for link in (
        "shoulder_pan",
        "shoulder_lift",
        "upper_arm",
        "elbow_flex",
        "forearm",
        "wrist_flex",
        "gripper_palm",
    )
)
ROLLS_OF_PR2 = tuple(f"{side}_{link}_roll_link" for side in "lr" for link in ("upper_arm", "forearm"))
# By links without shapes of their own, the link that carries them.
CARRIERS = {f"l_gripper_{side}_finger_tip": f"l_gripper_{side}_finger" for side in "lr"}
CARRIERS |= {roll: roll.replace("_roll", "") for roll in ROLLS_OF_PR2}
# By links that turn about a shaft, the link that the shaft is in: its shape goes all around.
SHAFTS = {
    f"{side}_{link}{roll}_link": f"{side}_{inner}_link"
    for side in "lr"
    for link, inner in (("upper_arm", "shoulder_lift"), ("forearm", "elbow_flex"))
    for roll in ("", "_roll")
} | {f"{side}_gripper_palm_link": f"{side}_wrist_flex_link" for side in "lr"}
PANDA_LINKS = tuple(f"panda_link{k}" for k in range(8))
OTHERS = {
    "panda_table": Other(
        "panda_description/urdf/panda.urdf",
        "panda_link0",
        (*PANDA_LINKS, "panda_hand_tcp", "panda_leftfinger", "panda_rightfinger"),
        dict.fromkeys((*PANDA_LINKS, "panda_hand"), "collision") | {"panda_leftfinger": "visual"},
    ),
    "apc2016_kth": Other(
        "baxter_description/urdf/baxter.urdf",
        "torso",
        (*ARMS_OF_BAXTER, "left_hand_link", "right_hand_link", *FINGERS_OF_BAXTER, "left_gripper", "screen"),
        dict.fromkeys(
            (
                *ARMS_OF_BAXTER,
                "left_gripper_base_link",
                *FINGERS_OF_BAXTER,
                "torso",
                "pedestal",
                "head",
                "screen",
            ),
            "visual",
        ),
    ),
    "pr2_belt": Other(
        "pr2_description/urdf/pr2.urdf",
        "base_link",
        (*ARMS_OF_PR2, "l_gripper_tool_frame", "r_gripper_tool_frame", "head_tilt_link"),
        dict.fromkeys(
            ("base_link", "torso_lift_link", "head_pan_link", "head_tilt_link", *ARMS_OF_PR2, *ROLLS_OF_PR2),
            "collision",
        ),
    ),
}
CASES = [(cell, link) for cell, other in OTHERS.items() for link in other.meshes]


@cache
def theirs(cell: str) -> PlainUrdf:
    """The model of others. Skips where the development extra is not installed."""
    try:
        listed = files("example-robot-data") or []
    except PackageNotFoundError:
        pytest.skip("example-robot-data is not installed (development extra)")
    panda = next(path for path in listed if path.name == "panda.urdf")
    folder = Path(str(panda.locate())).parents[2]
    return PlainUrdf.read(folder / OTHERS[cell].urdf, folder)


@cache
def ours(cell: str) -> PlainUrdf:
    path = data_path() / "cells" / cell / "robot.urdf"
    return PlainUrdf.read(path, path.parent)


@pytest.mark.parametrize("cell", OTHERS)
def test_every_link_is_where_others_have_it(cell: str) -> None:
    path = data_path() / "cells" / cell / "robot.urdf"
    joints = read_urdf(path, path.parent, {}).joints.values()
    moving = {
        joint.name: (max(joint.lower, -np.pi), min(joint.upper, np.pi))
        for joint in joints
        if joint.upper > joint.lower
    }
    rng, other = np.random.default_rng(7), OTHERS[cell]
    for _ in range(N_CONFIGURATIONS):
        q = {name: float(rng.uniform(*bounds)) for name, bounds in moving.items()}
        T_theirs_root = theirs(cell).pose(other.root, q)
        for link in other.links:
            mine, their = ours(cell).pose(link, q), np.linalg.inv(T_theirs_root) @ theirs(cell).pose(link, q)
            assert np.linalg.norm(mine[:3, 3] - their[:3, 3]) < SAME_PLACE, link
            assert rotation_angle(mine[:3, :3].T @ their[:3, :3]) < SAME_DIRECTION, link


@pytest.mark.parametrize(("cell", "link"), CASES)
def test_the_shapes_contain_the_real_link(cell: str, link: str) -> None:
    path, T_link_mesh = theirs(cell).mesh(link, OTHERS[cell].meshes[link])
    carrier = CARRIERS.get(link, link)
    T_carrier_mesh = np.linalg.inv(theirs(cell).pose(carrier, {})) @ theirs(cell).pose(link, {}) @ T_link_mesh
    points = transform_points(T_carrier_mesh, surface_points(path, N_POINTS, np.random.default_rng(3)))
    urdf = data_path() / "cells" / cell / "robot.urdf"
    links = read_urdf(urdf, urdf.parent, {}).links
    inner = links[SHAFTS[link]].bodies if link in SHAFTS else ()
    assert outside(points, (*links[carrier].bodies, *inner)).max() < ROUNDING


@pytest.mark.parametrize("cell", OTHERS)
def test_links_shrunk_by_a_hand_would_not_contain_them(cell: str) -> None:
    """The oracle tells shapes that are too small: it is not true of anything."""
    link = next(iter(OTHERS[cell].meshes))
    path, _ = theirs(cell).mesh(link, OTHERS[cell].meshes[link])
    points = surface_points(path, N_POINTS, np.random.default_rng(3))
    urdf = data_path() / "cells" / cell / "robot.urdf"
    shapes = read_urdf(urdf, urdf.parent, {}).links[link].bodies
    assert outside(1.2 * points, shapes).max() > 0.005


@pytest.mark.parametrize("name", ["panda_table", "ur5e_crates"])
def test_the_arm_is_covered_by_few_spheres(name: str) -> None:
    cell = load_cell(name)
    covers = CollisionModel(cell).covers
    planned = {joint.child for joint in cell.robot.joints if joint.name in cell.robot.joint_names}
    assert sum(len(covers[link].radii) for link in planned) <= 120
    assert max(covers[link].excess for link in planned) <= 0.010


def test_the_robot_of_kths_picks_differs_in_the_left_tool_alone() -> None:
    def without_left_tool(cell: str) -> str:
        text = (data_path() / "cells" / cell / "robot.urdf").read_text()
        return text[text.index("<robot") : text.index('<joint name="left_gripper_base_joint"')]

    assert without_left_tool("apc2016_kth") == without_left_tool("apc2016_kth_picking")
