"""What stdout, names and the environment may be: full, closed, too long, without a home."""

from __future__ import annotations

import json
import os
import pwd
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from support.command_line import Made, apc, refused

APC = (sys.executable, "-m", "pickcli")


@pytest.mark.parametrize(
    "argv", [("--help",), ("inspect", "apc2016_delft"), ("inspect", "apc2016_delft", "--json")]
)
def test_a_full_disk_under_stdout_is_one_message(argv: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*APC, *argv], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 3
    assert done.stderr == "apc: error: output: No space left on device\n"


@pytest.mark.parametrize(
    ("argv", "code"), [(("inspect", "nothing.json"), 3), (("bogus",), 2), (("check",), 2)]
)
def test_a_full_disk_under_stderr_loses_the_message_and_keeps_the_exit_code(
    argv: tuple[str, ...], code: int
) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*APC, *argv], stdout=subprocess.PIPE, stderr=full, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (code, "")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_what_a_disk_takes_only_in_part_is_a_failure(unbuffered: str, tmp_path: Path) -> None:
    """Python as containers set it drops the rest of a short write without a word."""
    command = (
        f"ulimit -f 1; PYTHONUNBUFFERED={unbuffered} {shlex.join(APC)} inspect apc2016_delft --json > out"
    )
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert (tmp_path / "out").stat().st_size == 1024
    assert done.returncode == 3 and done.stderr == "apc: error: output: File too large\n"


def test_a_reader_that_has_heard_enough_is_no_failure() -> None:
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run(
        [*APC, "inspect", "apc2016_delft"], stdout=theirs, stderr=subprocess.PIPE, text=True, timeout=60
    )
    os.close(theirs)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1), (1, 2), (0, 1, 2)])
@pytest.mark.parametrize("what", ["order", "table", "help", "refusal"])
def test_closed_streams_are_no_bug(closed: tuple[int, ...], what: str, tmp_path: Path) -> None:
    out = tmp_path / "order.json"
    argv: dict[str, tuple[object, ...]] = {
        "order": ("make-order", "-o", out), "table": ("inspect", "apc2016_delft", "--json"),
        "help": ("--help",), "refusal": ("inspect", tmp_path / "none"),
    }  # fmt: skip
    closing = " ".join(f"{number}{'<' if number == 0 else '>'}&-" for number in closed)
    command = shlex.join([*APC, *map(str, argv[what])])
    done = subprocess.run(
        ["sh", "-c", f"exec {command} {closing}"], capture_output=True, text=True, timeout=60
    )
    assert "Traceback" not in done.stderr
    is_told = what == "refusal" or 1 in closed
    assert done.returncode == (3 if is_told else 0)
    assert done.stderr.count("error: ") == (is_told and 2 not in closed)
    assert out.exists() == (what == "order")
    if out.exists():
        assert json.loads(out.read_text())["work_order"]


def test_closed_streams_leave_a_plan_whole(made: Made, tmp_path: Path) -> None:
    out = tmp_path / "move.json"
    move = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", out)
    command = shlex.join([*APC, *map(str, move)])
    done = subprocess.run(["sh", "-c", f"exec {command} <&- >&- 2>&-"], timeout=60)
    assert done.returncode == 3
    assert apc("verify", out, "--scene", made.scene).code == 0


def test_names_that_are_too_long_are_named(made: Made, out: Path) -> None:
    name = "x" * 300
    for argv in (
        ("inspect", name),
        ("inspect", f"{name}.json"),
        ("make-scene", name, "-o", out),
        ("make-scene", f"{name}.json", "-o", out),
        ("make-scene", made.order, "--cell", name, "-o", out),
        ("verify", name, "--scene", made.scene),
        ("verify", made.plan, "--scene", name),
        ("run-trial", made.order, "--roadmap", name, "-o", out),
    ):
        refused(apc(*argv), 3, name[:60])


def test_a_user_without_a_home_is_told_what_to_set(
    made: Made, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_entry(user: int) -> None:
        raise KeyError(user)

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "")
    monkeypatch.setattr(pwd, "getpwuid", no_entry)
    move = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", out)
    refused(apc(*move), 3, "set HOME or XDG_CACHE_HOME")


def test_a_failure_is_told_in_json_too(made: Made, tmp_path: Path) -> None:
    """Usage, bad input, no plan, rejected and stale: one schema, the reasons included."""
    move = ("plan-move", "--scene", made.scene, "--json", "-o", tmp_path / "m.json", "--from", "home", "--to")
    edited = made.changed("plan", tmp_path, lambda p: p.update(certificate=None, events=[]))
    failures: tuple[tuple[tuple[object, ...], int, str], ...] = (
        (("plan-move", "--json"), 2, "MissingParameter"),
        (("make-order", "--json", "--seed", "1", "--seed", "2", "-o", "x"), 2, "UsageError"),
        ((*move, "bin_Q"), 3, "UnknownNameError"),
        ((*move, "tote_10h"), 5, "NoPlanError"),
        (("verify", edited, "--scene", made.scene, "--json"), 4, "RejectedError"),
    )
    for argv, code, kind in failures:
        answer = apc(*argv)
        told = json.loads(answer.out)
        assert (answer.code, told["exit_code"], told["command"]) == (code, code, argv[0])
        error = told["error"]
        assert error["kind"] == kind and error["message"].splitlines()[0] in answer.err
        assert bool(error["reasons"]) == (kind in ("NoPlanError", "RejectedError"))
        assert all(set(reason) == {"what", "where", "detail", "in_the_way"} for reason in error["reasons"])
    done = json.loads(apc("verify", made.plan, "--scene", made.scene, "--json").out)
    assert (done["command"], done["exit_code"], done["error"]) == ("verify", 0, None)


def test_an_interrupted_command_answers_in_json(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pickcli.commands.logs._log.debug", interrupt)  # a stage begins
    answer = apc("verify", made.plan, "--scene", made.scene, "--json")
    assert answer.code == 130 and json.loads(answer.out)["error"] == {
        "kind": "KeyboardInterrupt", "message": "the same command starts over", "reasons": [], "blockers": []
    }  # fmt: skip
