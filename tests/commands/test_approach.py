"""``--approach``: grasps of a region query in plans and summaries of picks and stows; what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.motion.plan_file import read_plan
from support.command_line import apc

BAR, CRAYONS = "dove_beauty_bar", "crayola_24_ct"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bar in the tote, and crayons in bin_B."""
    path = tmp_path_factory.mktemp("approach") / "scene.json"
    contents = ("--in", f"tote={BAR}", "--in", f"bin_B={CRAYONS}")
    assert apc("make-scene", *contents, "--seed", "2", "-o", path).code == 0
    return path


@pytest.mark.parametrize(
    "query",
    [
        ("plan-pick", "--bin", "bin_B", "--item", CRAYONS),
        ("plan-stow", "--item", BAR, "--into", "bin_H"),
        ("plan-shift", "--bin", "bin_B", "--item", CRAYONS, "--by=0,20"),
    ],
    ids=lambda query: query[0],
)
def test_a_plan_says_in_which_envelope_its_grasp_was_found(
    scene: Path, query: tuple[str, ...], tmp_path: Path
) -> None:
    found = {}
    for approach in ("lines", "region", "reactive", "lines-then-region"):
        out = tmp_path / f"{approach}.json"
        answer = apc(*query, "--scene", scene, "--approach", approach, "-o", out)
        assert answer.code == 0, answer.err
        plan = read_plan(out)
        assert plan.grasp is not None and plan.certificate is not None
        assert ("found in envelope" in answer.out) == bool(plan.grasp.envelope)
        found[approach] = plan.grasp.envelope
        assert ("transit_rolled_out" in plan.statistics) == (approach == "reactive")
    assert found["lines"] == "" and found["reactive"] == found["region"] != ""
    assert found["lines-then-region"] == ""  # a fixed candidate succeeds


@pytest.mark.parametrize("command", ["plan-pick", "plan-stow", "plan-shift", "run-trial", "run-trials"])
def test_an_unknown_approach_is_refused_with_the_known_ones(command: str) -> None:
    answer = apc(command, "--approach", "regions")
    assert answer.code == 2
    assert "'regions' is not one of 'lines', 'region', 'reactive', 'lines-then-region'" in " ".join(
        answer.err.split()
    )
