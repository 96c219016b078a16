"""A file is the old one or the new one, whole: checked by failing every system call in turn."""

from __future__ import annotations

import fcntl
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes, write_text
from pickcli.files.bounded_reading import refuse_special_file

STEPS = ("fsync", "replace")


def test_text_is_written_and_replaced(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    write_text(path, "größer\n")
    write_text(path, "zweite\n")
    assert path.read_bytes() == b"zweite\n"
    assert [p.name for p in tmp_path.iterdir()] == ["file.txt"]


@pytest.mark.parametrize("step", STEPS)
def test_a_failure_leaves_the_old_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    path = tmp_path / "file.bin"
    write_bytes(path, b"old")

    def fail(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(InputError, match="No space left on device; it is left as it was"):
        write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["file.bin"]


def test_a_file_that_could_not_be_made_is_not_said_to_be_left(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file or directory; nothing was written"):
        write_bytes(tmp_path / "none" / "file.bin", b"new")


def test_an_interrupt_leaves_no_litter_either(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_bytes(tmp_path / "file", b"new")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none/file"):
        write_bytes(tmp_path / "none" / "file", b"")


def test_the_permissions_are_those_of_any_new_file(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.touch()
    write_bytes(tmp_path / "ours", b"")
    assert (tmp_path / "ours").stat().st_mode == plain.stat().st_mode


def _written_elsewhere(path: Path, at_sync: Callable[[], object]) -> int:
    """The id of a process that writes b"theirs" and does ``at_sync`` instead of each sync."""
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            with mock.patch.object(os, "fsync", lambda _: at_sync()):
                write_bytes(path, b"theirs")
            code = 0
        finally:
            os._exit(code)
    return pid


def test_what_a_killed_writer_left_goes_with_the_next_write(tmp_path: Path) -> None:
    path, other = tmp_path / "file", tmp_path / "file.more"
    for target in (path, other):
        os.waitpid(_written_elsewhere(target, lambda: os.kill(os.getpid(), signal.SIGKILL)), 0)
    assert len(list(tmp_path.glob(".file.*part"))) == 2 and not path.exists()
    write_bytes(path, b"ours")
    (left,) = set(tmp_path.iterdir()) - {path}
    assert path.read_bytes() == b"ours" and left.name.startswith(".file.more.")


def test_what_another_process_is_writing_stays(tmp_path: Path) -> None:
    path, (go_on, let), (is_there, tell) = tmp_path / "file", os.pipe(), os.pipe()
    pid = _written_elsewhere(path, lambda: (os.write(tell, b"."), os.read(go_on, 1)))
    os.read(is_there, 1)
    write_bytes(path, b"ours")
    left, content = list(tmp_path.glob(".file.*.part")), path.read_bytes()
    os.write(let, b"..")
    assert os.waitpid(pid, 0) == (pid, 0)
    assert len(left) == 1 and content == b"ours"
    assert path.read_bytes() == b"theirs" and list(tmp_path.iterdir()) == [path]


def test_a_part_that_is_taken_for_a_leftover_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[Path] = []

    def flock(*_: Any) -> None:
        if not taken:
            taken.extend(tmp_path.iterdir())
            taken[0].unlink()

    monkeypatch.setattr(fcntl, "flock", flock)
    write_bytes(tmp_path / "file", b"ours")
    assert taken and (tmp_path / "file").read_bytes() == b"ours"


def test_where_there_are_no_locks_files_are_written_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = tmp_path / ".file.1-1.part"
    left.touch()

    def flock(*_: Any) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(fcntl, "flock", flock)
    write_bytes(tmp_path / "file", b"ours")
    assert (tmp_path / "file").read_bytes() == b"ours" and left.exists()


def test_a_link_stays_and_what_it_points_to_is_written(tmp_path: Path) -> None:
    target, link = tmp_path / "folder" / "target", tmp_path / "link"
    target.parent.mkdir()
    link.symlink_to(target)
    for content in (b"new", b"newer"):
        write_bytes(link, content)
        assert link.is_symlink() and target.read_bytes() == content
    assert list(target.parent.iterdir()) == [target]


def test_what_is_no_regular_file_is_never_replaced(tmp_path: Path) -> None:
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for path, kind in (
        (pipe, "a pipe"),
        (link, "a pipe"),
        (tmp_path, "a folder"),
        (Path(os.devnull), "a device"),
    ):
        before = path.stat()
        with pytest.raises(InputError, match=f"is {kind}, not a regular file"):
            refuse_special_file(path)
        if path != Path(os.devnull):  # the machine's own is not put at stake
            with pytest.raises(InputError, match=f"is {kind}, not a regular file"):
                write_bytes(path, b"new")
        assert path.stat().st_ino == before.st_ino and path.stat().st_mode == before.st_mode


@pytest.mark.parametrize("has_links", [True, False])
def test_of_two_writers_of_a_new_file_the_first_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, has_links: bool
) -> None:
    def no_links(*_: Any) -> None:
        raise PermissionError(1, "Operation not permitted")

    if not has_links:
        monkeypatch.setattr(os, "link", no_links)
    path = tmp_path / "file"
    write_bytes(path, b"first", replace=False)
    with pytest.raises(InputError, match="exists by now"):
        write_bytes(path, b"second", replace=False)
    assert path.read_bytes() == b"first" and list(tmp_path.iterdir()) == [path]
