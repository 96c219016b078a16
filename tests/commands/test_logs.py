"""--verbose and --debug tell on stderr what is read and how long it takes, and change nothing else."""

from __future__ import annotations

import logging
import re
from pathlib import Path

import pytest

from pickcli.commands import main as cli
from pickcli.commands.logs import hide, show, stage
from support.command_line import Answer, Made, apc, refused


def _move(made: Made, out: Path, *more: object) -> tuple[object, ...]:
    return ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", out, *more)


def test_verbose_names_every_file_and_stage(made: Made, out: Path) -> None:
    answer = apc(*_move(made, out, "--verbose"))
    assert answer.code == 0
    for path in (made.scene, "cell.yaml", "robot.urdf", "apc2016.yaml"):
        assert re.search(rf"INFO .*read .*{re.escape(str(path))}: \d+ bytes", answer.err)
    for what in ("reading of the scene", "planning", "verification"):
        assert re.search(rf"INFO .*{what} took \d+\.\d+ s", answer.err)
    assert f"wrote {out}: {out.stat().st_size} bytes" in answer.err
    assert re.search(r"exit code 0 after \d+\.\d+ s\n$", answer.err)
    assert "DEBUG" not in answer.err


def test_without_it_nothing_is_logged_and_the_answer_is_the_same(made: Made) -> None:
    plain = apc("inspect", made.move)
    assert plain.err == "" and logging.getLogger("pickcli").handlers == []
    for flags in (("--verbose",), ("-v",), ("--debug",), ("-v", "--debug")):
        assert apc("inspect", made.move, *flags).out == plain.out
        assert apc(*flags, "inspect", made.move).out == plain.out
    assert apc("inspect", made.move).err == ""


def test_an_error_shows_its_place_in_the_code_only_when_debugging(made: Made) -> None:
    nowhere = ("inspect", made.move.with_name("none.json"))
    assert "Traceback" not in refused_text(apc(*nowhere)) + refused_text(apc(*nowhere, "-v"))
    told = refused_text(apc(*nowhere, "--debug"))
    assert "Traceback" in told and "InputError" in told and "inspect.py" in told


def refused_text(answer: Answer) -> str:
    """What a command that refused its input said on stderr."""
    assert answer.code == 3 and answer.out == ""
    return answer.err


def test_a_bad_request_is_one_message_without_them(out: Path) -> None:
    refused(apc("make-scene", "no.json", "-o", out), 3, "no.json: no such file")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_takes_them(name: str) -> None:
    text = apc(name, "--help").out
    assert "-v, --verbose" in text and "--debug" in text


def test_a_stage_that_fails_is_timed_too(capsys: pytest.CaptureFixture[str]) -> None:
    show(logging.INFO)
    show(logging.DEBUG)
    try:
        with pytest.raises(ValueError, match="no"), stage("work"):
            raise ValueError("no")
    finally:
        hide()
    told = capsys.readouterr().err
    assert "work begins" in told and re.search(r"work took \d", told) and told.count("\n") == 2
