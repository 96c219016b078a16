"""Stacks from files: what they state is what the controller has, and every mistake is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from pickcli.control.stack_file import read_stack, stack_file
from pickcli.errors import InputError, UnknownNameError

GRASP = (data_path() / "stacks" / "grasp.yaml").read_text()


def test_the_stack_of_the_package_is_found_by_its_name_and_states_its_levels() -> None:
    found = read_stack(stack_file("grasp"))
    assert found.task_names == (("joint_limits",), ("obstacles",), ("envelope",), ("posture",))
    assert found.period == 0.01 and found.model.goal == "envelope"
    assert stack_file("mine.yaml") == Path("mine.yaml")
    with pytest.raises(UnknownNameError, match="did you mean 'grasp'"):
        stack_file("grap")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("{kind: joint_limits}", "{kind: joint_limits}, {kind: joint_limits}"), "joint_limits more"),
        (("gain: 3.0", "gain: 100.0"), "below 100, at which one period overshoots"),
        (("gain: 3.0", "gain: 0.0"), "greater than 0"),
        (("goal: envelope", "goal: obstacles"), "goal"),
        (("  - tasks: [{kind: envelope, gain: 3.0}]\n", ""), "among the tasks"),
        (("kind: envelope", "kind: reach"), "envelope, joint_limits, obstacles or posture, got \"reach\""),
        (("wanted: 0.006", "wanted: -0.006"), "wanted"),
        (("wanted: 0.006, ", ""), "wanted"),
        (("influence: 0.06", "influence: 0.001"), "an influence beyond what is wanted, got 0.001"),
        (("kind: envelope, ", ""), "envelope, joint_limits, obstacles or posture, got nothing"),
        (("gain: 3.0", "gane: 3.0"), "did you mean 'gain'"),
        (("version: 1", "version: 2"), "version"),
        (("period: 0.01", "period: 1.0"), "period"),
    ],
)  # fmt: skip
def test_mistakes_are_told(change: tuple[str, str], told: str, tmp_path: Path) -> None:
    path = tmp_path / "stack.yaml"
    assert change[0] in GRASP
    path.write_text(GRASP.replace(*change))
    with pytest.raises(InputError, match=told):
        read_stack(path)
