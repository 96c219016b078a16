"""What the guard lets through: what we write, to the last byte that is allowed, and nothing beside it."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pickcli.errors import DamagedError, InputError
from pickcli.files.file_kind import HDF5_MAGIC, STORE_END
from pickcli.roadmap.store import (
    FORMATS,
    describe,
    read_database,
    read_motion,
    read_roadmap,
    surveyed,
    write_database,
    write_roadmap,
)
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass
from pickcli.storage import table_writer
from pickcli.storage.integrity_scan import scan_integrity
from pickcli.storage.safe_open import (
    Dataset,
    _dataset,
    check_readable,
    open_datasets,
    opened,
    read_attributes,
)
from pickcli.storage.table_format import FileContent, FileFormat, Table
from pickcli.storage.table_reader import stored_file
from support.stored_samples import FINGERPRINT, MADE, database, roadmap

KIND = FileFormat("sample", 1, {"rows": Table({"name": "text", "size": "<f8"}, ("pieces",))})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "store.h5"


def _file(path: Path) -> Any:
    return h5py.File(path, "w", libver="latest")


# Files before they are opened


def test_a_file_of_half_a_gigabyte_is_opened_and_no_larger_one(path: Path) -> None:
    with open(path, "wb") as file:
        file.write(HDF5_MAGIC)
        file.truncate(512 * 2**20)
    check_readable(path)
    with open(path, "ab") as file:
        file.write(b"\0")
    with pytest.raises(InputError, match="larger than 512 MB"):
        check_readable(path)


@pytest.mark.parametrize(
    ("content", "error", "told"),
    [(b"{", InputError, "is a text file"), (b'{"a": 1,\n "b": 2}', InputError, "is a text file"),
     (b"x" * 200, InputError, "is a text file"), (b"", InputError, "is empty"),
     (HDF5_MAGIC[:4], InputError, "neither begins nor ends"),
     ("größe".encode(), InputError, "neither begins nor ends"),
     (random.Random(1).randbytes(5000), InputError, "neither begins nor ends"),
     (HDF5_MAGIC, DamagedError, "damaged"), (HDF5_MAGIC + bytes(100), DamagedError, "damaged"),
     (b"\x89hdf" + bytes(100) + STORE_END, DamagedError, "damaged")],
)  # fmt: skip
def test_only_what_begins_or_ends_like_a_stored_file_can_be_damaged(
    path: Path, content: bytes, error: type[Exception], told: str
) -> None:
    path.write_bytes(content)
    with pytest.raises(error, match=told), opened(path):
        pass


def test_a_cause_is_told_in_one_short_line(path: Path) -> None:
    _file(path).close()
    for cause, told in (("one\ntwo", "(one)"), ("x" * 1000, f"({'x' * 200})"), ("", "(ValueError)")):
        with pytest.raises(DamagedError) as caught, opened(path):
            raise ValueError(cause)
        assert told in str(caught.value)


# Attributes


def test_sixty_four_attributes_are_read_and_no_more(path: Path) -> None:
    with _file(path) as file:
        for i in range(64):
            file.attrs[f"a{i}"] = np.bytes_(f"value {i}".encode())
        assert read_attributes(file) == {f"a{i}": f"value {i}" for i in range(64)}
        file.attrs["one more"] = np.bytes_(b"x")
        with pytest.raises(ValueError, match="too many attributes"):
            read_attributes(file)


@pytest.mark.parametrize(
    "value", [3, 1.5, np.array([b"a", b"b"]), "of any length", np.bytes_(b"x" * (8 * 2**20 + 1))]
)
def test_attributes_are_short_strings_and_nothing_else(path: Path, value: Any) -> None:
    with _file(path) as file:
        file.attrs["a"] = value
        with pytest.raises(ValueError, match="is no short string"):
            read_attributes(file)


def test_an_attribute_has_up_to_8_megabytes(path: Path) -> None:
    with _file(path) as file:
        file.attrs["a"] = np.bytes_(b"x" * 8 * 2**20)
        assert read_attributes(file) == {"a": "x" * 8 * 2**20}


# Datasets


def test_rows_come_as_they_lie_in_the_file(path: Path) -> None:
    values = np.arange(12.0).reshape(4, 3)
    with _file(path) as file:
        file["pieces"] = values
        found = _dataset(file, "pieces", None, 96)
        assert isinstance(found, Dataset) and len(found) == 4
        np.testing.assert_array_equal(found.read(), values)
        np.testing.assert_array_equal(found.rows(1, 2), values[1:3])
        np.testing.assert_array_equal(found.rows(4, 0), values[4:])


def test_a_dataset_has_room_in_its_file(path: Path) -> None:
    with _file(path) as file:
        file["pieces"] = np.zeros((4, 3))
        assert len(_dataset(file, "pieces", None, 96)) == 4
        with pytest.raises(ValueError, match="declares more than the file holds"):
            _dataset(file, "pieces", None, 95)
        file.create_dataset("bomb", (10**9, 3), "<f8")  # contiguous, and nothing of it is there
        with pytest.raises(ValueError, match="declares more than the file holds"):
            _dataset(file, "bomb", None, 10**6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda f: f.__setitem__("data", h5py.SoftLink("/other")), "a link to elsewhere"),
        (lambda f: f.__setitem__("data", h5py.ExternalLink("other.h5", "/other")), "a link to elsewhere"),
        (lambda f: f.create_group("data"), "is no dataset"),
        (lambda f: f.create_dataset("data", (4, 3), "<f8", chunks=(1, 3)), "chunks or filters"),
        (lambda f: f.create_dataset("data", (4, 3), "<f8", compression="gzip"), "chunks or filters"),
        (lambda f: f.create_dataset("data", (4, 3), "<f8", external=[("o", 0, 96)]), "data elsewhere"),
        (lambda f: f.create_dataset("data", (4, 3), h5py.vlen_dtype(float)), "that numpy does not have"),
        (lambda f: f.create_dataset("data", (12,), "<f8"), "holds float64 of shape"),
        (lambda f: f.create_dataset("data", (2, 2, 3), "<f8"), "holds float64 of shape"),
        (lambda f: f.create_dataset("data", (4, 3), "<f4"), "holds float32 of shape"),
        (lambda f: f.create_dataset("data", (4, 3), ">f8"), "holds >f8 of shape"),
        (lambda f: f.create_dataset("data", (4, 3), "<i8"), "holds int64 of shape"),
    ],
)
def test_pieces_are_plain_tables_of_numbers(path: Path, make: Any, message: str) -> None:
    with _file(path) as file:
        file["other"] = np.zeros((4, 3))
        make(file)
        with pytest.raises(ValueError, match=message):
            _dataset(file, "data", None, 10**6)


def _row_type(**changes: Any) -> np.dtype[Any]:
    fields: dict[str, Any] = {"name": "S5", "size": "<f8", "pieces_first": "<i8", "pieces_count": "<i8",
                              "pieces_sha256": "S64", "row_sha256": "S64"}  # fmt: skip
    return np.dtype([(name, type_) for name, type_ in (fields | changes).items() if type_ is not None])


@pytest.mark.parametrize("width", [1, 4096])
def test_texts_are_of_any_reasonable_width(path: Path, width: int) -> None:
    with _file(path) as file:
        file.create_dataset("rows", (2,), _row_type(name=f"S{width}"))
        assert len(_dataset(file, "rows", KIND.tables["rows"], 10**6)) == 2


@pytest.mark.parametrize(
    "dtype",
    [
        _row_type(name="S4097"), _row_type(name="<f8"), _row_type(name=None), _row_type(size="<f4"),
        _row_type(size="S8"), _row_type(pieces_first="<i4"), _row_type(pieces_sha256="S63"),
        _row_type(row_sha256="S65"), _row_type(row_sha256=None), _row_type(more="<f8"), np.dtype("<f8"),
    ],
)  # fmt: skip
def test_rows_of_another_type_are_refused(path: Path, dtype: np.dtype[Any]) -> None:
    with _file(path) as file:
        file.create_dataset("rows", (2,), dtype)
        with pytest.raises(ValueError, match="rows holds"):
            _dataset(file, "rows", KIND.tables["rows"], 10**6)


def test_a_table_has_one_dimension(path: Path) -> None:
    with _file(path) as file:
        file.create_dataset("rows", (2, 1), _row_type())
        with pytest.raises(ValueError, match="rows holds"):
            _dataset(file, "rows", KIND.tables["rows"], 10**6)


def test_a_file_holds_all_that_its_kind_does_and_nothing_else(path: Path) -> None:
    with _file(path) as file:
        with pytest.raises(ValueError, match="it holds nothing, not what a sample does"):
            open_datasets(file, KIND, 10**6)
        file.create_dataset("rows", (2,), _row_type())
        with pytest.raises(ValueError, match="it holds rows, not what a sample does"):
            open_datasets(file, KIND, 10**6)
        file["pieces"] = np.zeros((4, 3))
        assert set(open_datasets(file, KIND, 10**6)) == {"rows", "pieces"}
        for i in range(100):
            file.create_group(f"more{i}")
        with pytest.raises(ValueError, match="it holds nothing, not what a sample does"):
            open_datasets(file, KIND, 10**6)


# Rows and the pieces that they own: checksums kept right by whoever wrote the file


def _with_places(monkeypatch: pytest.MonkeyPatch, piece: str, first: Any = 0, count: Any = 0) -> None:
    """From now on what is written says that pieces begin and end elsewhere."""
    places = table_writer._places

    def elsewhere(name: str, parts: Any) -> Any:
        found = places(name, parts)
        if name == piece:
            found[f"{name}_first"] = found[f"{name}_first"] + np.array(first)
            found[f"{name}_count"] = found[f"{name}_count"] + np.array(count)
        return found

    monkeypatch.setattr(table_writer, "_places", elsewhere)


@pytest.mark.parametrize(
    ("first", "count"),
    [
        ([1, 0, 0, 0, 0], 0), (1, 0), (-1, 0), (0, [0, 0, 1, 0, 0]), (0, [0, 0, 0, 0, -1]),
        (0, [0, 0, 0, 0, 1]), ([0, 0, 0, 0, 3], [0, 0, 0, 0, -3]), ([3, 0, 0, 0, 0], [-3, 0, 0, 0, 0]),
    ],
)  # fmt: skip
def test_pieces_are_divided_among_their_owners_without_gaps(
    path: Path, monkeypatch: pytest.MonkeyPatch, first: Any, count: Any
) -> None:
    _with_places(monkeypatch, "waypoints", first, count)
    write_roadmap(path, roadmap(), FINGERPRINT, MADE)
    for read in (read_roadmap, describe):
        with pytest.raises(DamagedError, match="waypoints are not divided among their owners"):
            read(path)


@pytest.mark.parametrize(("first", "count"), [(-5, 0), (100, 0), (2, 0), (0, 100), (0, -4), (-5, 3)])
def test_a_piece_outside_of_the_data_is_refused(
    path: Path, monkeypatch: pytest.MonkeyPatch, first: int, count: int
) -> None:
    """Alone, as one motion is read, and when every byte is looked at."""
    key = MotionKey("a", "b", PayloadClass.CUBE)
    _with_places(monkeypatch, "waypoints", [0, 0, first], [0, 0, count])
    write_database(path, database(), FINGERPRINT, MADE)
    with pytest.raises(DamagedError, match="waypoints of row 2 lie outside of the data"):
        read_motion(path, key)
    assert read_motion(path, MotionKey("b", "c", PayloadClass.EMPTY)) is not None
    with pytest.raises(DamagedError, match="not divided"):
        read_database(path)
    (damage,) = surveyed(path).damage
    assert damage.where == "waypoints of row 2 of motions" and damage.lost


def test_a_piece_may_begin_where_the_data_end_if_it_is_empty(path: Path) -> None:
    content = FileContent(FINGERPRINT, {}, ("x",), {"rows": {"name": ["a", "b"], "size": [1.0, 2.0]}},
                      {"pieces": [np.ones((2, 1)), np.zeros((0, 1))]})  # fmt: skip
    path.write_bytes(table_writer.to_bytes(KIND, content))
    with stored_file(path, KIND) as file:
        assert [len(file.piece("pieces", row)) for row in (0, 1)] == [2, 0]
        rows, offsets = file.pieces("pieces")
        assert (rows.tolist(), offsets.tolist()) == ([[1.0], [1.0]], [0, 2, 2])
        assert file.texts("rows", "name") == ("a", "b")
    found = scan_integrity(path, [KIND])
    assert found.damage == () and [len(row.pieces["pieces"]) for row in found.intact["rows"]] == [2, 0]


def test_columns_of_different_length_are_not_written(path: Path) -> None:
    content = FileContent(FINGERPRINT, {}, ("x",), {"rows": {"name": ["a"], "size": [1.0, 2.0]}},
                      {"pieces": [np.ones((2, 1)), np.zeros((0, 1))]})  # fmt: skip
    with pytest.raises(ValueError, match="the columns of rows are not equally long"):
        table_writer.to_bytes(KIND, content)


def test_rows_in_another_order_are_damage(path: Path) -> None:
    """Each row and piece is as it was written, but the table as a whole is not."""
    write_roadmap(path, roadmap(), FINGERPRINT, MADE)
    content = path.read_bytes()
    with h5py.File(path, "r") as file:
        nodes = file["nodes"][()]
    swapped = nodes[[1, 0, *range(2, len(nodes))]]
    assert content.count(nodes.tobytes()) == 1
    path.write_bytes(content.replace(nodes.tobytes(), swapped.tobytes()))
    with pytest.raises(DamagedError, match="the table nodes is not what its SHA-256 says"):
        read_roadmap(path)
    (damage,) = scan_integrity(path, FORMATS).damage
    assert (damage.where, damage.lost) == ("order of the rows of nodes", "nodes")
