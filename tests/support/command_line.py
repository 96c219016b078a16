"""``apc`` as its user meets it: argv in; exit code, stdout and stderr out."""

from __future__ import annotations

import contextlib
import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from pickcli.commands import main as cli

ITEM = "dove_beauty_bar"


@dataclass(frozen=True)
class Made:
    """Files that the commands made, to be copied before they are changed."""

    order: Path
    scene: Path
    plan: Path
    move: Path

    def changed(self, name: str, into: Path, change: Any) -> Path:
        """A copy of one of the files with ``change`` done to its JSON."""
        data = json.loads(getattr(self, name).read_text())
        change(data)
        path = into / f"changed_{name}.json"
        path.write_text(json.dumps(data))
        return path


@dataclass(frozen=True)
class Answer:
    """What one call of ``apc`` left: exit code and both streams."""

    code: int
    out: str
    err: str


def apc(*argv: object) -> Answer:
    """Run ``apc`` with these arguments, in this process. A bug's traceback comes out as the exception."""
    out, err = io.StringIO(), io.StringIO()
    streams = contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)
    with streams[0], streams[1], mock.patch.object(sys, "argv", ["apc", *map(str, argv)]):
        try:
            cli.main()
        except SystemExit as stopped:
            assert isinstance(stopped.code, int)
            return Answer(stopped.code, out.getvalue(), err.getvalue())
    raise AssertionError("main() ends by SystemExit")


def refused(answer: Answer, code: int, *told: str | Path) -> None:
    """One message on stderr that contains all of ``told``, nothing on stdout, and this exit code."""
    assert answer.code == code, answer.err
    assert answer.out == ""
    assert answer.err.count("error:") == 1 and "Traceback" not in answer.err
    assert [str(text) for text in told if str(text) not in answer.err] == [], answer.err


def misused(answer: Answer, *told: str) -> None:
    """Exit code 2 with click's message."""
    assert answer.code == 2 and answer.out == ""
    assert answer.err.count("Error:") == 1 and [text for text in told if text not in answer.err] == []


def pick(scene: Path, out: Path, *more: object) -> Answer:
    """Plan the pick of ITEM from bin_C."""
    return apc("plan-pick", "--scene", scene, "--bin", "bin_C", "--item", ITEM, "-o", out, *more)
