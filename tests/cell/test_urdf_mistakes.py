"""A URDF that cannot be meant is refused with the line of the element that is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.robots.urdf import read_urdf
from pickcli.errors import InputError
from pickcli.geometry import pose

Refused = Callable[[Callable[[], object]], str]

GOOD = """<robot name="two">
<link name="base"/>
<link name="arm">
<inertial><mass value="2"/></inertial>
<collision><geometry><box size="1 2 3"/></geometry></collision>
</link>
<link name="hand"/>
<joint name="turn" type="revolute">
<parent link="base"/><child link="arm"/>
<origin xyz="0 0 1" rpy="0 0 0"/><axis xyz="0 0 2"/>
<limit lower="-1" upper="1"/>
</joint>
<joint name="slide" type="prismatic">
<parent link="arm"/><child link="hand"/>
<axis xyz="1 0 0"/>
<limit lower="0" upper="0.5"/>
</joint>
</robot>
"""
THIRD = '<joint name="third" type="fixed"><parent link="{}"/><child link="{}"/></joint>\n</robot>'

MISTAKES = {
    "limits in degrees": (
        'lower="-1" upper="1"',
        'lower="-180" upper="180"',
        11,
        "limits are in rad, not degrees",
    ),
    "limits in mm": ('upper="0.5"', 'upper="500"', 16, "limits are in m, not mm"),
    "sizes in mm": ('<box size="1 2 3"/>', '<box size="100 200 300"/>', 5, "lengths are in m, not mm"),
    "sizes that nothing has": (
        '<box size="1 2 3"/>',
        '<box size="1 2 1e308"/>',
        5,
        "lengths are in m, not mm",
    ),
    "limits that meet": (
        'lower="-1" upper="1"',
        'lower="1" upper="1"',
        11,
        "lower under upper, got 1 for both; a joint that stands is fixed",
    ),
    "mass in no unit": ('value="2"', 'value="1e5"', 4, "at most 10000 kg"),
    "not XML": ('<link name="base"/>', '<link name="base">', 18, "not XML"),
    "entity bomb": ('<robot name="two">', '<!DOCTYPE r [<!ENTITY a "b">]><robot name="two">', 1, "DOCTYPE"),
    "another root element": ('<robot name="two">', '<robots name="two">', 1, None),
    "no name": ('<link name="base"/>', "<link/>", 2, "'name' is missing"),
    "same name twice": ('<link name="hand"/>', '<link name="arm"/>', 7, "stands in line 3 too"),
    "no axis": ('<axis xyz="1 0 0"/>', "", 13, "has no <axis>"),
    "zero axis": ('xyz="0 0 2"', 'xyz="0 0 0"', 10, "no direction"),
    "axis without end": ('xyz="0 0 2"', 'xyz="0 0 1e308"', 10, "no direction"),
    "no limit": ('<limit lower="-1" upper="1"/>', "", 8, "has no <limit>"),
    "no lower": ('lower="-1" ', "", 11, "'lower' is missing"),
    "limits swapped": ('lower="-1" upper="1"', 'lower="1" upper="-1"', 11, "lower under upper, got 1 and -1"),
    "not a number": ('upper="0.5"', 'upper="half"', 16, "expected 1 finite number, got 'half'"),
    "not finite": ('upper="0.5"', 'upper="inf"', 16, "finite"),
    "two numbers": ('xyz="0 0 1"', 'xyz="0 0"', 10, "expected 3 finite numbers"),
    "mimic of nothing": (
        '<limit lower="0" upper="0.5"/>',
        '<limit lower="0" upper="0.5"/><mimic joint="torn"/>',
        16,
        "no joint is named 'torn'",
    ),
    "mimic of itself": (
        '<limit lower="0" upper="0.5"/>',
        '<limit lower="0" upper="0.5"/><mimic joint="slide"/>',
        16,
        "'slide' mimics a joint itself",
    ),
    "planar joint": ('type="prismatic"', 'type="planar"', 13, "got 'planar'"),
    "unknown link": ('<child link="hand"/>', '<child link="hond"/>', 14, "no link is named 'hond'"),
    "second root": ("</robot>", '<link name="stray"/></robot>', 18, "second root beside 'base'"),
    "second parent": ("</robot>", THIRD.format("hand", "arm"), 18, "second parent"),
    "loop": ("</robot>", THIRD.format("hand", "base"), 1, "form a loop"),
    "stray loop": (
        "</robot>",
        '<link name="x"/><link name="y"/>'
        '<joint name="a" type="fixed"><parent link="x"/><child link="y"/></joint>'
        '<joint name="b" type="fixed"><parent link="y"/><child link="x"/></joint></robot>',
        18,
        "part of a loop",
    ),
    "mesh elsewhere": (
        '<box size="1 2 3"/>',
        '<mesh filename="../../etc/passwd"/>',
        5,
        "lies outside of the cell's folder",
    ),
    "unknown package": (
        '<box size="1 2 3"/>',
        '<mesh filename="package://arm/arm.stl"/>',
        5,
        "state its folder as robot.packages.arm",
    ),
    "no such mesh": ('<box size="1 2 3"/>', '<mesh filename="arm.stl"/>', 5, "no such file"),
    "unknown shape": ('<box size="1 2 3"/>', '<capsule radius="1"/>', 5, "cylinder, sphere or mesh"),
    "flat box": ('size="1 2 3"', 'size="1 2 0"', 5, "over 0 m"),
    "two shapes": ('<box size="1 2 3"/>', '<box size="1 2 3"/><sphere radius="1"/>', 5, "exactly one shape"),
    "negative weight": ('value="2"', 'value="-2"', 4, "0 kg or more, got -2"),
    "deep nesting": ("</robot>", "<a>" * 80 + "</a>" * 80 + "</robot>", 18, "nested deeper"),
}


def write(folder: Path, text: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(text)
    return path


def test_the_good_one_is_read(tmp_path: Path) -> None:
    robot = read_urdf(write(tmp_path, GOOD))
    turn, slide = robot.way("hand")
    assert (robot.root, list(robot.links)) == ("base", ["base", "arm", "hand"])
    assert (turn.name, slide.name) == ("turn", "slide")
    assert turn.axis.tolist() == [0, 0, 1]
    assert turn.T_parent_joint[2, 3] == 1
    assert (slide.lower, slide.upper) == (0, 0.5)
    assert robot.links["arm"].bodies[0].shape.size == (1, 2, 3)
    assert robot.links["arm"].inertial.mass == 2


def test_the_order_of_elements_means_nothing(tmp_path: Path) -> None:
    head, first, second = GOOD.partition('<joint name="turn"')[0], *_joints(GOOD)
    shuffled = head.replace("\n<link", f"\n{second}<link", 1) + first + "</robot>"
    assert [j.name for j in read_urdf(write(tmp_path, shuffled)).way("hand")] == ["turn", "slide"]


def _joints(text: str) -> list[str]:
    body = text[text.index("<joint") : text.index("</robot>")]
    return [part + "</joint>\n" for part in body.split("</joint>\n") if part]


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_its_line(tmp_path: Path, refused: Refused, name: str) -> None:
    old, new, line, what = MISTAKES[name]
    assert GOOD.count(old) == 1
    text = GOOD.replace(old, new)
    if name == "another root element":
        text, what = text.replace("</robot>", "</robots>"), "expected <robot>"
    message = refused(lambda: read_urdf(write(tmp_path, text)))
    assert f"robot.urdf:{line}:" in message
    assert what is not None
    assert what in message


@given(st.integers(0, len(GOOD) - 1), st.sampled_from(["", "<", ">", '"', "0", "x", "&"]))
def test_a_damaged_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, at: int, put: str
) -> None:
    folder = tmp_path_factory.getbasetemp()
    try:
        read_urdf(write(folder, GOOD[:at] + put + GOOD[at + 1 :]))
    except InputError as error:
        assert "robot.urdf" in str(error)


def test_what_the_format_leaves_out_means_nothing(tmp_path: Path) -> None:
    """No weight, no offset, no turn; the figures of a fixed and of an endless joint."""
    text = GOOD.replace('xyz="0 0 1" rpy="0 0 0"', 'rpy="0.1 0 0"').replace(
        "<collision><geometry>", '<collision><origin xyz="1 2 3"/><geometry>'
    )
    text = text.replace('type="prismatic"', 'type="continuous"')
    text = text.replace("</robot>", '<link name="tip"/>' + THIRD.format("hand", "tip"))
    robot = read_urdf(write(tmp_path, text))
    turn, endless, fixed = robot.way("tip")
    assert [link.states_mass for link in robot.links.values()] == [False, True, False, False]
    np.testing.assert_array_equal(turn.T_parent_joint, pose(rpy=(0.1, 0.0, 0.0)))
    np.testing.assert_array_equal(endless.T_parent_joint, np.eye(4))
    np.testing.assert_array_equal(robot.links["arm"].bodies[0].T_parent_shape, pose((1.0, 2.0, 3.0)))
    assert (endless.lower, endless.upper) == (-np.inf, np.inf)
    assert (fixed.lower, fixed.upper) == (0.0, 0.0)
    assert fixed.axis.tolist() == [0.0, 0.0, 1.0]
    assert robot.name == "two" and robot.links["arm"].bodies[0].name == "arm_0"


def test_all_mistakes_are_told_at_once_in_the_order_of_the_file(tmp_path: Path, refused: Refused) -> None:
    text = GOOD.replace('value="2"', 'value="-2"').replace('xyz="0 0 2"', 'xyz="0 0 0"')
    text = text.replace('size="1 2 3"', 'size="1 2"').replace('upper="0.5"', 'upper="half"')
    lines = refused(lambda: read_urdf(write(tmp_path, text))).splitlines()
    assert [int(line.split(":")[1]) for line in lines] == [4, 5, 10, 16]


def test_a_drawn_link_without_a_collision_shape_is_noted(tmp_path: Path) -> None:
    drawn = '<link name="hand"><visual><geometry><sphere radius="1"/></geometry></visual></link>'
    assert read_urdf(write(tmp_path, GOOD.replace('<link name="hand"/>', drawn))).unshaped == {"hand": 7}


def test_shapes_are_told_by_name_or_else_by_number(tmp_path: Path) -> None:
    solid = '<collision><geometry><box size="1 2 3"/></geometry></collision>'
    more = (
        '<collision name="can"><geometry><cylinder radius="0.1" length="0.4"/></geometry></collision>'
        '<collision><geometry><sphere radius="0.2"/></geometry></collision>'
    )
    shapes = read_urdf(write(tmp_path, GOOD.replace(solid, solid + more))).links["arm"].bodies
    assert [(s.name, s.shape.kind.value, s.shape.size) for s in shapes] == [
        ("arm_0", "box", (1.0, 2.0, 3.0)), ("can", "cylinder", (0.1, 0.4)), ("arm_2", "sphere", (0.2,)),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "taken", "refused_", "problem"),
    [
        ('size="1 2 3"', 'size="1 2 10"', 'size="1 2 10.01"', "at most 10 m"),
        ('size="1 2 3"', 'size="1e-9 2 3"', 'size="0 2 3"', "sizes over 0 m"),
        ('size="1 2 3"', 'size="1 1e-9 3"', 'size="1 -1 3"', "sizes over 0 m"),
        ('value="2"', 'value="10000"', 'value="10001"', "at most 10000 kg"),
        ('value="2"', 'value="0"', 'value="-1"', "0 kg or more"),
        ('xyz="0 0 1"', 'xyz="-10 0 10"', 'xyz="0 -10.1 1"', "expected xyz within 10 m"),
        ('rpy="0 0 0"', 'rpy="-12.6 0 12.6"', 'rpy="0 12.7 0"', "expected rpy within 12.6 rad"),
        ('lower="-1" upper="1"', 'lower="-12.6" upper="1"', 'lower="-12.7" upper="1"', "within 12.6 of 0"),
        ('lower="-1" upper="1"', 'lower="-1" upper="12.6"', 'lower="-1" upper="12.7"', "within 12.6 of 0"),
        ('lower="0" upper="0.5"', 'lower="-100" upper="100"', 'lower="-101" upper="100"', "within 100 of 0"),
        ('xyz="0 0 2"', 'xyz="0 0 1e-6"', 'xyz="0 0 0.9e-6"', "the axis has no direction"),
        ('xyz="0 0 2"', 'xyz="0 0 1e6"', 'xyz="0 0 1.1e6"', "the axis has no direction"),
    ],
)
def test_a_figure_goes_as_far_as_stated_and_no_farther(
    tmp_path: Path, refused: Refused, old: str, taken: str, refused_: str, problem: str
) -> None:
    assert GOOD.count(old) == 1
    assert read_urdf(write(tmp_path, GOOD.replace(old, taken)))
    assert problem in refused(lambda: read_urdf(write(tmp_path, GOOD.replace(old, refused_))))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('<robot name="x"></robot>', "has no <link>; add them"),
        ('<robot name="x"><link name="a"/></robot>', "has no <joint>; add them"),
        (GOOD.replace('<parent link="base"/>', '<parent link="bass"/>'), "no link is named 'bass'"),
        (GOOD.replace("<geometry>", "<geometry><sphere radius='1'/>"), "expected exactly one shape"),
        (GOOD.replace('<box size="1 2 3"/>', ""), "expected exactly one shape"),
    ],
)
def test_what_is_no_chain_is_told_as_such(tmp_path: Path, refused: Refused, text: str, problem: str) -> None:
    assert problem in refused(lambda: read_urdf(write(tmp_path, text)))
