"""``apc init --tool``: a cup at the flange, or the gripper that the URDF has, and what is left to fill in."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import FIXED
from pickcli.geometry import rotation_rpy
from support.command_line import apc, refused
from support.new_robots import write_branching, write_gripper_arm
from support.tool_frame import tip_in_flange

LIMITS = ("--max-acceleration", "5", "--max-jerk", "50", "--max-velocity", "1.5", "--motor-force", "50")
FIGURES = ("--tool-figure", "force=40", "--tool-figure", "friction=0.5", "--tool-figure", "closing_speed=0.1")


def test_a_cup_is_mounted_at_the_flange_with_figures_to_measure(tmp_path: Path) -> None:
    cell = tmp_path / "arm"
    words = ("--urdf", write_branching(tmp_path), "--tip", "flange", *LIMITS)
    made = apc("init", cell, *words, "--tool", "suction")
    assert made.code == 0 and "left to fill in" not in made.out, made.err
    assert "note:" not in made.out  # the branching robot's fingers hang before the flange
    tool = load_cell(cell).robot.tool
    assert tool.suction_cup is not None and tool.flange_link == "flange"
    np.testing.assert_allclose(tool.tip_on_lance(tool.default_state)[:3, 3], (0.0, 0.0, 0.23))
    section = (cell / "cell.yaml").read_text().partition("tool:\n")[2].partition("\n\n")[0]
    for key in ("cup_stroke", "cup_tilt", "max_pull", "max_shear", "max_moment", "seal_time"):
        assert re.search(rf"^  {key}: .*; measure yours$", section, re.M), key
    assert apc("check", cell).code == 0
    move = tmp_path / "move.json"
    planned = apc("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", move)
    assert planned.code == 0 and "certified" in planned.out, planned.err


def test_a_stated_figure_is_written_in_place_of_the_usual_one(tmp_path: Path) -> None:
    words = ("--urdf", write_branching(tmp_path), *LIMITS, "--tool", "suction")
    made = apc(
        "init", tmp_path / "arm", *words, "--tool-figure", "max_pull=12", "--tool-figure", "cup_tilt=0.05"
    )
    assert made.code == 0, made.err
    text = (tmp_path / "arm" / "cell.yaml").read_text()
    assert "max_pull: 12  # N along the axis at full vacuum; from the command line" in text
    assert load_cell(tmp_path / "arm").robot.tool.cup.tilt == 0.05


def test_a_cup_beside_fingers_is_told_of(tmp_path: Path) -> None:
    words = ("--urdf", write_gripper_arm(tmp_path), *LIMITS, "--tool", "suction")
    made = apc("init", tmp_path / "arm", *words)
    assert made.code == 0 and "note: slide_one stay beside the cup" in made.out, made.err
    without = apc("init", tmp_path / "bare", *words, "--without", "hand")
    assert without.code == 0 and "note:" not in without.out, without.err


def test_the_cup_is_drawn_by_the_figures_that_are_stated(tmp_path: Path) -> None:
    words = ("--urdf", write_branching(tmp_path), "--tip", "flange", *LIMITS, "--tool", "suction")
    figures = ("--tool-figure", "cup_length=0.05", "--tool-figure", "cup_radius=0.02")
    made = apc("init", tmp_path / "arm", *words, *figures)
    assert made.code == 0, made.err
    arm = load_cell(tmp_path / "arm")
    cup = arm.robot.link(arm.robot.tool.last_link).bodies[0].shape
    assert cup.size == (0.02, 0.05) and arm.robot.tool.suction_cup is not None
    assert tip_in_flange(arm)[2, 3] == pytest.approx(0.25)


def test_a_cup_points_along_the_last_joint_where_z_of_the_flange_does_not(tmp_path: Path) -> None:
    urdf = write_gripper_arm(tmp_path)
    turned = urdf.read_text().replace('<child link="tool0"/><origin xyz="0 0 0.03"/>',
                                      '<child link="tool0"/><origin xyz="0 0.03 0"/>')  # fmt: skip
    urdf.write_text(turned)
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--tool", "suction", "--without", "hand")
    assert made.code == 0, made.err
    arm = load_cell(tmp_path / "arm")
    np.testing.assert_allclose(tip_in_flange(arm)[:3, 2], (0.0, 1.0, 0.0), atol=1e-4)
    np.testing.assert_allclose(arm.robot.tool.lance_axis(FIXED), (0.0, 0.0, 1.0), atol=1e-9)


@pytest.mark.parametrize("out", [0.006, 0.011])
def test_a_gripper_is_read_from_the_urdf(out: float, tmp_path: Path) -> None:
    cell, urdf = tmp_path / "arm", write_gripper_arm(tmp_path, out)
    made = apc("init", cell, "--urdf", urdf, *LIMITS, "--tool", "gripper", *FIGURES)
    assert made.code == 0 and "left to fill in" not in made.out, made.err
    tool = load_cell(cell).robot.tool
    assert tool.gripper is not None and tool.joints == ("slide_one", "slide_other")
    assert (tool.flange_link, tool.lance_link) == ("tool0", "hand")
    gap = 2 * (out - 0.006)
    assert tool.gripper.gap == pytest.approx(gap)
    assert tool.range == pytest.approx((gap, gap + 0.08))
    # The fingers are flat over 80 x 20 mm, 60 mm out of a hand that lies on its side, its x out of the
    # flange. What reaches an item on a floor, and is the pad, is their end.
    assert sorted(tool.gripper.pad) == pytest.approx([0.02, 0.02], abs=0.0015)
    T = tip_in_flange(load_cell(cell))
    np.testing.assert_allclose(T[:3, 3], (0.0, 0.0, 0.13), atol=1.2e-3)
    np.testing.assert_allclose(T[:3, 2], (0.0, 0.0, 1.0), atol=1e-4)
    np.testing.assert_allclose(abs(T[:3, 1]), abs(rotation_rpy(0, -np.pi / 2, 0)[:, 2]), atol=1e-4)
    assert apc("check", cell).code == 0


def test_what_no_urdf_states_of_a_gripper_is_left_to_fill_in(tmp_path: Path) -> None:
    cell = tmp_path / "arm"
    words = ("--urdf", write_gripper_arm(tmp_path), *LIMITS, "--tool", "gripper")
    made = apc("init", cell, *words, "--json")
    assert made.code == 0, made.err
    left = json.loads(made.out)["left_to_fill_in"]
    keys = ["tool.force", "tool.friction", "tool.closing_speed", "devices.gripper.lead"]
    assert [each.partition(":")[0] for each in left] == keys
    refused(apc("check", cell), 3, *keys)
    text = (cell / "cell.yaml").read_text()
    for key, value in {"force": 40, "friction": 0.5, "closing_speed": 0.1, "lead": 0.9}.items():
        text = re.sub(rf"(?m)^( +{key}):  # fill in", rf"\1: {value}  #", text)
    (cell / "cell.yaml").write_text(text)
    assert apc("check", cell).code == 0


REVOLUTE = {"kind": "revolute"}
GRIPPER = ("--tool", "gripper")
MISTAKES = {
    "a kind that is none": (
        {}, ("--tool", "griper"), "--tool: unknown kind of tool 'griper'; did you mean 'gripper'?",
    ),
    "no fingers": (
        {}, (*GRIPPER, "--without", "hand"),
        "no finger slides in what is beyond the arm (wrist, tool0); name a URDF that has the gripper",
    ),
    "fingers that turn": (
        REVOLUTE, (*GRIPPER, "--tip", "tool0"), "there only turn slide_one, slide_other",
    ),
    "fingers that cross": (
        {"axis": "0 1 -1"}, GRIPPER, "slide_one and slide_other do not move along one line",
    ),
    "no pads": (
        {"pad": "0.001"}, GRIPPER, "nothing that is flat over 3 mm; give them a <collision>",
    ),
    "a figure of nothing": (
        {}, (*GRIPPER, "--tool-figure", "force=0"), "expected KEY=NUMBER with a number",
    ),
    "a tip in the hand's way": ({}, ("--tip", "tool0"), "hand hangs on tool0, and an arm ends with its tip"),
    "a figure that is none": ({}, (*GRIPPER, "--tool-figure", "froce=4"), "did you mean 'force'?"),
    "a figure of no tool": (
        {}, ("--tool-figure", "force=4"), "--tool-figure force: there is no tool; add --tool",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_and_nothing_is_written(mistake: str, tmp_path: Path) -> None:
    robot, words, told = MISTAKES[mistake]
    urdf = write_gripper_arm(tmp_path, **robot)  # type: ignore[arg-type]
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, *words), 3, told)
    assert not (tmp_path / "arm").exists()


def test_shapes_that_move_against_a_finger_are_told_of(tmp_path: Path) -> None:
    urdf = write_gripper_arm(tmp_path)
    tip = '<link name="tip"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    joint = '<joint name="tip_joint" type="prismatic"><parent link="one"/><child link="tip"/>'
    joint += '<axis xyz="1 0 0"/>'
    limit = '<limit lower="0" upper="0.04" effort="20" velocity="0.1"/><mimic joint="slide_one"/></joint>'
    urdf.write_text(urdf.read_text().replace("</robot>", f"{tip}{joint}{limit}</robot>"))
    told = "tip moves against one, and a finger is one rigid body"
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--tool", "gripper"), 3, told)


def test_pads_on_links_of_their_own_are_those_of_their_fingers(tmp_path: Path) -> None:
    """As Baxter has them: what slides carries a tip by a fixed joint, turned, and by way of an empty link."""
    plain, split = tmp_path / "plain", tmp_path / "split"
    urdf = write_gripper_arm(tmp_path)
    words = ("--urdf", urdf, *LIMITS, "--tool", "gripper", *FIGURES)
    assert apc("init", plain, *words).code == 0
    text = urdf.read_text()
    for name in ("one", "other"):
        whole = re.search(f'<link name="{name}">.*?</link>', text)
        assert whole is not None
        xyz, size = re.findall(r'(?:xyz|size)="(.*?)"', whole[0])
        long, wide, thick = size.split()
        pad = f'<collision><geometry><box size="{wide} {long} {thick}"/></geometry></collision>'
        root = f'<collision><origin xyz="{xyz}"/><geometry><sphere radius="0.002"/></geometry></collision>'
        links = f'<link name="{name}">{root}</link><link name="{name}_frame"/>'
        links += f'<link name="{name}_tip">{pad}</link>'
        origins = {f"{name}_frame": f'xyz="{xyz}"', f"{name}_tip": f'xyz="0 0 0" rpy="0 0 {np.pi / 2}"'}
        joints = "".join(
            f'<joint name="{child}_joint" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
            f"<origin {origin}/></joint>"
            for parent, (child, origin) in zip((name, f"{name}_frame"), origins.items(), strict=True)
        )
        text = text.replace(whole[0], links).replace("</robot>", f"{joints}</robot>")
    urdf.write_text(text)
    made = apc("init", split, *words)
    assert made.code == 0 and "left to fill in" not in made.out, made.err
    one, other = (load_cell(cell).robot.tool for cell in (plain, split))
    assert one.gripper is not None and other.gripper is not None
    assert other.gripper.pad == pytest.approx(one.gripper.pad, abs=1e-6)
    assert other.range == pytest.approx(one.range) and other.joints == one.joints
    assert apc("check", split).code == 0


def test_three_fingers_are_too_many(tmp_path: Path) -> None:
    urdf = write_gripper_arm(tmp_path)
    third = '<link name="third"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    joint = '<joint name="slide_third" type="prismatic"><parent link="hand"/><child link="third"/>'
    joint += '<axis xyz="0 1 0"/>'
    limit = '<limit lower="0" upper="0.04" effort="20" velocity="0.1"/><mimic joint="slide_one"/></joint>'
    urdf.write_text(urdf.read_text().replace("</robot>", f"{third}{joint}{limit}</robot>"))
    told = "expected two fingers in one hand, got slide_one, slide_other, slide_third in hand; leave out"
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--tool", "gripper"), 3, told)


def test_options_that_may_be_repeated_are(tmp_path: Path) -> None:
    words = (
        "--urdf",
        write_gripper_arm(tmp_path),
        "--max-jerk",
        "pan=50",
        "--max-jerk",
        "lift=40",
        "--tool",
        "suction",
    )
    made = apc("init", tmp_path / "arm", *words, "--json")
    assert made.code == 0, made.err
    assert any("max_jerk of bend:" in each for each in json.loads(made.out)["left_to_fill_in"])


def test_a_warning_names_the_folder_that_is_written(tmp_path: Path) -> None:
    steep = ("--max-acceleration", "900", "--max-jerk", "50")
    made = apc("init", tmp_path / "arm", "--urdf", write_gripper_arm(tmp_path), *steep, "--tool", "suction")
    assert made.code == 0 and made.err.count("900 rad/s2 is more than any commercial arm reaches") > 0, (
        made.err
    )
    assert f"{tmp_path / 'arm' / 'cell.yaml'}:" in made.err and "/.arm." not in made.err


def test_links_without_a_mass_are_told_once_by_the_check(tmp_path: Path) -> None:
    folder = tmp_path / "arm"
    made = apc("init", folder, "--urdf", write_gripper_arm(tmp_path), *LIMITS, "--tool", "suction")
    assert made.code == 0 and "<inertial>" not in made.err
    checked = apc("check", folder)
    assert "<inertial>" in checked.out + checked.err
    assert "<inertial>" not in apc("inspect", folder).err
