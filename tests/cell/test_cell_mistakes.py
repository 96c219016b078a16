"""Every kind of mistake in a cell file is told with file, line, key and what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.errors import UnknownNameError
from support.cell_copies import CellCopy

Refused = Callable[[Callable[[], object]], str]

LIMITS_L = (
    "joint_l: {has_velocity_limits: true, max_velocity: 2.2, "
    "has_acceleration_limits: true, max_acceleration: 5.0, has_jerk_limits: true, max_jerk: 100.0}"
)
HOME = "kind: home, tool_state: straight, q: [0.1580, "

MISTAKES = {
    "unknown key": (
        "clearance: 0.003",
        "clearence: 0.003",
        "clearence: unknown key; did you mean 'clearance'?",
    ),
    "unknown inner key": ("cup_stroke:", "stroke:", "tool.stroke: unknown key"),
    "missing key": ("  max_pull: 42.0", "", "tool.max_pull: expected N, got nothing; add it"),
    "wrong type": ("speed_scale: 1.0", "speed_scale: fast", "speed_scale: expected a factor in (0, 1]"),
    "text for a number": ("max_shear: 21.0", 'max_shear: "21.0"', "tool.max_shear: expected"),
    "impossible value": ("speed_scale: 1.0", "speed_scale: 1.5", "speed_scale: expected"),
    "flow of a valve": (
        "valve: {kind: valve, lead: 0.05,",
        "valve: {kind: valve, flow: 60, lead: 0.05,",
        "devices.valve: expected flow of a pump only, got valve; remove it",
    ),
    "flow in m3/s": ("flow: 600", "flow: 0.01", "devices.pump.flow: expected l/min of free air"),
    "negative size": ("cup_radius: 0.015", "cup_radius: -0.015", "tool.cup_radius: expected"),
    "switch for a number": ("max_moment: 0.6", "max_moment: true", "tool.max_moment: expected"),
    "trap of YAML 1.1": ("max_pull: 42.0", "max_pull: 0:42", "tool.max_pull: expected a number or text"),
    "a pod in mm": (
        "  width: 0.8795",
        "  width: 879.5",
        "pod.width: expected m, outside, along y: less than or equal",
    ),
    "lengths in mm": ("cup_length: 0.03 ", "cup_length: 30 ", "got 30; lengths are in m, not mm"),
    "a tool's speed in mm/s": (
        "speed_scale: 1.0",
        "max_tool_speed: 250\nspeed_scale: 1.0",
        "got 250; speeds are in m/s, not mm/s",
    ),
    "a negative tool speed": (
        "speed_scale: 1.0",
        "max_tool_speed: -0.5\nspeed_scale: 1.0",
        "max_tool_speed: expected m/s of the tool's tip, 0.01 to 10; none if left out: greater than or equal "
        "to 0.01, got -0.5; correct it",
    ),
    "a tool speed without its number": (
        "speed_scale: 1.0",
        "max_tool_speed:\nspeed_scale: 1.0",
        "max_tool_speed: expected a number, got nothing; give it in m/s, or leave the key out",
    ),
    "a tool that changes its state at once": (
        "kind: tool_actuator, lead: 0.4",
        "kind: tool_actuator, lead: 0",
        "expected over 0 s, which the tool takes",
    ),
    "leads in ms": ("lead: 2.0,", "lead: 2000,", "got 2000; times are in s, not ms"),
    "angles in degrees": ("down: 1.5707963267948966}", "down: 90}", "got 90; angles are in rad, not degrees"),
    "positions beyond the hall": (
        "xyz: [-1.758, 0, 0]",
        "xyz: [-1758, 0, 0]",
        "got -1758; lengths are in m, not mm",
    ),
    "speeds in degrees": (
        "max_velocity: 6.8,",
        "max_velocity: 390,",
        "joint_limits.joint_t.max_velocity: expected at most 60, got 390; limits are in rad, not degrees",
    ),
    "a speed with its unit": (
        "max_velocity: 6.8,",
        'max_velocity: "6.8 rad/s",',
        "write the number alone, in rad/s, or in m/s for a prismatic joint",
    ),
    "speeds in mm": ("max_velocity: 1.0,", "max_velocity: 1000,", "got 1000; limits are in m, not mm"),
    "numbers that nothing has": ("max_moment: 0.6", "max_moment: 1e308", "tool.max_moment: expected"),
    "a tote turned": (
        "inner: {lower: [-1.315, -0.796, 0.580], upper: [-0.776, -0.437, 0.781]}",
        "inner: {lower: [-0.796, -1.315, 0.580], upper: [-0.437, -0.776, 0.781]}",
        "tote.inner: puts the walls at x from -0.799 to -0.434, expected inside the flange's -1.354 to",
    ),
    "a URDF elsewhere": (
        "urdf: robot.urdf",
        "urdf: ../cell/../../robot.urdf",
        "robot.urdf: expected a path inside the cell's folder",
    ),
    "a URDF that no file can be called": (
        "urdf: robot.urdf",
        'urdf: "robot\\0.urdf"',
        "robot.urdf: expected the URDF's path, where there is one robot: text in one line",
    ),
    "limits that no file can be called": (
        "urdf: robot.urdf",
        'joint_limits: "limits\\0.yaml"\n  urdf: robot.urdf',
        "robot.joint_limits: expected",
    ),
    "an absolute URDF": ("urdf: robot.urdf", "urdf: /etc/passwd", "robot.urdf: expected a path inside"),
    "no acceleration limit": (
        "max_velocity: 1.0, has_acceleration_limits: true, max_acceleration: 2.0, ",
        "max_velocity: 1.0, has_acceleration_limits: true, ",
        "rail.max_acceleration: expected an acceleration limit in m/s2 or rad/s2, got nothing; state what",
    ),
    "acceleration limit switched off": (
        "max_velocity: 1.0, has_acceleration_limits: true",
        "max_velocity: 1.0, has_acceleration_limits: false",
        "joint_limits.rail.has_acceleration_limits: expected true (no limit is assumed)",
    ),
    "no limits of a joint": (
        LIMITS_L,
        "",
        "joint_limits.joint_l: expected velocity, acceleration and jerk limits",
    ),
    "limits of no joint": (
        "\n  joint_l: {has",
        "\n  joint_x: {has",
        "joint_limits.joint_x: no planned joint is named",
    ),
    "limits outside of the URDF's": (
        "joint_s: {has_velocity_limits",
        "joint_s: {max_position: 4, has_velocity_limits",
        "joint_limits.joint_s.max_position: expected positions inside the URDF's -3.1415 to 3.1415, "
        "got -3.1415 to 4",
    ),
    "joints out of order": (
        "joints: [rail, joint_s, joint_l,",
        "joints: [rail, joint_l, joint_s,",
        "robot.joints: expected the chain's moving joints but the tool's",
    ),
    "no force": ("rail: 1000, ", "", "robot.motor_forces.rail: expected a force"),
    "unknown link": (
        "cup_link: cup\n",
        "cup_link: cap\n",
        "tool.cup_link: no link is named 'cap'; did you mean 'cup'?",
    ),
    "unknown pair": (
        "{a: link_b, b: lance,",
        "{a: link_b, b: lanze,",
        "allowed_pairs[3].b: no link or obstacle is named 'lanze'",
    ),
    "pair without reason": (
        'reason: "the drive is part of the rail under the support of the arm"',
        'reason: ""',
        "allowed_pairs[2].reason",
    ),
    "same name twice": (
        "{name: cabinet_high,",
        "{name: cabinet_low,",
        "obstacles[3].name: the name 'cabinet_low' stands twice",
    ),
    "box inside out": (
        "lower: [-1.742, -0.934, 0.0]",
        "lower: [-0.5, -0.934, 0.0]",
        "obstacles[1]: expected lower under upper",
    ),
    "box of two numbers": (
        "lower: [-1.742, -0.934, 0.0]",
        "lower: [-1.742, -0.934]",
        "obstacles[1].lower: expected the lower corner",
    ),
    "boards that do not fit": (
        "ceiling_front: 1.5418",
        "ceiling_front: 1.5218",
        "pod.rows[1].ceiling_front: expected the underside of the board above, 1.5418 m",
    ),
    "lip under its floor": (
        "lip_top: 1.3250",
        "lip_top: 1.3050",
        "pod.rows[1]: expected floor_front < lip_top",
    ),
    "wall inside of the post": (
        "side_wall: 0.4277",
        "side_wall: 0.3277",
        "pod.side_wall: puts it at 0.3277 m, expected beyond 0.4043 m (post)",
    ),
    "legs that meet in the middle": (
        "legs: {width: 0.03545",
        "legs: {width: 0.44",
        "pod.legs.width: two legs of 0.44 m leave nothing open of the pod's width, 0.8795 m; correct one",
    ),
    "legs that meet front to back": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.45}",
        "pod.legs.depth: two legs of 0.45 m leave nothing open of the pod's depth, 0.8842 m; correct one",
    ),
    "legs that reach into the lowest row": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.020, height: 0.80}",
        "pod.legs.height: expected at most 0.7990 m, the underside of the lowest board, got 0.8; correct it",
    ),
    "legs that no camera sees": (
        "legs: {width: 0.03545",
        "legs: {width: 1e-9",
        "pod.legs.width: expected at least 0.01 m, which a camera sees as two pixels, got 1e-09; correct it",
    ),
    "legs as thin as paper": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.0001}",
        "pod.legs.depth: expected at least 0.01 m, which a camera sees as two pixels, got 0.0001; correct it",
    ),
    "legs of no height": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.020, height: 1e-9}",
        "pod.legs.height: expected at least 0.01 m, got 1e-09: nothing is open under the pod; correct it",
    ),
    "legs wider than the pod": (
        "legs: {width: 0.03545",
        "legs: {width: 0.95",
        "pod.legs.width: expected m along y, from the outside inwards: less than or equal to 0.5, got 0.95",
    ),
    "legs higher than the pod": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.020, height: 3.0}",
        "pod.legs.height: expected at most 0.7990 m, the underside of the lowest board, got 3; correct it",
    ),
    "legs in mm": (
        "legs: {width: 0.03545",
        "legs: {width: 35",
        "pod.legs.width: expected m along y, from the outside inwards",
    ),
    "legs without a height that is named": (
        "0.03545, depth: 0.020}",
        "0.03545, depth: 0.020, height: }",
        "pod.legs.height: expected a number, got nothing; give it in m, or leave the key out",
    ),
    "legs without figures": (
        "legs: {width: 0.03545, depth: 0.020}",
        "legs:",
        "pod.legs: expected its figures, got nothing; add them, or leave the key out",
    ),
    "unknown device kind": (
        "pump: {kind: pump",
        "pump: {kind: fan",
        "devices.pump.kind: expected pump, valve, sensor, tool_actuator or gripper",
    ),
    "too short configuration": (
        HOME,
        "kind: home, tool_state: straight, q: [",
        "configurations[0].q: expected 8 numbers, one per planned joint, got 7",
    ),
    "configuration outside": (
        HOME,
        HOME.replace("0.1580", "1.5800"),
        "configurations[0].q[0]: expected rail in 0.05 to 1.15 m, got 1.58; correct it; numbers stand",
    ),
    "another version": ("version: 2", "version: 3", "version: expected 2, the only version that is read"),
    "another format": ("format: apc cell", "format: apc cells", "format: expected 'apc cell'"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_file_line_and_key(cell_copy: CellCopy, refused: Refused, name: str) -> None:
    old, new, expected = MISTAKES[name]
    changed = cell_copy.yaml.replace(old, new) + old.startswith("\n")
    message = refused(cell_copy.load)
    first = message.splitlines()[0]
    assert expected in message
    file, _, column, _ = first.split(":", 3)
    assert file == str(cell_copy.yaml.path)
    assert int(column) >= 1
    missing = "nothing" in expected or name in ("no force", "no limits of a joint")
    assert missing or any(f"cell.yaml:{changed}:" in part for part in message.splitlines())


def test_all_mistakes_are_told_at_once(cell_copy: CellCopy, refused: Refused) -> None:
    cell_copy.yaml.replace("cup_radius: 0.015", "cup_radius: 0")
    cell_copy.yaml.replace("speed_scale: 1.0", "speed_scale: 2")
    cell_copy.yaml.replace("max_shear: 21.0", "max_sheer: 21.0")
    message = refused(cell_copy.load)
    assert all(
        key in message for key in ("tool.cup_radius", "speed_scale", "tool.max_sheer", "tool.max_shear")
    )


def test_of_a_value_forty_characters_are_told(cell_copy: CellCopy, refused: Refused) -> None:
    for n in (38, 39, 1000):  # and two quotes
        cell_copy.yaml.replace("max_pull: 42.0", f'max_pull: "{n * "x"}"')
        told = refused(cell_copy.load).split(", got ")[1].split(";")[0]
        assert told == ('"' + 38 * "x" + '"' if n == 38 else '"' + 36 * "x" + "...")
        cell_copy.yaml.replace(f'max_pull: "{n * "x"}"', "max_pull: 42.0")


def test_a_missing_urdf_is_named(cell_copy: CellCopy, refused: Refused) -> None:
    cell_copy.yaml.replace("urdf: robot.urdf", "urdf: robbot.urdf")
    assert "robot.urdf: 'robbot.urdf': no such file in the cell's folder" in refused(cell_copy.load)


def test_an_unknown_cell_names_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'apc2016_delft'"):
        load_cell("apc2016_delf")
    with pytest.raises(UnknownNameError):
        load_cell(tmp_path)


def test_a_cell_is_found_by_name_folder_and_file(cell_copy: CellCopy) -> None:
    prints = {
        load_cell(where).fingerprint for where in ("apc2016_delft", cell_copy.folder, cell_copy.yaml.path)
    }
    assert len(prints) == 1


def test_an_srdf_of_another_robot_is_none(cell_copy: CellCopy, refused: Refused) -> None:
    pair = '<disable_collisions link1="{}" link2="nothing" reason="Never"/>'
    line = cell_copy.yaml.replace("  urdf: robot.urdf\n", "  urdf: robot.urdf\n  srdf: other.srdf\n") + 1
    srdf = cell_copy.folder / "other.srdf"
    srdf.write_text(f'<robot name="other">{pair.format("lnk_b")}</robot>')
    said = "robot.srdf: names no link of the robot, e.g. 'lnk_b'; is it the SRDF of another one?"
    assert f"cell.yaml:{line}:3: {said}" in refused(cell_copy.load)
    srdf.write_text(f'<robot name="other">{pair.format("link_b")}</robot>')  # a part that is left out here
    cell_copy.load()
