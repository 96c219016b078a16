"""``apc verify`` and ``apc inspect``: argv against the library, exit codes, nothing half-written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from pickcli.commands import main as cli
from pickcli.motion.plan_file import motion_hash, read_plan, write_plan
from pickcli.scene.scene_file import scene_hash, write_scene
from pickcli.verification.verify import verify
from support.handmade_plans import cell, make_scene, pick


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    plan, scene = pick()
    paths = tmp_path / "plan.json", tmp_path / "scene.json"
    write_plan(plan, paths[0])
    write_scene(scene, paths[1])
    return paths


def run(monkeypatch: pytest.MonkeyPatch, *argv: object) -> int:
    monkeypatch.setattr("sys.argv", ["apc", *map(str, argv)])
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    assert isinstance(stopped.value.code, int)
    return stopped.value.code


def test_accepts_and_leaves_the_file_alone(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = files[0].read_bytes()
    assert run(monkeypatch, "verify", files[0], "--scene", files[1], "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["accepted"] and answer["certificate"]["motion_hash"] == motion_hash(pick()[0])
    assert files[0].read_bytes() == before


def test_write_puts_the_certificate_into_the_plan(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(monkeypatch, "verify", files[0], "--scene", files[1], "--write") == 0
    certificate = read_plan(files[0]).certificate
    assert certificate is not None and certificate.scene_hash == scene_hash(pick()[1])


def test_rejects_with_every_reason_and_exit_code_4(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, _ = pick()
    write_plan(replace(plan, events=plan.events[1:3]), files[0])
    before = files[0].read_bytes()
    assert run(monkeypatch, "verify", files[0], "--scene", files[1], "--write", "--json") == 4
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert not answer["accepted"] and answer["certificate"] is None and not answer["written"]
    assert {reason["where"] for reason in answer["error"]["reasons"]} == {
        "pump on",
        "valve off",
        "pump off",
    }
    assert "pump on: event missing" in err and "Traceback" not in err
    assert files[0].read_bytes() == before


def test_another_scene_is_stale(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_scene(make_scene(), files[1])
    assert run(monkeypatch, "verify", files[0], "--scene", files[1]) == 4
    err = capsys.readouterr().err
    assert scene_hash(pick()[1]) in err and scene_hash(make_scene()) in err


@pytest.mark.parametrize("argv", [("inspect", "nothing.h5"), ("verify", "no.json", "--scene", "no.json")])
def test_a_missing_file_is_bad_input(
    argv: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, *argv) == 3
    assert argv[1] in capsys.readouterr().err


def test_inspect_knows_plans_scenes_and_cells(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, scene = pick()
    for path, key, value in (
        (files[0], "motion_hash", motion_hash(plan)),
        (files[1], "scene_hash", scene_hash(scene)),
        (cell().path, "fingerprint", cell().fingerprint),
        (cell().name, "fingerprint", cell().fingerprint),
    ):
        assert run(monkeypatch, "inspect", path, "--json") == 0
        assert json.loads(capsys.readouterr().out)[key] == value
        assert run(monkeypatch, "inspect", path) == 0
        assert value in "".join(capsys.readouterr().out.split())  # a hash is longer than some lines


def test_inspect_says_no_more_of_a_certificate_than_it_knows(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whoever can write the file can seal it: only the verifier knows whether the plan is good."""
    plan, scene = pick()
    broken = replace(plan, segments=(replace(plan.segments[0], touching=("wall_left",)), *plan.segments[1:]))
    certificate = verify(plan, scene).certificate
    assert certificate is not None
    forged = replace(broken, certificate=replace(certificate, motion_hash=motion_hash(broken)))
    for each, said in ((plan, "none"), (forged, "its seal matches the plan")):
        write_plan(each, files[0])
        assert run(monkeypatch, "inspect", files[0]) == 0
        assert said in capsys.readouterr().out


@pytest.mark.parametrize(
    "content", [b"", b"hello", b"\x89HDF\r\n\x1a\n and no more", b'{"format": "apc plan"']
)
def test_inspect_refuses_what_it_does_not_know(
    content: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "thing"
    path.write_bytes(content)
    assert run(monkeypatch, "inspect", path) in (3, 4)
    err = capsys.readouterr().err
    assert str(path) in err and "Traceback" not in err
