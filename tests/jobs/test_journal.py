"""The journal gives back what was put in, whatever happens to its bytes."""

from __future__ import annotations

import hashlib
import os
import resource
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.jobs.journal import Journal

RECORDS = {("a", "b"): b"first", ("ö", "b", "c"): b"APCTASK\n" * 9, ("empty",): b"", ("long",): bytes(5000)}


@pytest.fixture
def journal(tmp_path: Path) -> Journal:
    filled = Journal(tmp_path / "out.h5", "f" * 64)
    for key, record in RECORDS.items():
        filled.append(key, record)
    return filled


def test_records_come_back(journal: Journal) -> None:
    assert journal.read() == RECORDS
    assert journal.path.parent == journal.path.parent and journal.path.name.startswith("out.h5.")
    journal.remove()
    assert journal.read() == {}
    journal.remove()


def test_other_inputs_have_another_journal(journal: Journal, tmp_path: Path) -> None:
    assert Journal(tmp_path / "out.h5", "e" * 64).read() == {}


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_costs_one_record_at_most(journal: Journal, where: float, bit: int) -> None:
    good = journal.path.read_bytes()
    content = bytearray(good)
    content[int(where * len(content))] ^= 1 << bit
    journal.path.write_bytes(content)
    left = journal.read()
    journal.path.write_bytes(good)
    assert left.items() <= RECORDS.items() and len(left) >= len(RECORDS) - 1


def test_a_torn_record_costs_itself_and_no_later_one(journal: Journal) -> None:
    whole = journal.path.read_bytes()
    for cut in range(0, len(whole), 37):
        journal.path.write_bytes(whole[:cut])
        before = journal.read()
        journal.append(("later",), b"later")
        assert journal.read() == before | {("later",): b"later"}
        assert before.items() <= RECORDS.items()


def test_two_processes_may_append_at_once(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; from pickcli.jobs.journal import Journal\n"
        "journal = Journal(Path(sys.argv[1]), 'f' * 64)\n"
        "for i in range(200): journal.append((sys.argv[2], str(i)), sys.argv[2].encode() * i)"
    )
    out = tmp_path / "out.h5"
    both = [subprocess.Popen([sys.executable, "-c", program, str(out), name]) for name in ("one", "two")]
    assert [process.wait() for process in both] == [0, 0]
    expected = {(name, str(i)): name.encode() * i for name in ("one", "two") for i in range(200)}
    assert Journal(out, "f" * 64).read() == expected


def test_a_full_disk_is_told_and_what_was_kept_stays(journal: Journal) -> None:
    before, limits = journal.read(), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (journal.path.stat().st_size + 100, limits[1]))
    try:
        with pytest.raises(InputError, match=r"File too large; make room and run the same command again"):
            journal.append(("big",), bytes(10_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert journal.read() == before
    journal.append(("big",), bytes(10_000))
    assert journal.read() == before | {("big",): bytes(10_000)}


def test_a_folder_that_is_removed_meanwhile_is_told(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "gone" / "out.h5", "f" * 64)
    with pytest.raises(InputError, match=r"gone: was removed during the run, .*; run the same command again"):
        journal.append(("a",), b"x")


def test_a_journal_that_cannot_be_read_is_an_input_error(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "out.h5", "f" * 64)
    os.mkdir(journal.path)
    with pytest.raises(InputError, match="cannot be read"):
        journal.read()


@pytest.mark.parametrize("name", [b"garbage", b"[1, 2]", b'{"a": 1}', b"\xff", b"[" * 100_000])
def test_a_record_without_the_name_of_a_task_is_skipped(journal: Journal, name: bytes) -> None:
    body = name + b"\nrecord"
    head = b"APCTASK\n" + struct.pack("<Q", len(body)) + hashlib.sha256(body).digest()
    journal.path.write_bytes(head + body + journal.path.read_bytes())
    assert journal.read() == RECORDS
