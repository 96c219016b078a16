"""What a file says to be, from its first bytes."""

from __future__ import annotations

import gzip
import time
from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from pickcli.errors import InputError
from pickcli.files.file_kind import (
    CELL,
    COMMISSION,
    DETECTED,
    DRIVE,
    DRIVING_AREA,
    GRASPS,
    HAND,
    HDF5_MAGIC,
    ITEMS,
    JOINT_LIMITS,
    KINDS,
    ORDER,
    PALLET,
    PERCEIVED,
    PLAN,
    REALITY,
    RECORDING,
    SCENE,
    SENSOR,
    SRDF,
    STACK,
    STACKED,
    STORE,
    STRATEGY,
    STREAM,
    TOTE,
    TRIAL,
    URDF,
    WATCH,
    WATCHED_DRIVE,
    WATCHED_SCENE,
    FileKind,
    kind_of,
    refuse_other_kind,
)

BEGINNINGS = [
    (HDF5_MAGIC + b'{"format": "apc plan"}', STORE),
    (b'{"format": "apc plan", "version": 2}', PLAN),
    (b'{\r\n\t"version": 1,\r\n\t"format" :\n "apc scene"', SCENE),
    (b"# a remark\nformat: apc cell\n", CELL),
    (b"format: 'apc items'\n", ITEMS),
    (b"format: apc sensor\nversion: 1\n", SENSOR),
    (b'version: 1\nformat: "apc reality"\n', REALITY),
    (b'{"format": "apc perceived", "version": 1}', PERCEIVED),
    (b'{"format": "apc tote", "version": 1}', TOTE),
    (b'{"format": "apc stream", "version": 1}', STREAM),
    (b'{"presented": 3, "made_from": {"format": "apc-stream-trial", "version": 3}}', TRIAL),
    (b"format: apc strategy\nversion: 1\n", STRATEGY),
    (b"format: apc stack\nversion: 1\n", STACK),
    (b"format: apc pallet\nversion: 1\n", PALLET),
    (b'{"format": "apc stacked pallet", "version": 1}', STACKED),
    (b"format: apc driving area\nversion: 1\n", DRIVING_AREA),
    (b'{"format": "apc drive", "version": 1}', DRIVE),
    (b"format: apc watch\nversion: 1\n", WATCH),
    (b"format: apc watched scene\nversion: 1\n", WATCHED_SCENE),
    (b'{"format": "apc watched drive", "version": 1}', WATCHED_DRIVE),
    (b'{"format": "apc detected pallet", "version": 1}', DETECTED),
    (b'{"format": "apc grasps", "version": 1}', GRASPS),
    (b"format: apc hand\nversion: 1\n", HAND),
    (b'{"format": "apc recording", "version": 1}', RECORDING),
    (b'{"format": "apc commission", "version": 1}', COMMISSION),
    (b'{"work_order": [], "bin_contents": {}}', ORDER),
    (b'{"score": 1, "max_score": 2}', TRIAL),
    (b'<?xml version="1.0"?>\n<robot name="a">', URDF),
    (b'<robot name="a"><disable_collisions link1="a" link2="b"/>', SRDF),
    (b"joint_limits:\n  joint_s:\n    max_velocity: 1.0\n", JOINT_LIMITS),
]


@pytest.mark.parametrize(("content", "kind"), BEGINNINGS, ids=lambda value: getattr(value, "name", ""))
def test_every_kind_is_told(content: bytes, kind: FileKind) -> None:
    assert kind_of(content) == kind
    refuse_other_kind(Path("f"), content, kind)
    for wanted in set(KINDS) - {kind}:
        with pytest.raises(InputError, match=f"^f: is {kind.name}, but {wanted.name} is expected here "):
            refuse_other_kind(Path("f"), content, wanted, is_whole=False)


def test_an_archive_is_called_that() -> None:
    for content, kind in BEGINNINGS:
        with pytest.raises(InputError, match=r"^f: is compressed by gzip; unpack it"):
            refuse_other_kind(Path("f"), gzip.compress(content), kind)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_a_text_in_utf_16_is_called_that(encoding: str) -> None:
    for content, kind in BEGINNINGS[1:]:
        with pytest.raises(InputError, match=r"^f: is text in UTF-16; save the file as UTF-8"):
            refuse_other_kind(Path("f"), content.decode().encode(encoding), kind)


def test_a_byte_order_mark_hides_no_kind() -> None:
    for content, kind in BEGINNINGS[1:]:
        assert kind_of(b"\xef\xbb\xbf" + content) == kind


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (
            b'{"format": "apc comission", "version": 1}',
            "unknown 'apc comission'; did you mean 'apc commission'",
        ),
        (
            b"format: apc drivingarea\nversion: 1\n",
            "unknown 'apc drivingarea'; did you mean 'apc driving area'",
        ),
        (b"format:\nversion: 1\n", "unknown ''; known: apc cell, "),
        (
            b'{"products": {}, "delivery": {}}',
            "missing; with 'products', 'delivery' it is a commission: ",
        ),
        (b"walls: {}\nstart: {}\ngoal: {}\n", ".* it is a driving area: add format: 'apc driving area'"),
        (b'{"conveyor": "belt", "speed": 0, "items": []}', "missing; .* it is a stream of items: add format"),
        (b"pallet: {}\ncartons: []\n", "missing; .* it is an order of a pallet: add format: 'apc pallet'"),
    ],
)
def test_a_wrong_or_missing_format_is_told_where_an_order_is_expected(content: bytes, told: str) -> None:
    for begin in (b"", b"\xef\xbb\xbf"):
        with pytest.raises(InputError, match=f"^f: format: {told}"):
            refuse_other_kind(Path("f"), begin + content, ORDER)
    refuse_other_kind(Path("f"), content, CELL)  # the reader of cells names its format


def test_an_order_with_an_unknown_key_is_left_to_its_reader() -> None:
    for content in (b'{"bin_contents": {}, "format": "x"}', b'{"contents": {}}', b"{}"):
        refuse_other_kind(Path("f"), content, ORDER)


def test_the_cases_are_all_kinds() -> None:
    assert {kind for _, kind in BEGINNINGS} == set(KINDS)


def test_the_files_of_the_data_folder_are_what_they_are() -> None:
    folders = {"cells/*/cell.yaml": CELL, "cells/*/*.urdf": URDF, "items/*": ITEMS}
    folders |= {"tasks/pr2_belt_*.json": STREAM, "tasks/apple_*.json": COMMISSION, "tasks/[!ap]*.json": ORDER}
    for pattern, kind in folders.items():
        assert {kind_of(path.read_bytes()) for path in data_path().glob(pattern)} == {kind}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{}",
        b'{"format": "apc of another make"}',
        b"# format: apc cell\n",
        b'{"remark": "the \\"work_order\\": of last year"}',
        b'{"bin_content": {}, "work_orders": []}',
    ],
)
def test_what_says_nothing_is_left_to_its_reader(content: bytes) -> None:
    assert kind_of(content) is None
    refuse_other_kind(Path("f"), content, SCENE)


@pytest.mark.parametrize("content", [b"\n" * 10**6, b" " * 10**6, b"{ " * 500_000, b'{"format' * 100_000])
def test_no_file_takes_long(content: bytes) -> None:
    start = time.process_time()
    assert kind_of(content) is None
    assert time.process_time() - start < 1.0


def test_a_file_of_another_kind_that_lacks_its_end_is_told_both() -> None:
    scene = b'{"format": "apc scene", "version": 1, "items": ['
    with pytest.raises(InputError, match="is a scene, cut off at its end, but a plan is expected here"):
        refuse_other_kind(Path("f"), scene, PLAN)
    for content, is_whole in ((scene + b"]}\n", True), (scene, False), (b"format: apc scene\n", True)):
        with pytest.raises(InputError, match="is a scene, but a plan is expected here"):
            refuse_other_kind(Path("f"), content, PLAN, is_whole)
