"""Former spellings of options are still accepted, mean the same, and are in no help text."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from pickcli.commands import main as cli
from support.command_line import ITEM, Made, apc, misused, pick

FORMER = [
    ("plan-pick", "--to bin_F", "--into bin_F", "--scene s.json -o p.json"),
    ("execute", "--start home", "--from home", "plan.json --scene s.json"),
    ("execute", "--unverified", "--no-verify", "plan.json --scene s.json"),
    ("export", "--to csv", "--format csv", "plan.json --scene s.json -o p.csv"),
    ("inspect", "--plot r.html", "--picture r.html", "roadmap.h5"),
    ("build-roadmap", "--neighbours 4", "--nearest 4", "-o r.h5"),
]


def values(name: str, line: str) -> dict[str, object]:
    """The values of a command's parameters."""
    command = cli.apc.get_command(click.Context(cli.apc), name)
    assert command is not None
    return command.make_context(name, line.split()).params


@pytest.mark.parametrize(("name", "old", "new", "others"), FORMER)
def test_a_former_spelling_means_the_same(name: str, old: str, new: str, others: str) -> None:
    former, present = (values(name, f"{others} {option}") for option in (old, new))
    assert former == present
    assert set(map(str, present.values())) & {"True", *new.split()[1:]}


@pytest.mark.parametrize(
    ("name", "old"), [*((each[0], each[1]) for each in FORMER), ("plan-pick", "--pick x")]
)
def test_a_former_spelling_is_in_no_help(name: str, old: str) -> None:
    assert not re.search(rf"{old.split()[0]}\b", apc(name, "--help").out)


@pytest.mark.parametrize(("name", "old", "new", "others"), FORMER)
def test_a_former_spelling_beside_the_present_one(name: str, old: str, new: str, others: str) -> None:
    if " " in old:  # a flag may be repeated
        names = f"{new.split()[0]} and {old.split()[0]}"
        misused(apc(name, *others.split(), *old.split(), *new.split()), f"{names} mean the same; keep one")


def test_a_pick_in_its_former_spelling(made: Made, tmp_path: Path) -> None:
    former, present = tmp_path / "former.json", tmp_path / "present.json"
    assert apc("plan-pick", "--scene", made.scene, "--pick", f"bin_C:{ITEM}", "-o", former).code == 0
    assert pick(made.scene, present).code == 0
    assert apc("verify", former, "--scene", made.scene).code == 0
    assert hashes(former) == hashes(present)


def hashes(plan: Path) -> str:
    """What a plan is by its motion."""
    (line,) = [line for line in apc("inspect", plan).out.splitlines() if "motion_hash" in line]
    return line
