"""Every flipped bit has a place, and what is said to be intact is what was written."""

from __future__ import annotations

import hashlib
import random
import re
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.errors import ApcError, DamagedError, InputError, Reason, StaleError
from pickcli.files.file_kind import HDF5_MAGIC
from pickcli.roadmap.database_tables import DATABASE
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.recovered_content import intact_roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps
from pickcli.roadmap.store import (
    FORMATS,
    read_database,
    read_motion,
    read_roadmap,
    surveyed,
    write_database,
    write_roadmap,
)
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass, TrajectoryDatabase
from pickcli.storage.header_backup import RestoredFile, full_length, restored, with_backup
from pickcli.storage.integrity_scan import IntegrityReport, scan_integrity
from support.stored_samples import FINGERPRINT, JOINTS, MADE, database, roadmap

MISSING = ((MotionKey("a", "z", PayloadClass.EMPTY), Reason("no path", "a to z", "gave up")),)
WHY = MISSING[0][1]
GAPS = RoadmapGaps(
    refused=((("z",), WHY),), missing=((("a", "z"), WHY),), without_second_route=((("b", "z"), WHY),)
)


@pytest.fixture
def stored(tmp_path: Path) -> dict[str, Path]:
    paths = {kind.name: tmp_path / f"{kind.name}.h5" for kind in FORMATS}
    write_roadmap(paths["roadmap"], roadmap(), FINGERPRINT, MADE, GAPS)
    write_database(paths["trajectory database"], database(), FINGERPRINT, MADE, MISSING)
    return paths


def _flipped(path: Path, place: int, bit: int) -> Path:
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << bit
    other = path.with_name("flipped.h5")
    other.write_bytes(content)
    return other


@pytest.mark.parametrize("kind", [kind.name for kind in FORMATS])
def test_an_undamaged_file_is_intact_whole(kind: str, stored: dict[str, Path]) -> None:
    found = scan_integrity(stored[kind], FORMATS)
    assert found.damage == () and found.fingerprint == FINGERPRINT and found.made == MADE
    counts = {name: len(rows) for name, rows in found.intact.items()}
    expected = {
        "roadmap": {"nodes": 6, "edges": 5, "refused": 1, "missing": 1, "alone": 1},
        "trajectory database": {"motions": 3, "missing": 1},
    }
    assert counts == expected[kind]


@pytest.mark.parametrize("kind", [kind.name for kind in FORMATS])
def test_500_flipped_bits_are_all_found_and_never_served(kind: str, stored: dict[str, Path]) -> None:
    rng, path = random.Random(7), stored[kind]
    whole, size = scan_integrity(path, FORMATS), path.stat().st_size
    for _ in range(500):
        flipped = _flipped(path, rng.randrange(size), rng.randrange(8))
        found = surveyed(flipped)
        assert len(found.damage) == 1
        _assert_intact_rows_are_those_of(found, whole)
        _assert_read_or_refused(kind, flipped)


def _assert_intact_rows_are_those_of(found: IntegrityReport, whole: IntegrityReport) -> None:
    n_lost = 0
    for name, rows in whole.intact.items():
        written = {row.row.tobytes(): row.pieces for row in rows}
        for row in found.intact[name]:
            for piece, values in written[row.row.tobytes()].items():
                np.testing.assert_array_equal(row.pieces[piece], values)
        n_lost += len(rows) - len(found.intact[name])
    assert n_lost == sum(bool(damage.lost) for damage in found.damage) <= 1


def _assert_read_or_refused(kind: str, path: Path) -> None:
    try:
        if kind == "roadmap":
            np.testing.assert_array_equal(read_roadmap(path).waypoints, roadmap().waypoints)
        else:
            read = read_database(path, points=True)
            points = database().points
            assert read.points is not None and points is not None
            np.testing.assert_array_equal(read.points.positions, points.positions)
    except ApcError:
        pass


def test_one_motion_is_served_beside_a_damaged_one(stored: dict[str, Path]) -> None:
    path = stored["trajectory database"]
    content = path.read_bytes()
    # The second motion's first position, wherever it lies.
    row = list(database())[1].trajectory
    assert row is not None
    flipped = _flipped(path, content.index(np.concatenate([[0.0], row.positions[0]]).tobytes()) + 8, 3)
    motion = read_motion(flipped, next(iter(database())).key)
    assert motion is not None and motion.trajectory is not None
    with pytest.raises(DamagedError, match="points"):
        read_motion(flipped, list(database())[1].key)
    (damage,) = scan_integrity(flipped, FORMATS).damage
    assert (
        damage.where == "points of row 1 of motions"
        and damage.lost == "motions: b, c, empty, moving, nominal"
    )


def test_one_motion_is_found_in_both_directions(stored: dict[str, Path]) -> None:
    path, there = stored["trajectory database"], next(iter(database()))
    back = read_motion(path, there.key.reversed())
    assert back is not None and back.key == there.key.reversed()
    np.testing.assert_array_equal(back.path.waypoints, there.path.waypoints[::-1])
    assert read_motion(path, MotionKey("a", "nowhere", PayloadClass.EMPTY)) is None


def test_what_a_truncation_leaves_is_intact(stored: dict[str, Path]) -> None:
    path = stored["roadmap"]
    content, whole = path.read_bytes(), scan_integrity(path, FORMATS)
    n_told = n_edges = 0
    for size in range(0, len(content), max(1, len(content) // 80)):
        cut = path.with_name("cut.h5")
        cut.write_bytes(content[:size])
        try:
            found = surveyed(cut)
        except (DamagedError, InputError) as error:
            assert "its content is invalid" not in str(error)
            continue
        n_told += 1
        n_edges += len(found.intact["edges"])
        assert found.damage and all(
            len(found.intact[name]) <= len(rows) for name, rows in whole.intact.items()
        )
        assert all(edge.pieces["waypoints"].any() for edge in found.intact["edges"])
    assert n_told > 5 and n_edges > 0


def test_a_file_that_is_cut_off_is_called_that(stored: dict[str, Path]) -> None:
    path = stored["trajectory database"]
    content = path.read_bytes()
    length = int.from_bytes(content[28:36], "little")
    assert surveyed(path).cut_off == ""
    for n in (length - 1, length // 2):
        path.write_bytes(content[:n])
        told = f"cut off at byte {n} of at least {length}"
        assert surveyed(path).cut_off == told
        with pytest.raises(DamagedError, match=re.escape(f"{path}: damaged ({told})")):
            read_database(path)
    path.write_bytes(content[:200])
    with pytest.raises(DamagedError, match=f"beyond repair .cut off at byte 200 of at least {length}"):
        surveyed(path)


def test_edges_of_a_lost_node_are_intact_and_still_checked(stored: dict[str, Path]) -> None:
    path, name = stored["roadmap"], "node_ä3".encode()
    found = surveyed(_flipped(path, path.read_bytes().index(name), 0))
    assert len(found.intact["nodes"]) == 5 and not found.is_whole
    assert found.damage[0].where == "row 3 of nodes"
    kept = intact_roadmap(found)
    for edge in range(roadmap().n_edges):
        np.testing.assert_array_equal(kept.edge_path(edge), roadmap().edge_path(edge))
    write_roadmap(path, replace(roadmap(), lengths=np.ones(5)), FINGERPRINT, MADE)
    with pytest.raises(DamagedError, match=r"content is invalid \(the length of an edge"):
        surveyed(_flipped(path, path.read_bytes().index(name), 0))


@pytest.mark.parametrize("kind", [kind.name for kind in FORMATS])
def test_of_an_empty_file_nothing_is_senseless(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "empty.h5"
    if kind == "roadmap":
        write_roadmap(path, Roadmap.empty(JOINTS), FINGERPRINT, {})
    else:
        write_database(path, TrajectoryDatabase.of(JOINTS, []), FINGERPRINT, {})
    assert surveyed(path).is_whole


def test_a_directory_damaged_in_both_copies_is_beyond_repair(stored: dict[str, Path]) -> None:
    path = stored["roadmap"]
    content = bytearray(path.read_bytes())
    content[60] ^= 1
    content[-60] ^= 1
    path.write_bytes(content)
    with pytest.raises(DamagedError, match="beyond repair"):
        scan_integrity(path, FORMATS)


def test_other_kinds_and_versions_are_told_apart(stored: dict[str, Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a trajectory database, found roadmap"):
        scan_integrity(stored["roadmap"], [DATABASE])
    with pytest.raises(InputError, match="no such file"):
        scan_integrity(tmp_path / "nothing.h5", FORMATS)
    other = DATABASE.__class__(DATABASE.name, 99, DATABASE.tables)
    with pytest.raises(StaleError, match=f"of version {DATABASE.version}, this is version 99"):
        scan_integrity(stored["trajectory database"], [other])


@pytest.mark.parametrize(
    ("place", "copied", "is_believed"),
    [((4, 3), b"abc", True), ((4, 3), b"abcd", False), ((98, 3), b"abc", False), ((97, 3), b"abc", True)],
)
def test_a_backup_copy_that_does_not_fit_its_file_is_not_believed(
    place: tuple[int, int], copied: bytes, is_believed: bool
) -> None:
    """As written by someone who knows how to hash: it would be put beyond the file, or cut short."""
    image = bytes(28) + struct.pack("<Q", 100) + bytes(64)
    backup = zlib.compress(struct.pack("<QQQ", 1, *place) + copied)
    tail = struct.pack("<32sQ8s", hashlib.sha256(backup).digest(), len(backup), b"APCSPARE")
    found = restored(image + backup + tail)
    assert found.has_backup is is_believed
    assert not is_believed or found.image[slice(place[0], sum(place))] == copied


def test_only_of_a_file_that_is_cut_off_it_is_told_how_long_it_was() -> None:
    image = HDF5_MAGIC + bytes(20) + struct.pack("<Q", 100) + bytes(64)
    assert full_length(image[:99]) == full_length(image[:40]) == 100
    assert full_length(image) is full_length(image + b"more") is full_length(b"x" + image[1:99]) is None


def test_a_file_of_its_full_length_has_its_directory() -> None:
    image = bytes(28) + struct.pack("<Q", 100) + bytes(64)
    assert restored(image).has_directory
    cut = restored(image[:-1])
    assert not cut.has_directory and len(cut.image) == 100


def _backup(*places: tuple[int, int], copied: bytes, n: int | None = None) -> bytes:
    packed = b"".join(struct.pack("<QQ", *place) for place in places)
    backup = zlib.compress(struct.pack("<Q", len(places) if n is None else n) + packed + copied)
    return backup + struct.pack("<32sQ8s", hashlib.sha256(backup).digest(), len(backup), b"APCSPARE")


IMAGE = bytes(28) + struct.pack("<Q", 100) + bytes(64)


def test_a_backup_copy_is_put_back_where_it_came_from() -> None:
    image = bytearray(range(100))
    image[28:36] = struct.pack("<Q", 100)
    whole = with_backup(bytes(image), [(60, 20), (40, 10), (90, 0)])
    assert whole.startswith(bytes(image))
    assert restored(whole) == RestoredFile(bytes(image), True, True)
    for place in (0, 39, 50, 59, 80, 99):  # what is not data
        broken = bytearray(whole)
        broken[place] ^= 1
        assert restored(bytes(broken)) == RestoredFile(bytes(image), False, True)
    for place in (40, 49, 60, 79):  # data are not in it
        broken = bytearray(whole)
        broken[place] ^= 1
        assert restored(bytes(broken)) == RestoredFile(bytes(broken[:100]), True, True)
    for place in range(100, len(whole)):  # the backup itself
        broken = bytearray(whole)
        broken[place] ^= 1
        found = restored(bytes(broken))
        assert (found.image[:100], found.has_directory, found.has_backup) == (bytes(image), True, False)


def test_a_backup_copy_may_be_all_that_there_is() -> None:
    assert restored(with_backup(b"", [])) == RestoredFile(b"", True, True)


def test_a_backup_copy_is_no_larger_than_what_it_copies() -> None:
    image = bytes(100_000)
    assert len(with_backup(image, [(100, 99_900)])) < len(image) + 200


def test_the_same_file_gives_the_same_backup_whatever_the_order_of_its_data() -> None:
    assert with_backup(IMAGE, [(40, 10), (60, 20)]) == with_backup(IMAGE, [(60, 20), (40, 10)])


def test_between_data_that_lie_side_by_side_there_is_nothing_to_copy() -> None:
    assert with_backup(IMAGE, [(40, 10), (50, 10)]) == with_backup(IMAGE, [(40, 20)])
    assert with_backup(IMAGE, [(0, 40), (90, 10)]) == with_backup(IMAGE, [(0, 30), (30, 10), (90, 10)])


@pytest.mark.parametrize(
    "tail",
    [
        b"", b"APCSPARE", _backup((4, 3), copied=b"abc", n=2), _backup((4, 3), copied=b"abc", n=2**63),
        _backup((4, 3), copied=b"ab"), _backup((101, 0), copied=b""), _backup((0, 101), copied=b"x" * 101),
        _backup((4, 3), (98, 3), copied=b"abcdef"), _backup((4, 3), copied=b"abc")[:-1],
        _backup((4, 3), copied=b"abc") + b"x",
    ],
)  # fmt: skip
def test_a_tail_that_is_no_backup_copy_is_not_believed(tail: bytes) -> None:
    found = restored(IMAGE + tail)
    assert (found.image, found.has_directory, found.has_backup) == (IMAGE + tail, True, False)


def test_several_pieces_are_put_back_each_at_its_own_place() -> None:
    found = restored(IMAGE + _backup((4, 3), (50, 2), (98, 2), copied=b"abcdefg"))
    assert (found.image[4:7], found.image[50:52], found.image[98:]) == (b"abc", b"de", b"fg")
    assert found.image[:4] == IMAGE[:4] and found.image[7:50] == IMAGE[7:50]
    assert not found.has_directory and found.has_backup


def test_a_backup_copy_that_unpacks_to_over_64_megabytes_is_not_unpacked() -> None:
    size = 2**26
    assert not restored(bytes(size) + _backup((0, size), copied=bytes(size))).has_backup


def test_only_an_end_of_up_to_64_megabytes_is_filled_up() -> None:
    for missing, is_filled in ((1, True), (2**26, True), (2**26 + 1, False), (2**60, False)):
        cut = bytes(28) + struct.pack("<Q", 100 + missing) + bytes(64)
        found = restored(cut)
        assert len(found.image) == (100 + missing if is_filled else 100)
        assert not found.has_directory and not found.has_backup
    longer = IMAGE + b"more"
    assert restored(longer) == RestoredFile(longer, True, False)


def test_a_broken_row_is_told_by_its_names(stored: dict[str, Path]) -> None:
    path = stored["roadmap"]
    found = scan_integrity(_flipped(path, path.read_bytes().index("node_ä3".encode()), 0), FORMATS)
    assert len(found.damage) == 1 and found.damage[0].where == "row 3 of nodes"
    assert "down (if its name is right)" in found.damage[0].lost
    assert not found.is_whole
    assert [len(found.intact[name]) for name in ("nodes", "edges")] == [5, 5]


def test_a_description_that_was_edited_in_both_copies_is_beyond_repair(stored: dict[str, Path]) -> None:
    """By someone who packs the backup again, but does not seal the attributes."""
    path = stored["roadmap"]
    found = restored(path.read_bytes())
    path.write_bytes(found.image.replace(b"RRTstar", b"RRTSTAR"))
    with pytest.raises(DamagedError, match="beyond repair"):
        scan_integrity(path, FORMATS)
