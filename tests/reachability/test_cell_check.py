"""A look at a cell: what is reached, what is in the way, and which allowed pairs hide a contact."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.kinematics.arm import Arm
from pickcli.reachability.cell_check import CellCheck, check_cell
from pickcli.reachability.place_reachability import PlaceReachability, ReachabilityCheck
from support.cell_copies import CellCopy

FEW = 6  # tool poses in every place


@pytest.fixture(scope="module")
def found(cell: Cell) -> CellCheck:
    return check_cell(load_workcell(cell.path), FEW)


def test_the_default_cell_reaches_its_places(found: CellCheck, cell: Cell) -> None:
    assert found.mistakes == () and found.warnings == ()
    assert [each.place for each in found.reaches] == list(cell.places)
    for each in found.reaches:
        assert len(each.tips) == FEW and each.configuration == each.place
        assert each.share >= 0.5 and each.share_in_line is not None
        assert each.share_in_line <= each.share


def test_the_tool_poses_are_inside_of_the_place(found: CellCheck, cell: Cell) -> None:
    assert len(found.reaches) and all(len(each.tips) for each in found.reaches)
    for each in found.reaches:
        place = cell.places[each.place]
        T_place_world = np.linalg.inv(cell.T_world_place(place))
        for tip in each.tips:
            assert place.holds((T_place_world @ [*tip, 1.0])[:3])


def test_a_seed_stands_for_one_answer(cell: Cell) -> None:
    def judged(seed: int) -> PlaceReachability:
        return ReachabilityCheck(cell, cell.robot.tool.default_state, FEW, seed).judged(cell.places["bin_C"])

    np.testing.assert_array_equal(judged(1).tips, judged(1).tips)
    assert not np.array_equal(judged(1).tips, judged(2).tips)


def test_out_of_reach_is_not_reached(cell: Cell) -> None:
    """Twice as far from the base as the arm is long, no inverse kinematics helps."""
    pod = cell.T_world_pod.copy()
    pod[0, 3] = 6.0
    away = replace(cell, T_world_pod=pod)
    (each,) = [
        r for r in ReachabilityCheck(away, cell.robot.tool.default_state, FEW).places() if r.place == "bin_A"
    ]
    tips = Arm(cell.robot).tips(
        np.stack([c.q for c in cell.configurations.values()]), cell.robot.tool.default_state
    )
    assert np.linalg.norm(each.tips[0] - tips[0][:3, 3]) > 4.0
    assert each.share == 0.0 and each.share_in_line == 0.0


def test_a_base_before_nothing_is_a_mistake(cell_copy: CellCopy) -> None:
    line = cell_copy.yaml.replace(
        "{xyz: [-1.758, 0, 0], rpy: [0, 0, 0]}", "{xyz: [-4.758, 0, 0], rpy: [0, 0, 0]}"
    )
    (mistake,) = check_cell(load_workcell(cell_copy.folder), 2).mistakes
    assert f"cell.yaml:{line}:3: robot.T_world_base: the arm reaches none of the 13 places" in mistake


def test_a_place_that_nothing_reaches_is_a_warning(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("[-1.315, -0.796, 0.580], upper: [-0.776, -0.437, 0.781]",
                           "[-1.315, -2.796, 0.580], upper: [-0.776, -2.437, 0.781]")  # fmt: skip
    cell_copy.yaml.replace("[-1.354, -0.804, 0.751], upper: [-0.737, -0.428, 0.781]",
                           "[-1.354, -2.804, 0.751], upper: [-0.737, -2.428, 0.781]")  # fmt: skip
    warnings = check_cell(load_workcell(cell_copy.folder), 4).warnings
    assert any("the arm reaches 0% of 4 tool poses in tote" in text for text in warnings)


@pytest.mark.parametrize(
    ("accepted", "needless"),
    [("slow_device:pump", False), ("slow_device", False), ("slow_device:pumpp", True), ("odd_angle", True)],
)
def test_what_is_accepted_and_never_given_is_told(cell_copy: CellCopy, accepted: str, needless: bool) -> None:
    cell_copy.yaml.replace("lead: 2.0", "lead: 20")
    given = "untested_pair:carriage-rail_drive"
    line = cell_copy.yaml.replace(f'["{given}"]', f'["{given}", "{accepted}"]')
    told = [
        text
        for text in check_cell(load_workcell(cell_copy.folder), 1).warnings
        if "accepted_warnings[" in text
    ]
    assert len(told) == needless
    if told:
        assert f"cell.yaml:{line}:" in told[0] and f"accepted_warnings[1]: {accepted} is not given" in told[0]
        assert f"add needless_acceptance:{accepted} to accepted_warnings" in told[0]


def test_an_allowed_pair_that_is_apart_hides_a_contact(cell_copy: CellCopy) -> None:
    line = cell_copy.yaml.replace(
        "  - {a: link_b, b: lance,",
        '  - {a: lance, b: table, reason: "they never meet"}\n  - {a: link_b, b: lance,',
    )
    (warning,) = check_cell(load_workcell(cell_copy.folder), 1).warnings
    assert f"cell.yaml:{line}:5: allowed_pairs[3]: lance and table are apart in " in warning
    assert "untested_pair:lance-table" in warning


def test_a_motor_that_does_not_bear_the_arm_is_told_where(cell_copy: CellCopy) -> None:
    line = cell_copy.yaml.replace("joint_e: 120,", "joint_e: 1,")
    (warning,) = check_cell(load_workcell(cell_copy.folder), 1).warnings
    assert f"cell.yaml:{line}:" in warning and "weak_motor:joint_e" in warning
    assert re.search(r"in \w+ [\d.]+ Nm bear the arm at rest, over 90% of its motor", warning)
