"""Where the figures of a cell end: the last that is taken, and the first that is not."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from support.cell_copies import CellCopy

Refused = Callable[[Callable[[], object]], str]

ROW = "hanging_lip: 1.5188, floor_front: 1.3142, ceiling_front: 1.5418"


@pytest.mark.parametrize(
    ("old", "taken", "refused_", "problem"),
    [
        ("q: [0.1580, ", "q: [0.05, ", "q: [0.0499, ", "configurations[0].q[0]: expected rail in 0.05"),
        ("q: [0.1580, ", "q: [1.15, ", "q: [1.1501, ", "configurations[0].q[0]: expected rail in 0.05"),
        ("joint_s: {has", "joint_s: {max_position: 3.1415, has", "joint_s: {max_position: 3.1416, has",
         "joint_limits.joint_s.max_position: expected positions inside"),
        ("joint_s: {has", "joint_s: {min_position: -3.1415, has", "joint_s: {min_position: -3.1416, has",
         "joint_limits.joint_s.min_position: expected positions inside"),
        ("joint_s: {has", "joint_s: {min_position: -3, max_position: 3, has",
         "joint_s: {min_position: 3, max_position: 3, has", "got 3 to 3; correct them"),
        ("seal_time: 0.25", "seal_time: 10", "seal_time: 10.1", "tool.seal_time: expected s at rest"),
        ("max_velocity: 6.8,", "max_velocity: 60,", "max_velocity: 60.1,", "expected at most 60"),
        ("max_acceleration: 10.0,", "max_acceleration: 2000,", "max_acceleration: 2001,", "at most 2000"),
        ("max_jerk: 200.0", "max_jerk: 1000000", "max_jerk: 1000001", "expected at most 1e+06"),
        ("max_velocity: 1.0,", "max_velocity: 20,", "max_velocity: 20.1,", "limits are in m, not mm"),
        ("max_acceleration: 2.0,", "max_acceleration: 500,", "max_acceleration: 501,", "at most 500"),
        ("max_jerk: 40.0", "max_jerk: 100000", "max_jerk: 100001", "expected at most 100000"),
        ("[-1.354, -0.804, 0.751]", "[-1.318, -0.799, 0.751]", "[-1.3179, -0.799, 0.751]", "walls at x"),
        ("[-1.354, -0.804, 0.751]", "[-1.318, -0.799, 0.751]", "[-1.318, -0.7989, 0.751]", "walls at y"),
        ("[-0.737, -0.428, 0.781]", "[-0.773, -0.434, 0.781]", "[-0.7731, -0.434, 0.781]", "walls at x"),
        ("[-0.737, -0.428, 0.781]", "[-0.773, -0.434, 0.781]", "[-0.773, -0.4341, 0.781]", "walls at y"),
        (ROW, ROW.replace("1.5418", "1.5422"), ROW.replace("1.5418", "1.5424"), "board above, 1.5418 m"),
        (ROW, ROW.replace("1.5418", "1.5414"), ROW.replace("1.5418", "1.5412"), "board above, 1.5418 m"),
        ("  post: 0.4043", "  post: 0.1555", "  post: 0.1554", "beyond 0.1554 m (divider)"),
        ("  side_wall: 0.4277", "  side_wall: 0.4044", "  side_wall: 0.4043", "beyond 0.4043 m (post)"),
        ("  width: 0.8795", "  width: 0.8556", "  width: 0.8554", "beyond 0.4277 m (side_wall)"),
        ("  hanging_lip_depth: 0.0181", "  hanging_lip_depth: 0.0117", "  hanging_lip_depth: 0.0116",
         "beyond 0.0116 m (lip_depth)"),
        ("  back_wall: 0.4361", "  back_wall: 0.43", "  back_wall: 0.2", "m (floor_slope)"),
        ("  depth: 0.8842", "  depth: 0.4362", "  depth: 0.4361", "beyond 0.4361 m (back_wall)"),
        ("down: 1.5707963267948966}", "down: 1.5707963267}", "down: 1.6}", "tool.states: outside"),
        ("{straight: 0.0, down", "{straight: 0.001, down", "{straight: -0.1, down",
         "tool.states: outside"),
        ("down: 1.5707963267948966}", "down: 1.5707963276}", "down: 1.5707963280}", "tool.states: outside"),
        ("{straight: 0.0, down", "{straight: -0.9e-9, down", "{straight: -1.1e-9, down",
         "tool.states: outside"),
        ("joint_s: {has", "joint_s: {min_position: -3, max_position: 3, has",
         "joint_s: {min_position: 3, max_position: -3, has", "joint_limits.joint_s.max_position: expected"),
        ("joint_s: {has", "joint_s: {min_position: -3, max_position: 3, has",
         "joint_s: {min_position: -4, max_position: 3, has", "joint_limits.joint_s.min_position: expected"),
        ("  lance_link: lance\n", "  lance_link: lance \n", "  lance_link: link_t\n",
         "it ends link_t, lance, cup"),
        ("{name: table, lower", "{name: desk, lower", "{name: camera, lower",
         "the name 'camera' stands twice"),
        ("[bin_D, bin_E, bin_F]", "[bin_D, bin_E, bin_F ]", "[bin_D, bin_A, bin_F]", "'bin_A' stands twice"),
        ("{name: midway, kind", "{name: halfway, kind", "{name: tote, kind", "the name 'tote' stands twice"),
        ("cup_pivot: 20}", "cup_pivot: 21}", "cup_pivot: 20, elbow: 3}", "no moving joint is named 'elbow'"),
        ("joint_t: 15, cup_pivot: 20}", "joint_t: 16, cup_pivot: 20}", "joint_t: 15}",
         "robot.motor_forces.cup_pivot: expected a force"),
    ],
)  # fmt: skip
def test_a_figure_goes_as_far_as_stated_and_no_farther(
    cell_copy: CellCopy, refused: Refused, old: str, taken: str, refused_: str, problem: str
) -> None:
    cell_copy.yaml.replace(old, taken)
    cell_copy.load()
    cell_copy.yaml.replace(taken, refused_)
    assert problem in refused(cell_copy.load)


@pytest.mark.parametrize(
    ("limits", "taken", "refused_", "told"),
    [
        ("", 12.6, 12.61, "joint_t in -12.6 to 12.6 rad, got 12.61"),
        ("", -12.6, -12.61, "joint_t in -12.6 to 12.6 rad, got -12.61"),
        ("max_position: 4, ", 4, 4.001, "joint_t in -12.6 to 4 rad, got 4.001; correct it"),
        ("min_position: -4, ", -4, -4.001, "joint_t in -4 to 12.6 rad, got -4.001; correct it"),
        ("min_position: -4, max_position: 4, ", 4, 5, "joint_t in -4 to 4 rad, got 5"),
    ],
)
def test_a_joint_without_an_end_turns_twice_or_as_far_as_the_cell_says(
    cell_copy: CellCopy, refused: Refused, limits: str, taken: float, refused_: float, told: str
) -> None:
    cell_copy.urdf.replace(
        '<joint name="joint_t" type="revolute">', '<joint name="joint_t" type="continuous">'
    )
    cell_copy.yaml.replace("joint_t: {has_v", f"joint_t: {{{limits}has_v")
    home = "-1.9000, 0.0000, 0.0300, "
    cell_copy.yaml.replace(f"{home}0.0000]}}", f"{home}{taken}]}}")
    cell_copy.load()
    cell_copy.yaml.replace(f"{home}{taken}]}}", f"{home}{refused_}]}}")
    assert f"configurations[0].q[7]: expected {told}" in refused(cell_copy.load)


def test_a_tool_whose_cell_does_not_say_how_long_it_takes_to_seal_takes_a_quarter_of_a_second(
    cell_copy: CellCopy,
) -> None:
    cell_copy.yaml.replace("seal_time: 0.25", "seal_time: 0.5")
    assert cell_copy.load().robot.tool.cup.seal_time == 0.5
    cell_copy.yaml.replace("seal_time: 0.5", "")
    assert cell_copy.load().robot.tool.cup.seal_time == 0.25


def test_a_name_that_resembles_none_lists_the_known_ones(cell_copy: CellCopy, refused: Refused) -> None:
    cell_copy.yaml.replace("{a: carriage, b: rail_drive,", "{a: qqqq, b: rail_drive,")
    assert "no link is named 'qqqq'; known: arm_base, carriage, " in refused(cell_copy.load)


def test_one_mistake_is_one_line(cell_copy: CellCopy, refused: Refused) -> None:
    cell_copy.yaml.replace("{a: carriage, b: rail_drive,", "{a: qqqq, b: rail_drive,")
    assert len(refused(cell_copy.load).splitlines()) == 1


def test_a_file_that_is_no_cell_at_all_is_told_as_such(cell_copy: CellCopy, refused: Refused) -> None:
    for text in ("[1, 2]\n", "7\n", "name\n"):
        cell_copy.yaml.path.write_text(text)
        assert "cell.yaml:1:1: expected an object {...}, got " in refused(cell_copy.load)
