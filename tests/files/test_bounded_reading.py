"""Files from outside: regular, of a bounded size, and text where text is expected."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_bytes, read_kind, read_text, refuse_special_file
from pickcli.files.file_kind import HDF5_MAGIC, PLAN


def test_as_many_bytes_as_allowed_are_read_and_no_more(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(InputError, match="at most 4 bytes are read"):
        read_bytes(path, 4)


def test_a_file_that_is_missing_is_told_with_advice(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none: no such file; make one"):
        read_bytes(tmp_path / "none", 5, "make one")
    refuse_special_file(tmp_path / "none")


def test_nothing_but_regular_files_is_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "socket"))
        for path, kind in (
            (tmp_path / "pipe", "a pipe"),
            (tmp_path / "socket", "a socket"),
            (tmp_path, "a folder"),
            (Path("/dev/zero"), "a device"),
        ):
            with pytest.raises(InputError, match=f"is {kind}, not a regular file; check the name"):
                read_bytes(path, 5)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(InputError, match="loop: cannot be read"):
        read_bytes(loop, 5)


def test_text_is_utf8(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("gr\u00f6\u00dfer")
    assert read_text(path, 100) == "gr\u00f6\u00dfer"
    path.write_bytes(b"ab\xff")
    with pytest.raises(InputError, match="byte 2 is not UTF-8"):
        read_text(path, 100)


def test_a_mark_of_utf8_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_text("{}", encoding="utf-8-sig")
    assert read_text(path, 100) == "{}"


def test_a_file_of_another_kind_is_called_by_its_name_even_where_it_is_too_large(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(HDF5_MAGIC + bytes(100))
    with pytest.raises(InputError, match="is a roadmap or trajectory database, but a plan is expected here"):
        read_text(path, 20, wanted=PLAN)


def test_a_file_of_no_bytes_has_no_kind_and_is_called_empty(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.touch()
    with pytest.raises(InputError, match=f"^{path}: is empty; check the name"):
        read_kind(path)
