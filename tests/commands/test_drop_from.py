"""``--drop-from``: from over the rim a pick is shorter, lets go at rest, and ends there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import read_plan
from pickcli.motion.segment import SegmentKind
from support.command_line import apc

CRAYONS = "crayola_24_ct"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Crayons in bin_B."""
    path = tmp_path_factory.mktemp("drop_from") / "scene.json"
    assert apc("make-scene", "--in", f"bin_B={CRAYONS}", "--seed", "2", "-o", path).code == 0
    return path


def planned(scene: Path, drop_from: str, out: Path) -> Plan:
    query = ("plan-pick", "--bin", "bin_B", "--item", CRAYONS, "--scene", scene, "--drop-from", drop_from)
    answer = apc(*query, "-o", out)
    assert answer.code == 0, answer.err
    plan = read_plan(out)
    assert plan.certificate is not None
    return plan


def test_over_the_rim_the_arm_lets_go_at_rest_and_the_plan_ends(scene: Path, tmp_path: Path) -> None:
    inside, rim = (planned(scene, where, tmp_path / f"{where}.json") for where in ("inside", "rim"))
    assert SegmentKind.PLACE in {segment.kind for segment in inside.segments}
    assert rim.trajectory.duration < inside.trajectory.duration - 0.3
    close = next(e for e in rim.events if (e.device, e.action) == ("valve", "off"))
    assert close.t_trigger is not None
    later = rim.trajectory.times >= close.t_trigger
    assert np.allclose(rim.trajectory.positions[later], rim.trajectory.positions[-1])


def test_a_pick_from_over_the_rim_ends_in_the_tote(scene: Path, tmp_path: Path) -> None:
    planned(scene, "rim", tmp_path / "rim.json")
    played = apc("execute", tmp_path / "rim.json", "--scene", scene)
    assert played.code == 0, played.err
    assert "in tote" in played.out or "in the tote" in played.out


@pytest.mark.parametrize("command", ["plan-pick", "plan-stow", "plan-shift", "run-trial", "run-trials"])
def test_an_unknown_place_to_drop_from_is_refused(command: str) -> None:
    answer = apc(command, "--drop-from", "above")
    assert answer.code == 2
    assert "'above' is not one of 'inside', 'rim'" in " ".join(answer.err.split())
