"""What the parts of a cell say of each other: robot, tool, shelf and obstacles, one mistake at a time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pickcli.cell.cell_file import load_cell
from pickcli.cell.inertial import box_inertia
from pickcli.cell.robots.urdf import Urdf, read_urdf
from pickcli.errors import InputError
from pickcli.geometry import Array
from support.other_robots import URDF, write_robot

Refused = Callable[[Callable[[], object]], str]
Change = tuple[str, str, str]  # file, a text in it, what stands there instead


def changed(folder: Path, *changes: Change, **robot: Any) -> Path:
    """A cell of the branching robot with texts and figures of its robot changed."""
    path = write_robot(folder)
    content = yaml.safe_load((path / "cell.yaml").read_text())
    content["robot"].update(robot)
    (path / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    for name, old, new in changes:
        text = (path / name).read_text()
        assert old in text
        (path / name).write_text(text.replace(old, new))
    return path


CUP_END = "</link>\n<joint"
FINGER = '</link>\n<link name="finger"/><joint name="f" type="fixed"><parent link="cup"/>'
FINGER += '<child link="finger"/></joint>\n<joint'


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ([("tool.urdf", '"mount"', '"camera"'), ("cell.yaml", "lance_link: mount", "lance_link: camera")],
         "tool.urdf: link 'camera' is one of the robot's too; rename one"),
        ([("tool.urdf", "cup_joint", "bend")],
         "tool.urdf: joint 'bend' is one of the robot's too; rename one"),
        ([("tool.urdf", CUP_END, FINGER)], "tool.cup_link: 'finger' hangs on it; the cup is the last link"),
        ([("cell.yaml", "name: stand", "name: upper")],
         "obstacles[0].name: 'upper' is a link of the robot too; rename the obstacle"),
        ([("cell.yaml", "name: stand", "name: tote_floor")],
         "obstacles[0].name: 'tote_floor' is a part of the pod or the tote too; rename the obstacle"),
        ([("robot.urdf", '"camera"', '"tote_floor"'), ("robot.srdf", '"camera"', '"tote_floor"')],
         "robot.urdf: link 'tote_floor' has the name of a part of the pod or the tote; rename it"),
        ([("robot.urdf", 'joint="open"', 'joint="bend"')],
         "robot.joints: 'bend': 'follow' mimics it, which cannot be planned; let it stand (robot.posture)"),
    ],
)  # fmt: skip
def test_a_name_means_one_thing_and_what_is_planned_moves_alone(
    tmp_path: Path, refused: Refused, changes: list[Change], problem: str
) -> None:
    assert problem in refused(lambda: load_cell(changed(tmp_path, *changes)))


@pytest.mark.parametrize(
    ("robot", "problem"),
    [
        ({"tip": "hand"}, "robot.tip: is of an arm without a tool, here the chain ends with the tool"),
        ({"posture": {"pan": -1.0, "open": 0.04}}, ""),
        ({"posture": {"pan": -1.0001, "open": 0.02}}, "robot.posture.pan: expected -1 to 1, got -1.0001"),
        (
            {"posture": {"pan": 1.0, "open": 0.0401}},
            "robot.posture.open: expected 0 to 0.04, got 0.0401; positions are in m",
        ),
        ({"unshaped": ["dummy"]}, ""),
        ({"unshaped": ["dommy"]}, "robot.unshaped[0]: no link is named 'dommy'; did you mean 'dummy'?"),
        ({"joints": ["turn", "flange_joint", "bend"]}, "robot.joints: expected the chain's moving joints"),
    ],
)
def test_figures_of_the_robot_fit_its_urdf(
    tmp_path: Path, refused: Refused, robot: dict[str, Any], problem: str
) -> None:
    def load() -> object:
        return load_cell(changed(tmp_path, **robot))

    assert problem in refused(load) if problem else load()


def test_what_a_planned_joint_moves_has_a_shape_or_is_named_as_having_none(
    tmp_path: Path, refused: Refused
) -> None:
    """The tool's own shapes are what the last joint moves; without them nothing is tested there."""
    path = write_robot(tmp_path)
    tool = (path / "tool.urdf").read_text().splitlines()
    bare = [line.split("<collision>")[0] + "</link>" if "<collision>" in line else line for line in tool]
    (path / "tool.urdf").write_text("\n".join(bare))
    problem = "nothing that 'flange_joint' moves has a collision shape (flange, mount, cup)"
    assert problem in refused(lambda: load_cell(path))
    content = yaml.safe_load((path / "cell.yaml").read_text())
    for name, is_named in (("camera", False), ("mount", True)):
        content["robot"]["unshaped"] = [name]
        (path / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
        if is_named:
            assert load_cell(path).robot.links[-1].bodies == ()
        else:
            assert problem in refused(lambda: load_cell(path))


def branching(folder: Path, old: str = "", new: str = "") -> Urdf:
    """The branching robot with a text of its URDF changed."""
    path = folder / "robot.urdf"
    assert old in URDF
    path.write_text(URDF.replace(old, new, 1))
    (folder / "maker").mkdir(exist_ok=True)
    return read_urdf(path, packages={"maker": meshes(folder)})


CORNERS = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])


def meshes(folder: Path) -> Path:
    """The package of the robot's meshes, of which each is one tetrahedron."""
    where = folder / "maker" / "meshes"
    where.mkdir(parents=True, exist_ok=True)
    lines = ["v {} {} {}".format(*corner) for corner in CORNERS] + [
        "f 1 3 2",
        "f 1 2 4",
        "f 1 4 3",
        "f 2 3 4",
    ]
    for name in ("column.obj", "arm.obj"):
        (where / name).write_text("\n".join(lines) + "\n")
    return folder / "maker"


def corners_of(robot: Urdf, link: str) -> Array:
    """Corners of the only shape of a link, in the link, sorted."""
    (body,) = robot.links[link].bodies
    points = np.array(body.shape.vertices) @ body.T_parent_shape[:3, :3].T + body.T_parent_shape[:3, 3]
    return np.array(sorted(points.round(9).tolist()))


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 3.0, 0.5), (-1.0, 1.0, 2.0)])
def test_a_mesh_is_scaled_along_its_axes_and_stands_at_its_origin(
    tmp_path: Path, scale: tuple[float, float, float]
) -> None:
    mesh = 'filename="package://maker/meshes/column.obj"'
    told = f'{mesh} scale="{scale[0]} {scale[1]} {scale[2]}"'
    robot = branching(tmp_path, f"<geometry><mesh {mesh}/>", f'<origin xyz="1 2 3"/><geometry><mesh {told}/>')
    expected = np.array(sorted((CORNERS * scale + (1.0, 2.0, 3.0)).round(9).tolist()))
    np.testing.assert_allclose(corners_of(robot, "column"), expected, atol=1e-9)


def test_a_mesh_without_a_scale_is_as_large_as_its_file_says(tmp_path: Path) -> None:
    expected = np.array(sorted(CORNERS.tolist()))
    np.testing.assert_allclose(corners_of(branching(tmp_path), "column"), expected, atol=1e-9)


@pytest.mark.parametrize("scale", ["0 1 1", "1 0 1", "1 1 0", "0 0 0"])
def test_no_factor_of_a_scale_is_nothing(tmp_path: Path, refused: Refused, scale: str) -> None:
    mesh = 'filename="package://maker/meshes/column.obj"'
    with pytest.raises(InputError, match="expected factors other than 0 as scale, got "):
        branching(tmp_path, mesh, f'{mesh} scale="{scale}"')


def test_a_joint_follows_another_by_a_factor_and_an_offset(tmp_path: Path) -> None:
    stated = ' multiplier="-1" offset="-0.001"'
    for said, multiplier, offset in (
        (stated, -1.0, -0.001), ("", 1.0, 0.0), (' multiplier="2.5"', 2.5, 0.0), (' offset="0.3"', 1.0, 0.3),
    ):  # fmt: skip
        robot = branching(tmp_path, stated, said)
        assert list(robot.mimics) == ["follow"]
        mimic = robot.mimics["follow"]
        assert (mimic.joint, mimic.multiplier, mimic.offset) == ("open", multiplier, offset)


def test_what_a_fixed_joint_mimics_means_nothing_and_who_leads_follows_nobody(
    tmp_path: Path, refused: Refused
) -> None:
    fixed = '<joint name="dummy_joint" type="fixed">'
    assert list(branching(tmp_path, fixed, fixed + '<mimic joint="follow"/>').mimics) == ["follow"]
    pan = '<joint name="pan" type="revolute">'
    message = refused(lambda: branching(tmp_path, pan, pan + '<mimic joint="follow"/>'))
    assert "'follow' mimics a joint itself; name the one that leads" in message


def test_the_weight_of_a_link_is_where_its_file_says(tmp_path: Path) -> None:
    weight = '<inertial><origin xyz="0.1 0.2 0.3" rpy="0.4 0 0"/><mass value="2.5"/></inertial>'
    robot = branching(tmp_path, '<inertial><mass value="0"/></inertial>', weight)
    lower, upper = robot.links["lower"], robot.links["upper"]
    assert lower.states_mass and lower.inertial.mass == 2.5
    np.testing.assert_array_equal(lower.inertial.centre, (0.1, 0.2, 0.3))
    assert not upper.states_mass and upper.inertial.mass > 0.0
    np.testing.assert_array_equal(upper.inertial.centre, np.zeros(3))


def test_the_inertia_of_a_link_is_that_of_its_file_turned_into_the_link(tmp_path: Path) -> None:
    moments = '<inertia ixx="1" ixy="0.1" ixz="0" iyy="2" iyz="0.2" izz="2.5"/>'
    weight = f'<inertial><origin rpy="0 0 {np.pi / 2}"/><mass value="2.5"/>{moments}</inertial>'
    robot = branching(tmp_path, '<inertial><mass value="0"/></inertial>', weight)
    found = robot.links["lower"].inertial.inertia
    np.testing.assert_allclose(found, [[2.0, -0.1, -0.2], [-0.1, 1.0, 0.0], [-0.2, 0.0, 2.5]], atol=1e-12)


@pytest.mark.parametrize("moments", ["", 'ixx="0" iyy="0" izz="0"', 'ixx="1" iyy="1" izz="9"'])
def test_an_inertia_that_no_body_has_is_that_of_a_box(tmp_path: Path, moments: str) -> None:
    weight = f'<inertial><mass value="2.5"/><inertia {moments}/></inertial>'
    link = branching(tmp_path, '<inertial><mass value="0"/></inertial>', weight).links["lower"]
    np.testing.assert_array_equal(link.inertial.inertia, box_inertia(2.5, link.bodies))


def test_what_hangs_on_what_and_what_moves_by_itself(tmp_path: Path) -> None:
    robot = branching(tmp_path)
    assert [joint.name for joint in robot.way("left")] == [
        "world_joint",
        "turn",
        "bend",
        "hand_joint",
        "open",
    ]
    assert [joint.child for joint in robot.children("hand")] == ["left", "right", "dummy"]
    assert list(robot.driven(robot.joints.values())) == ["turn", "pan", "bend", "open", "flange_joint"]
