"""``apc init``: from a robot's files to a first proven move, and what it says when it cannot."""

from __future__ import annotations

import errno
import json
import os
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.page.cell_parts import robot_part
from pickcli.robot_setup import cell_setup, xacro_file
from support.command_line import apc, misused, refused
from support.new_robots import write_branching, write_gripper_arm, write_two_arms

LIMITS = ("--max-acceleration", "5", "--max-jerk", "50", "--max-velocity", "1.5")


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    return write_branching(tmp_path)


def test_three_commands_lead_to_a_proven_move(
    urdf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    made = apc(
        "init", "my arm", "--urdf", urdf, "--srdf", urdf.with_name("robot.srdf"), "--joint-limits",
        urdf.with_name("joint_limits.yaml"), "--accept-unshaped", "--motor-force", "50",
    )  # fmt: skip
    assert made.code == 0, made.err
    assert "(SRDF group arm)" in made.out and "left to fill in" not in made.out
    _, *move = shlex.split(made.out.splitlines()[-1].removeprefix("next: "))
    planned = apc(*move)
    assert planned.code == 0 and "certified" in planned.out, planned.err
    assert apc("verify", move[-1], "--cell", "my arm").code == 0


def test_a_cell_needs_nothing_outside_of_its_folder(urdf: Path, tmp_path: Path) -> None:
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--motor-force", "50", "--accept-unshaped")
    assert made.code == 0, made.err
    for path in sorted(urdf.parents[1].rglob("*"), reverse=True):
        path.unlink() if path.is_file() else path.rmdir()
    moved = (tmp_path / "arm").rename(tmp_path / "moved")
    cell = load_cell(moved)
    assert cell.robot.joint_names == ("turn", "bend", "flange_joint")
    assert cell.robot.tool.last_link == "flange"
    first, _ = (moved / "cell.yaml").read_text().split("\n", 1)
    assert first == "# yaml-language-server: $schema=cell.schema.json"
    assert set(json.loads((moved / "cell.schema.json").read_text())["required"]) >= {"robot", "joint_limits"}


def test_what_nobody_states_is_left_blank_and_listed(urdf: Path, tmp_path: Path) -> None:
    made = apc("init", tmp_path / "arm", "--urdf", urdf, "--max-jerk", "bend=50", "--json")
    assert made.code == 0, made.err
    left = json.loads(made.out)["left_to_fill_in"]
    for told in (
        "robot.unshaped: flange", "robot.motor_forces in N or Nm of turn, bend, flange_joint",
        "max_velocity of turn, bend, flange_joint", "max_acceleration of turn, bend, flange_joint",
        "max_jerk of turn, flange_joint:",
    ):  # fmt: skip
        assert sum(told in each for each in left) == 1, told
    path = tmp_path / "arm" / "cell.yaml"
    refused(apc("inspect", path), 3, "joint_limits.turn.max_acceleration", "robot.motor_forces.turn")
    filled = re.sub(r":  # fill in: (?:N or Nm|rad/s\d?)", ": 9.0", path.read_text())
    path.write_text(filled.replace("unshaped: []  # fill in: flange", "unshaped: [flange]"))
    assert apc("check", path).code == 0


def test_links_may_be_left_out(urdf: Path, tmp_path: Path) -> None:
    words = ("--without", "hand", *LIMITS, "--motor-force", "9", "--accept-unshaped")
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *words)
    assert made.code == 0 and "open" not in made.out.replace(str(tmp_path), ""), made.err
    assert "hand" not in {link.name for link in load_cell(tmp_path / "arm").robot.links}


def test_too_many_links_are_told(tmp_path: Path) -> None:
    box = '<link name="{0}"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
    hung = (
        '<joint name="j{0}" type="{1}"><parent link="{2}"/><child link="{0}"/><axis xyz="0 0 1"/>{3}</joint>'
    )
    limit = '<limit lower="-1" upper="1" effort="9" velocity="1"/>'
    links = ['<link name="base"/>', box.format("arm"), hung.format("arm", "revolute", "base", limit)]
    links += [box.format(f"n{k}") + hung.format(f"n{k}", "fixed", "arm", "") for k in range(70)]
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{"".join(links)}</robot>')
    told = apc("init", tmp_path / "r", "--urdf", tmp_path / "r.urdf", *LIMITS)
    refused(told, 3, "r.urdf", "71 links with shapes, 63 at most", "robot.without")


def test_the_same_seed_writes_the_same_bytes(urdf: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert apc("init", tmp_path / name / "arm", "--urdf", urdf, *LIMITS).code == 3  # no such folder
        (tmp_path / name).mkdir()
        assert apc("init", tmp_path / name / "arm", "--urdf", urdf, *LIMITS).code == 0
    one, two = (
        {path.relative_to(tmp_path / name): path.read_bytes() for path in (tmp_path / name).rglob("*.*")}
        for name in ("one", "two")
    )
    assert one and one == two


def test_a_joint_of_the_arm_that_stands_as_another_one_mimics_it_is_told_of(tmp_path: Path) -> None:
    urdf = write_gripper_arm(tmp_path)
    rod = '<link name="rod"><collision><geometry><box size="0.02 0.02 0.1"/></geometry></collision></link>'
    rod += '<joint name="along" type="revolute"><parent link="upper"/><child link="rod"/><axis xyz="0 1 0"/>'
    rod += '<origin xyz="0.1 0 0.3"/><limit lower="-3" upper="3" effort="9" velocity="2"/>{mimic}</joint>'
    rod += "</robot>"
    words = ("--urdf", urdf, *LIMITS, "--tip", "tool0", "--without", "hand")
    text = urdf.read_text()
    urdf.write_text(text.replace("</robot>", rod.format(mimic='<mimic joint="lift"/>')))
    made = apc("init", tmp_path / "mimicked", *words)
    assert made.code == 0 and "chain: pan, bend;" in made.out, made.err
    assert "note: lift moves the arm and stands all the same: joints that others mimic (along)" in made.out
    urdf.write_text(text.replace("</robot>", rod.format(mimic="")))
    made = apc("init", tmp_path / "free", *words)
    assert made.code == 0 and "mimic" not in made.out and "chain: pan, lift, bend;" in made.out, made.err


def test_of_two_arms_one_has_to_be_named(tmp_path: Path) -> None:
    urdf, cell = write_two_arms(tmp_path), tmp_path / "left"
    refused(apc("init", cell, "--urdf", urdf, *LIMITS), 3, "which arm?", "--tip", "left_tool0", "right_tool0")
    box = re.search(r"<box[^>]*/>", urdf.read_text())
    assert box is not None
    slow = urdf.with_name(
        "slow.urdf"
    )  # with a mesh that cannot be read: that takes long, so the arm is asked for first
    slow.write_text(urdf.read_text().replace(box[0], '<mesh filename="slow.stl"/>', 1))
    slow.with_name("slow.stl").write_text("no mesh")
    refused(apc("init", cell, "--urdf", slow, *LIMITS), 3, "which arm?", "--tip", "left_tool0", "right_tool0")
    made = apc("init", cell, "--urdf", urdf, "--tip", "left_tool0", *LIMITS)
    assert made.code == 0 and "fixed joints: right_shoulder at 0, right_elbow at 0" in made.out, made.err
    assert (
        apc("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", tmp_path / "m").code == 0
    )


def test_a_tip_in_the_middle_of_an_arm_is_told_of(tmp_path: Path) -> None:
    urdf = write_two_arms(tmp_path)
    made = apc("init", tmp_path / "left", "--urdf", urdf, "--tip", "left_upper", *LIMITS)
    refused(
        made, 3, "--tip left_upper: is in the middle of the arm, before left_elbow;", "left_lower, left_tool0"
    )


MISTAKES = {
    "a tip that is none": (("--tip", "flnage"), "--tip: unknown link 'flnage'; did you mean 'flange'?"),
    "a tip that nothing moves": (("--tip", "column"), "--tip column: no joint moves this link"),
    "a group without an SRDF": (("--group", "arm"), "--group arm: groups stand in an SRDF file"),
    "a link to leave out that is none": (
        ("--without", "hnad"),
        "--without: unknown link 'hnad'; did you mean 'hand'?",
    ),
    "the root left out": (("--without", "world_link"), "--without: world_link is the root, on which all"),
    "degrees": (
        ("--max-acceleration", "5000"),
        "--max-acceleration: expected at most 2000 for turn, got 5000",
    ),
    "a figure of no joint": (("--max-jerk", "bned=5"), "unknown joint 'bned'; did you mean 'bend'?"),
    "a folder of packages that is none": (
        ("--package-path", "nowhere"),
        "--package-path: nowhere is no folder; correct it",
    ),
    "a folder of a package that is none": (
        ("--package-path", "meshes=nowhere"),
        "--package-path: nowhere is no folder; correct it",
    ),
    "an argument of no xacro": (("--xacro-arg", "reach=1.5"), "--xacro-arg reach: "),
    "a file that is not there": (("--srdf", "none.srdf"), "none.srdf"),
}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--max-jerk", "fast"), "--max-jerk fast: expected a number over 0, or JOINT= and one"),
        (("--max-jerk", "-5"), "--max-jerk -5: expected a number over 0"),
        (("--max-jerk", "0,5"), "or JOINT= and one; a number has a decimal point"),
        (("--package-path", "=there"), "--package-path =there: expected NAME="),
    ],
)
def test_a_value_that_an_option_cannot_have_is_wrong_usage(
    words: tuple[str, ...], told: str, urdf: Path, tmp_path: Path
) -> None:
    misused(apc("init", tmp_path / "arm", "--urdf", urdf, *words), told)
    assert not (tmp_path / "arm").exists()


def test_a_name_that_is_none_is_told_before_meshes_are_read(urdf: Path, tmp_path: Path) -> None:
    (urdf.parents[1] / "meshes/column.obj").write_text("no mesh")
    for words in (("--max-jerk", "bned=5"), ("--tip", "flnage"), ("--without", "hnad")):
        refused(apc("init", tmp_path / "arm", "--urdf", urdf, *words), 3, f"{words[0]}: unknown")


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_and_nothing_is_written(mistake: str, urdf: Path, tmp_path: Path) -> None:
    words, told = MISTAKES[mistake]
    before = sorted(tmp_path.rglob("*"))
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *words), 3, told)
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("meshes/column.obj", "meshes/colunm.obj", "<mesh>: {maker}/meshes/colunm.obj: no such file"),
        ("package://maker/", "package://makers/", "package 'makers' was not found in the folders above"),
        ("package://maker/", "package://maker/../", "leads out of package 'maker'"),
        ('lower="-2" upper="2"', 'lower="-120" upper="120"', "limits are in rad, not degrees"),
        ('<joint name="bend" type="revolute">', '<joint name="bend" type="hinge">', "expected type"),
        ("</robot>", "", "robot.urdf"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_urdf_names_the_file_as_it_was_given(
    old: str, new: str, told: str, urdf: Path, tmp_path: Path
) -> None:
    assert old in urdf.read_text()
    urdf.write_text(urdf.read_text().replace(old, new))
    told = told.format(maker=urdf.parents[1])
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS), 3, urdf, told)
    assert not (tmp_path / "arm").exists()


def test_an_srdf_of_another_robot_is_none(urdf: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.srdf"
    other.write_text('<robot name="x"><group name="arm"><joint name="j1"/></group></robot>')
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, "--srdf", other), 3, other, "SRDF of another one?")
    other.write_text(
        '<robot name="x"><group name="g"><joint name="pan"/><joint name="bend"/></group></robot>'
    )
    words = ("init", tmp_path / "arm", "--urdf", urdf, "--srdf", other)
    refused(apc(*words, "--group", "g"), 3, "its joints are no single chain (pan and bend)")
    refused(apc(*words, "--group", "h"), 3, "unknown group 'h'")


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ("  bend:", "  bned:", 2, "joint_limits.bned: no joint is named 'bned'; did you mean 'bend'?"),
        ("max_jerk:", "max_jrek:", 7, "joint_limits.bend.max_jrek: unknown key; did you mean 'max_jerk'?"),
        ("has_acceleration_limits: true", "", 6, "add has_acceleration_limits: true"),
        ("has_jerk_limits: true", "has_jerk_limits: 1", 4, "expected true or false"),
        ("max_velocity: 1.5", "", 5, "is true without max_velocity"),
        ("max_velocity: 1.5", "max_velocity: -5", 8, "greater than 0, got -5"),
        ("max_velocity: 1.5", "max_velocity: 180", 8, "expected at most 60, got 180; limits are in rad"),
        ("max_velocity: 1.5", "has_position_limits: true\n    max_position: 9\n    max_velocity: 1.5", 9,
         ".max_position: expected positions inside the URDF's"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_file_of_limits_is_told_where_it_stands(
    old: str, new: str, line: int, told: str, urdf: Path, tmp_path: Path
) -> None:
    limits = urdf.with_name("joint_limits.yaml")
    assert old in limits.read_text()
    limits.write_text(limits.read_text().replace(old, new, 1))  # of bend, which comes first
    words = ("--joint-limits", limits, "--accept-unshaped", "--motor-force", "50", *LIMITS)
    answer = apc("init", tmp_path / "arm", "--urdf", urdf, *words)
    refused(answer, 3, f"{limits}:{line}:", told)
    assert "cell.yaml" not in answer.err
    assert not (tmp_path / "arm").exists()


def test_a_file_of_limits_may_know_more_joints_than_are_planned(urdf: Path, tmp_path: Path) -> None:
    limits = urdf.with_name("joint_limits.yaml")
    limits.write_text(limits.read_text() + "  pan: {has_velocity_limits: true, max_velocity: 1}\n")
    words = ("--joint-limits", limits, "--accept-unshaped", "--motor-force", "50")
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *words)
    assert made.code == 0 and apc("check", tmp_path / "arm").code == 0, made.err


@pytest.mark.parametrize("name", ["no", "null", "true", "None", "1", "1e3", "a: b"])
def test_a_name_that_yaml_reads_otherwise_is_quoted(name: str, urdf: Path, tmp_path: Path) -> None:
    urdf.write_text(urdf.read_text().replace('"bend"', f'"{name}"'))
    words = ("--urdf", urdf, *LIMITS, "--motor-force", "50", "--accept-unshaped")
    made = apc("init", tmp_path / "no", *words)
    assert made.code == 0, made.err
    assert load_cell(tmp_path / "no").robot.joint_names[1] == name


def test_a_name_that_no_cell_takes_is_told_of_the_urdf(urdf: Path, tmp_path: Path) -> None:
    urdf.write_text(urdf.read_text().replace('"bend"', f'"{5000 * "n"}"'))
    refused(apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS), 3, urdf, "has 5000 characters")


def test_a_group_of_a_gripper_is_no_arm(urdf: Path, tmp_path: Path) -> None:
    srdf = urdf.with_name("robot.srdf")
    group = '<group name="fingers"><joint name="open"/></group></robot>'
    srdf.write_text(srdf.read_text().replace("</robot>", group))
    words = ("init", tmp_path / "arm", "--urdf", urdf, "--srdf", srdf, "--group", "fingers")
    refused(apc(*words), 3, "--group fingers: is a gripper's, open; name an arm's, there are: arm (")


def test_nothing_is_written_over(urdf: Path, tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    refused(apc("init", tmp_path / "arm", "--urdf", urdf), 3, "arm: exists already")


def test_meshes_may_be_named_by_paths_that_lead_out_of_the_folder(urdf: Path, tmp_path: Path) -> None:
    text = urdf.read_text().replace("package://maker/meshes/column.obj", "../meshes/column.obj")
    far = urdf.parents[1] / "meshes" / "arm.obj"
    urdf.write_text(text.replace("package://maker/meshes/arm.obj", f"file://{far}"))
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--motor-force", "9", "--accept-unshaped")
    assert made.code == 0, made.err
    assert sorted(p.name for p in (tmp_path / "arm" / "meshes").iterdir()) == ["arm.obj", "column.obj"]
    assert load_cell(tmp_path / "arm").robot.link("upper").bodies


def test_meshes_of_visuals_are_copied_where_they_are(urdf: Path, tmp_path: Path) -> None:
    maker = urdf.parents[1]
    (maker / "looks.obj").write_text((maker / "meshes" / "column.obj").read_text())
    visual = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    text = urdf.read_text()
    for link, name in (("column", f"file://{maker}/looks.obj"), ("upper", "package://nobody/arm.dae")):
        text = text.replace(f'<link name="{link}">', f'<link name="{link}">{visual.format(name)}')
    urdf.write_text(text)
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--motor-force", "9", "--accept-unshaped")
    assert made.code == 0, made.err
    assert [p.name for p in (tmp_path / "arm" / "meshes").iterdir()] == ["looks.obj"]
    assert "nobody" not in (tmp_path / "arm" / "cell.yaml").read_text()
    links = {link.name: link.bodies for link in robot_part(load_cell(tmp_path / "arm")).links}
    assert [body.shape.is_smooth for body in links["column"]] == [True]


def test_a_xacro_is_expanded(urdf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    xacro = urdf.with_suffix(".urdf.xacro")
    body = urdf.read_text().removeprefix('<robot name="branching">')
    start = '<robot name="branching" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    start += '<xacro:arg name="reach" default="2"/>'
    xacro.write_text(
        start + body.replace('lower="-2" upper="2"', 'lower="-$(arg reach)" upper="$(arg reach)"')
    )
    words = ("--urdf", xacro, "--xacro-arg", "reach:=1.5", *LIMITS, "--motor-force", "9", "--accept-unshaped")
    made = apc("init", tmp_path / "arm", *words)
    assert made.code == 0, made.err
    assert load_cell(tmp_path / "arm").robot.limits.upper[1] == 1.5
    xacro.write_text(xacro.read_text().replace("$(arg reach)", "$(find nowhere)"))
    refused(apc("init", tmp_path / "other", *words), 3, xacro, "package 'nowhere' was not found")
    monkeypatch.setitem(__import__("sys").modules, "xacro", None)
    refused(apc("init", tmp_path / "other", *words), 3, xacro, "pip install 'apc-pick[xacro]'")


@pytest.mark.parametrize("expression", ["9**9**9", "len([0 for _ in range(10**12)])", "len('a' * 10**11)"])
def test_a_xacro_that_computes_without_end_is_refused(
    expression: str, urdf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xacro_file, "MOST_WAIT", 4.0)
    xacro = urdf.with_suffix(".urdf.xacro")
    start = '<robot name="branching" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    hostile = f'{start}<xacro:property name="a" value="${{{expression}}}"/><link name="${{a}}"/>'
    xacro.write_text(re.sub(r"<robot[^>]*>", hostile, urdf.read_text()))
    refused(apc("init", tmp_path / "other", "--urdf", xacro, *LIMITS), 3, xacro, "xacro refuses it")


def test_a_link_that_leads_nowhere_is_left_alone(urdf: Path, tmp_path: Path) -> None:
    link = tmp_path / "arm"
    link.symlink_to(tmp_path / "nothing")
    refused(apc("init", link, "--urdf", urdf), 3, f"{link}: exists already")
    assert link.is_symlink() and not link.exists()


def test_a_disk_that_is_full_leaves_nothing(
    urdf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> Any:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    before = sorted(tmp_path.iterdir())
    monkeypatch.setattr(cell_setup, "_make", full)
    answer = apc("init", tmp_path / "arm", "--urdf", urdf)
    refused(answer, 3, f"{tmp_path / 'arm'}: cannot be made: No space left on device; nothing was left")
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_that_another_command_made_meanwhile_is_kept(
    urdf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, folder = cell_setup._make, tmp_path / "arm"

    def meanwhile(*given: Any) -> Any:
        folder.mkdir()
        (folder / "theirs").write_text("theirs")
        return made(*given)

    monkeypatch.setattr(cell_setup, "_make", meanwhile)
    words = ("init", folder, "--urdf", urdf, "--max-acceleration", "5", "--max-jerk", "50")
    refused(apc(*words), 3, f"{folder}: cannot be made: Directory not empty")
    assert [path.name for path in folder.iterdir()] == ["theirs"]
    assert [path for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_a_new_cell_has_no_name_of_a_shipped_one(urdf: Path, tmp_path: Path) -> None:
    made = apc("init", tmp_path / "panda_table", "--urdf", urdf, *LIMITS)
    refused(made, 3, "panda_table is a cell of this package, and scenes go by names; choose another one")
    assert not (tmp_path / "panda_table").exists()


def test_a_velocity_in_degrees_is_told_of(urdf: Path, tmp_path: Path) -> None:
    text = re.sub(r' velocity="[^"]*"', "", urdf.read_text()).replace("<limit ", '<limit velocity="180" ')
    changed = urdf.with_name("degrees.urdf")
    changed.write_text(text)
    made = apc("init", tmp_path / "arm", "--urdf", changed, *LIMITS[:4], "--json")
    (told,) = (each for each in json.loads(made.out)["left_to_fill_in"] if "max_velocity" in each)
    assert "the URDF states 180 rad/s, which no joint reaches: limits are in rad, not degrees; add" in told


def test_a_package_that_a_xacro_includes_and_that_is_nowhere_is_told_once(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    xacro = tmp_path / "a.xacro"
    namespace = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    xacro.write_text(f'<robot name="a" {namespace}><xacro:include filename="$(find lost)/b.xacro"/></robot>')
    made = apc("init", tmp_path / "arm", "--urdf", xacro)
    refused(made, 3, "xacro refuses it: package 'lost' was not found in the folders above the URDF; name")
    assert made.err.count("was not found") == 1
