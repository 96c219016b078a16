"""The verifier's own judgement of how far a held item is tilted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.tool import MOVING
from pickcli.errors import Failures, InputError
from pickcli.motion.plan_file import motion_hash, read_plan, write_plan
from pickcli.planning.assembly.tilt_bound import why_tilted
from pickcli.verification.upright_check import check_upright
from pickcli.verification.verify import certifier
from support.belt_picks import belt_pick, context


def faults(degrees: float, **changes: object) -> list[str]:
    plan = replace(belt_pick().plan, upright=float(np.radians(degrees)), **changes)  # type: ignore[arg-type]
    return [str(each) for each in check_upright(plan, belt_pick().scene)]


def test_a_plan_without_a_bound_has_no_fault() -> None:
    assert not list(check_upright(belt_pick().plan, belt_pick().scene))


def test_a_bound_that_the_motion_passes_is_a_fault_and_a_wider_one_is_none() -> None:
    (fault,) = faults(30.0)
    assert "(transfer)" in fault and "by up to 40." in fault and "30.00 are allowed" in fault
    assert not faults(45.0)


@pytest.mark.parametrize("degrees", [39.0, 40.0, 40.2, 40.6, 41.0])
def test_it_agrees_with_the_planner_within_what_both_add_between_samples(degrees: float) -> None:
    planner = why_tilted(context().arm, belt_pick().plan, float(np.radians(degrees)))
    assert abs(degrees - 40.3) < 0.4 or (planner is None) == (not faults(degrees))


def test_a_certificate_is_refused_for_a_tighter_bound() -> None:
    pick = belt_pick()
    rejected = certifier(pick.scene)(replace(pick.plan, upright=0.5))
    assert isinstance(rejected, Failures) and "tilts the item" in str([*rejected])


def test_a_tool_that_changes_its_state_with_the_item_is_a_fault() -> None:
    segments = tuple(replace(each, tool_state=MOVING) for each in belt_pick().plan.segments)
    assert all("changes its state" in fault for fault in faults(45.0, segments=segments))
    assert faults(45.0, segments=segments)


def test_a_plan_that_holds_nothing_has_nothing_to_keep_upright() -> None:
    segments = tuple(replace(each, held=None) for each in belt_pick().plan.segments)
    assert "nothing is held" in faults(45.0, segments=segments)[0]


def test_the_bound_is_kept_in_the_file_and_in_the_hash_of_the_motion(tmp_path: Path) -> None:
    plan = replace(belt_pick().plan, upright=0.25, certificate=None)
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    assert read_plan(path).upright == 0.25
    assert motion_hash(plan) != motion_hash(replace(plan, upright=None))
    for value in ("0.0", "2.0", '"much"', "-0.1"):
        path.write_text(path.read_text().replace('"upright": 0.25', f'"upright": {value}'))
        with pytest.raises(InputError, match="upright"):
            read_plan(path)
        write_plan(plan, path)
